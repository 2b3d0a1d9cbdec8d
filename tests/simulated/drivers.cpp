// Every driver in simulated time: with the faults of its stand-in (30 minutes with ENAMEL_LONG=1, otherwise 20 s), the
// tasks of `enamel compare`, and the first trial with single mistakes. This program replaces the clock of C++: driver,
// stand-in and loop see the time that the test advances.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>
#include <iterator>
#include <memory>
#include <random>
#include <thread>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/session/open_device.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/comparison.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/driver_rigs.hpp"
#include "support/first_touch_trial.hpp"
#include "support/run_length.hpp"
#include "support/stepped_device.hpp"

std::atomic<std::int64_t> enamel::test::clock_ns{1'000'000'000'000};

std::chrono::steady_clock::time_point std::chrono::steady_clock::now() noexcept {
  return time_point(std::chrono::nanoseconds(enamel::test::clock_ns.load()));
}

namespace enamel::test_drivers {

using test::clock_ns;
using test::openAt;
using test::Rig;
using test::SteppedDevice;

namespace {

constexpr double kPeriod = 1e-3, kHandPeriod = 1.0,
                 kHandWay = 4e-3;  // s, s, m: the hand moves by +-4 mm about the wall
constexpr double kRampOut = 0.1;   // s, after which a fault must have removed every force
constexpr double kRest = 0.3;      // s, from the end of a fault to the reset: nothing may come back before it

struct Result {
  std::map<std::string, int> faults;                     // begun
  std::array<int, kGuardReasons> latched{};              // faults of the guard
  std::uint64_t ticks = 0, inContact = 0, tooLarge = 0;  // tooLarge: forces above that of the device
  std::uint64_t late = 0, early = 0;        // forces more than kRampOut after a fault; and after it, before a reset
  std::string unexpected;                   // faults of the guard other than late and device
  int resets = 0, stretches = 0, felt = 0;  // free of faults for at least two periods of the hand; with contact
};

Result run(const Rig& rig, double duration) {
  OpenedDevice opened = openAt(rig.url);
  const double largest = opened.mechanism->limits().effort.head<3>().norm();
  SteppedDevice device(std::move(opened.device), rig, opened.poll > 0.0 ? opened.poll : kPeriod);
  PositionControlRenderer control(positionControlFor(*opened.mechanism, kPeriod, opened.delay.low, opened.delay.high));
  const Scene scene = flatWall();
  HapticTick haptics(*opened.mechanism, scene, Tool(), control, kPeriod);
  HapticLoopOptions options;
  options.period = opened.poll;
  std::mt19937_64 random(test::seed());
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  Result result;
  const Rig::Fault* active = nullptr;
  std::size_t begun = 0;
  double toggle = 3.0, latched = -1.0, ended = 0.0, free = 0.0;  // s: next change; times of events; -1: no fault
  std::uint64_t contactBefore = 0;
  LoopBody body(device, haptics, options);
  while (device.time() < duration) {
    const double now = device.time();
    rig.hold(kHandWay * std::cos(2.0 * M_PI * now / kHandPeriod) * Vec3::UnitZ(), 100.0, 5.0);
    if (now >= toggle) {
      if (active == nullptr) {
        active = &rig.faults[begun++ % rig.faults.size()];
        active->set(true);
        ++result.faults[active->name];
        toggle = now + between(0.002, 0.4);
        if (now - free > 2.0 * kHandPeriod) {
          ++result.stretches;
          if (result.inContact > contactBefore) ++result.felt;
        }
      } else {
        active->set(false);
        active = nullptr;
        ended = now;
        free = now + kRest;
        contactBefore = result.inContact;
        toggle = now + between(0.5, 5.0);
      }
    }
    const std::uint64_t before = body.tick().number;
    (void)body.step();
    const double force = rig.force().norm();
    if (!(force <= largest * (1.0 + 1e-9))) ++result.tooLarge;
    if (body.tick().number != before) {
      ++result.ticks;
      if (body.tick().mode == RenderMode::contact && body.tick().reason == GuardReason::none) ++result.inContact;
    }
    const GuardReason fault = haptics.guard().fault();
    if (fault == GuardReason::none) continue;
    if (latched < 0.0) {
      latched = now;
      ++result.latched[static_cast<std::size_t>(fault)];
      if (fault != GuardReason::late && fault != GuardReason::device)
        result.unexpected += std::string(toString(fault)) + " at " + std::to_string(now) + " s, " +
                             (active != nullptr ? "during " + active->name
                                                : std::to_string(now - ended) + " s after a fault of the device") +
                             "; ";
    }
    const bool isDeaf = active != nullptr && active->isDeaf;
    // After such a fault, the force ends with the next frame.
    const bool isHeard = !isDeaf && now > ended + 2.0 * kPeriod;
    if (now > latched + kRampOut && isHeard && force > 1e-6) ++(active != nullptr ? result.late : result.early);
    if (active != nullptr || now < std::max(ended, latched) + kRest) continue;
    if (const Status status = body.tick().device; status != Status::ok && status != Status::stale) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the host opens the device again in real time
      toggle = now + kRest;
      continue;
    }
    latched = -1.0;
    ++result.resets;
    body.reset();
    for (int i = 0; i < 40 && haptics.guard().fault() != GuardReason::none; ++i) (void)body.step();  // until a sample
  }
  return result;
}

void check(const std::string& name, const Rig& rig) {
  const double duration = test::count(20, 1800);
  const Result result = run(rig, duration);
  std::cout << name << ": " << duration << " s, " << result.ticks << " ticks, " << result.inContact
            << " in contact; faults of the device:";
  for (const auto& [fault, count] : result.faults) std::cout << ' ' << fault << ' ' << count << ',';
  std::cout << " of the guard:";
  for (std::size_t i = 0; i < result.latched.size(); ++i)
    if (result.latched[i] > 0) std::cout << ' ' << toString(static_cast<GuardReason>(i)) << ' ' << result.latched[i];
  std::cout << "; " << result.resets << " resets; " << result.felt << " of " << result.stretches
            << " stretches without faults with contact\n";
  CHECK(result.tooLarge == 0);
  CHECK(result.late == 0);
  CHECK(result.early == 0);
  CHECK(result.felt == result.stretches);
  CHECK(result.stretches > 0);
  CHECK(result.faults.size() == rig.faults.size());  // each fault came
  CHECK(result.unexpected == "");
}

// A driver between a virtual device and the loop of a study. The stand-in shows the sample of the virtual device, and
// the virtual device receives the force of the stand-in.
class ThroughDriver final : public HapticDevice {
 public:
  ThroughDriver(VirtualDevice& device, const Rig& rig)
      : device_(device), rig_(rig), opened_(openAt(rig.url)), begin_ns_(clock_ns + 2'000'000) {
    (void)take();
    clock_ns = begin_ns_ - 1'000'000;  // before the first tick
    opened_.device->open();
  }
  ~ThroughDriver() override { opened_.device->close(); }
  ThroughDriver(const ThroughDriver&) = delete;
  ThroughDriver& operator=(const ThroughDriver&) = delete;

  [[nodiscard]] Status measure(Measurement& m) noexcept override {
    if (const Status status = take(); status != Status::ok) return status;
    rig_.period();
    Status status = opened_.device->measure(m);
    if (rig_.await) rig_.await(*opened_.device, m, status);
    m.rates = sample_.rates;  // differences: the spring is stiffer than with the low pass of a driver
    m.time = sample_.time;    // the loop's clock, which goes on when a sample is lost
    return status;
  }
  [[nodiscard]] Status actuate(const Command& command) noexcept override {
    const std::uint64_t before = rig_.messages ? rig_.messages() : 0;
    if (const Status status = opened_.device->actuate(command); status != Status::ok) return status;
    while (rig_.messages && rig_.messages() == before) std::this_thread::yield();
    Command arrived{JointVector::Zero(command.effort.size())};
    arrived.effort.head<3>() = rig_.force();
    return device_.actuate(arrived);
  }

 private:
  Status take() noexcept {
    const Status status = device_.measure(sample_);
    clock_ns = begin_ns_ + std::llround(1e9 * device_.time());
    rig_.show(sample_);
    return status;
  }

  VirtualDevice& device_;
  const Rig& rig_;
  OpenedDevice opened_;
  std::int64_t begin_ns_;
  Measurement sample_;
};

// The tasks of `enamel compare`, with its forces scaled to the device as on the page, and its best spring there.
struct Tasks {
  double lowest, highest, preload, noise;  // of the push, N
  double stiffness, damping;               // of the best spring, N/m, N s/m
  int delay;                               // as the first trial measures it, ticks
  double ratio, imperfect;                 // of K_d: on the ideal plant (page), on the imperfect one
};

// The plan of pushes through a driver: position control for a delay, and the best spring.
StudyPlan pushesOf(const std::string& plant, const Rig& rig, const Tasks& tasks, const Delay& delay) {
  const DeviceParameters parameters = loadDevice(test::deviceFile(rig.file));
  StudyPlan plan;
  plan.scenarios = {1};
  plan.grid = 1;
  plan.runs = test::count(6, 20);
  plan.lowestForce = tasks.lowest;
  plan.highestForce = tasks.highest;
  plan.insideTick = true;
  plan.setup.seed = test::seed();
  plan.setup.hand.preload = tasks.preload;
  plan.setup.hand.noise = tasks.noise;
  plan.setup.encoders = {true, RateSource::difference};
  plan.setup.wrapper = [&rig](VirtualDevice& device) { return std::make_unique<ThroughDriver>(device, rig); };
  StudyColumn column;
  column.plant = makeMechanism(parameters);
  column.model = makeMechanism(modelFor(plant, parameters));
  column.makePlant = plantMaker(plant, parameters, {}, plan.setup);
  column.make = [model = column.model, delay](std::size_t) {
    return std::make_unique<PositionControlRenderer>(positionControlFor(*model, kPeriod, delay.low, delay.high));
  };
  plan.columns = {column, column};
  plan.columns[1].make = [&tasks](std::size_t) {
    return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{tasks.stiffness, tasks.damping});
  };
  return plan;
}

std::vector<StudyResult> resultsOf(const StudyPlan& plan) {
  std::vector<StudyResult> results;
  for (std::size_t i = 0; i < plan.size(); ++i) results.push_back(performRun(plan, runAt(plan, i)));
  return results;
}

void compareOn(const std::string& plant, const std::string& name, const Rig& rig, const Tasks& tasks) {
  const char* const mark = rig.url.find('?') == std::string::npos ? "?" : "&";
  const Delay delay = openAt(rig.url + mark + "delay=" + std::to_string(tasks.delay)).delay;
  StudyPlan plan = pushesOf(plant, rig, tasks, delay);
  const std::vector<StudyResult> results = resultsOf(plan);
  for (const StudyResult& r : results)
    if (isLost(r))
      std::cout << "  lost: column " << r.run.column << ", run " << r.run.run << ", " << r.run.force << " N, "
                << toString(r.status) << ", " << toString(r.metrics.verdict) << '\n';
  std::vector<RendererScore> scores = scoresOf(plan, results);
  plan.setup.hand.noise = 0.5;  // the trials scale it as their forces
  std::vector<std::string> trials = wallTrialNames();
  if (plant == kImperfect)  // the friction stops a thrown tool in front of the wall
    trials.erase(std::remove_if(trials.begin(), trials.end(),
                                [](const std::string& trial) { return trial.rfind("impact", 0) == 0; }),
                 trials.end());
  addWallTrials(plan, trials, 1, scores);
  const double control = spreadOf(scores[0].depthStiffness).mean, spring = spreadOf(scores[1].depthStiffness).mean;
  std::cout << name << ", plant " << plant << ", " << plan.runs << " runs a task; K_d of position control "
            << 1e-3 * control << " kN/m, of the spring " << 1e-3 * spring << " kN/m, ratio " << control / spring
            << "; pushes lost " << scores[0].lost << ", " << scores[1].lost << '\n';
  CHECK(scores[0].trials.size() > 13);
  for (std::size_t i = 0; i < scores[0].trials.size(); ++i) {
    const WallFigure &a = scores[0].trials[i], &b = scores[1].trials[i];
    std::cout << "  " << a.trial << ", " << a.figure << ": " << a.value << ' ' << a.unit << " (" << a.lost
              << " lost), spring " << b.value << " (" << b.lost << " lost)\n";
    INFO(a.trial);
    CHECK(a.lost == 0);
  }
  CHECK(scores[0].lost == 0);
  CHECK(control > 0.85 * (plant == kClosedForm ? tasks.ratio : tasks.imperfect) * spring);  // the page has more pushes
}

// On the ideal plant, and on the imperfect one if the file has its numbers.
void compare(const std::string& name, const Rig& rig, const Tasks& tasks) {
  compareOn(kClosedForm, name, rig, tasks);
  if (plantOf(loadDevice(test::deviceFile(rig.file))) == std::string(kImperfect))
    compareOn(kImperfect, name, rig, tasks);
}

// The first trial passes with the driver as it is, and names each single mistake of it; without `all` the first one.
void tryFirst(const std::string& name, const Rig& rig, bool hasMoments = false, bool all = test::longRun()) {
  const auto tried = [&](const test::Mistake& mistake) {
    OpenedDevice opened = openAt(rig.url);
    opened.device = std::make_unique<SteppedDevice>(std::move(opened.device), rig, kPeriod);
    return test::tryOut(std::move(opened), mistake, [&](const test::TrialHand& hand) {
      rig.hold(hand.place, hand.stiffness, 4.0);
      if (rig.turn) rig.turn(hand.turn, hand.gripper);
    });
  };
  const FirstTouchResult good = tried({});
  INFO(name << "\n" << good.report);
  CHECK(good.surprise.empty());
  CHECK(good.isComplete);
  int count = 0;
  test::forEachMistake(static_cast<bool>(rig.turn), hasMoments, hasMoments, [&](const test::Mistake& mistake) {
    if (count++ > 0 && !all) return;
    const FirstTouchResult result = tried(mistake);
    INFO(name << ", " << mistake.what << ", expected: " << mistake.words << "\n" << result.report);
    CHECK(test::names(result.surprise, mistake.words));
    CHECK_FALSE(result.isComplete);
  });
  std::cout << name << ": first trial, " << (all ? count : 1) << " mistakes named\n";
}

}  // namespace

#ifdef ENAMEL_DHD_STAND_IN
TEST_CASE("the Force Dimension driver in simulated time, with faults", "[drivers]") {
  test::DhdRig standIn;
  standIn.rig.faults = {{"early", [&](bool on) { standIn.set("early", on); }},
                        {"forces cut", [&](bool on) { standIn.set("forces", !on); }},
                        {"unplugged", [&](bool on) { standIn.set("unplugged", on); }}};
  check("forcedimension", standIn.rig);
}

TEST_CASE("tasks of the comparison through the Force Dimension driver", "[drivers]") {
  const test::DhdRig standIn;
  compare("omega.3", standIn.rig, {1.92, 3.6, 0.24, 0.12, 45.85e3, 118.9, 0, 1.69, 2.23});
}

TEST_CASE("position control learns the delay of the device", "[drivers]") {
  const test::DhdRig standIn;
  const Tasks tasks{1.92, 3.6, 0.24, 0.12, 45.85e3, 118.9, 0, 0.0, 0.0};
  for (const Delay& assumed : {Delay{0, 0}, Delay{0, 1}, Delay{1, 1}})
    for (int actual = 0; actual <= assumed.high + 2; ++actual) {
      StudyPlan plan = pushesOf(kClosedForm, standIn.rig, tasks, assumed);
      plan.columns.resize(1);
      plan.setup.delay = {actual, actual};
      const RendererScore score = scoresOf(plan, resultsOf(plan))[0];
      std::cout << "omega.3, assumed delay " << assumed.low << ".." << assumed.high << ", actual " << actual << ": "
                << score.lost << " of " << plan.size() << " pushes lost, K_d " << spreadOf(score.depthStiffness).mean
                << " N/m\n";
      CHECK(score.lost == 0);
    }
}

TEST_CASE("the first trial with the Force Dimension driver", "[drivers]") {
  tryFirst("omega.3", test::DhdRig(3).rig);
  tryFirst("omega.6", test::DhdRig(6).rig);
  tryFirst("sigma.7", test::DhdRig(7).rig, true, true);  // its mistakes are also those of the others
}
#endif

#ifdef ENAMEL_HD_STAND_IN
TEST_CASE("the OpenHaptics driver in simulated time, with faults", "[drivers]") {
  test::HdRig standIn;
  standIn.rig.faults = {{"stalled", [&](bool on) { standIn.set("stalled", on); }, true},
                        {"warm", [&](bool on) { standIn.set("warm", on); }},
                        {"unplugged", [&](bool on) { standIn.set("unplugged", on); }}};
  check("openhaptics", standIn.rig);
}

TEST_CASE("tasks of the comparison through the OpenHaptics driver", "[drivers]") {
  const test::HdRig standIn;
  compare("Touch", standIn.rig, {0.528, 0.99, 0.066, 0.033, 2.169e3, 15.91, 1, 1.50, 1.49});
}

namespace {

// The side of a bur, 60 mm in front of the hand, presses against a wall beside it. The hand turns the stylus to and fro
// by `turn` (rad), without motors. The bur must not get deeper than `most` (m).
void feelSide(double turn, double most) {
  const test::HdRig standIn;
  const Rig& rig = standIn.rig;
  OpenedDevice opened = openAt(rig.url);
  SteppedDevice device(std::move(opened.device), rig, kPeriod);
  constexpr double kRadius = 1e-3, kWall = -3e-3;      // m, along x
  constexpr double kPress = 5e-3, kStiffness = 100.0;  // m, N/m, of the hand
  Tool tool;
  tool.parts[0] = {Vec3(0.0, 0.0, -0.055), Vec3(0.0, 0.0, -0.060), kRadius};
  Scene scene;
  scene.add(halfSpace("wall", Vec3(kWall, 0.0, 0.0), Vec3::UnitX()));
  PositionControlRenderer control(positionControlFor(*opened.mechanism, kPeriod, 2, 2));
  HapticTick haptics(*opened.mechanism, scene, tool, control, kPeriod);
  LoopBody body(device, haptics, {});
  const double middle = kWall + kRadius;  // of the bur when it touches
  double deepest = 0.0, sum = 0.0, way = 0.0;
  int count = 0, inContact = 0;
  constexpr int kTicks = 6000, kSettled = 1000;
  for (int i = 0; i < kTicks; ++i) {
    // The hand is 5 mm behind the wall, then turns the stylus about y.
    rig.hold({middle - kPress, 0.0, 0.0}, kStiffness, 5.0);
    standIn.set("turn-y", i < kTicks / 2 ? 0.0 : turn * std::sin(2.0 * M_PI * kPeriod * (i - kTicks / 2)));
    (void)body.step();
    INFO("tick " << i << ": " << toString(haptics.guard().fault()));
    REQUIRE(haptics.guard().fault() == GuardReason::none);
    if (i < kSettled) continue;
    const Pose& pose = body.tick().pose;
    for (const Vec3& end : {tool.parts[0].a, tool.parts[0].b})
      deepest = std::max(deepest, middle - (pose.position + pose.rotation * end).x());
    if (body.tick().mode == RenderMode::contact) ++inContact;
    if (i >= kTicks / 2) continue;
    sum += rig.force().x();
    way += pose.position.x();
    ++count;
  }
  const double force = sum / count, place = way / count;
  std::cout << "side of a bur, turned by " << turn << " rad: deepest " << 1e3 * deepest << " mm, mean force " << force
            << " N, hand at " << 1e3 * place << " mm, in contact in " << inContact << " of " << kTicks - kSettled
            << " ticks\n";
  // The wall holds the bur against the hand's spring, up to the friction of the device (0.26 N).
  CHECK(std::abs(force - kStiffness * (place - (middle - kPress))) < 0.26);
  CHECK(deepest < most);
  CHECK(inContact > (kTicks - kSettled) / 2);
}

}  // namespace

TEST_CASE("a stylus feels the side of a bur at the end of a tool of 60 mm", "[drivers]") {
  feelSide(0.05, 0.5e-3);
  feelSide(0.1, 1e-3);
}

TEST_CASE("the first trial with the OpenHaptics driver", "[drivers]") { tryFirst("Touch", test::HdRig().rig); }
#endif

#ifdef ENAMEL_HAPLY_SERVICE
TEST_CASE("the Haply driver in simulated time, with faults", "[drivers]") {
  test::HaplyRig standIn;
  test::HaplyService& service = standIn.service;
  const auto silent = [&](std::atomic<bool>& fault) { return [&](bool on) { fault = standIn.isSilent = on; }; };
  standIn.rig.faults = {{"no device", silent(service.isUnplugged)},
                        {"garbage", silent(service.isGarbage)},
                        {"shuffled", [&](bool on) { service.isShuffled = on; }},
                        {"slow", [&](bool on) { service.isSlow = on; }},
                        {"closed", [&](bool on) { service.isClosing = standIn.isSilent = on; }}};
  check("haply", standIn.rig);
}

TEST_CASE("tasks of the comparison through the Haply driver", "[drivers]") {
  const test::HaplyRig standIn;
  compare("Inverse3", standIn.rig, {0.96, 1.8, 0.12, 0.06, 6.25e3, 38.56, 1, 2.01, 1.62});
}

// Each takes seven seconds, because every tick passes through a socket.
TEST_CASE("the first trial with the Haply driver", "[drivers]") { tryFirst("Inverse3", test::HaplyRig().rig); }
#endif

}  // namespace enamel::test_drivers
