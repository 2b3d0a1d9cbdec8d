// Every driver in simulated time: with the faults of its stand-in (30 minutes with ENAMEL_LONG=1, otherwise 20 s), and
// pushes of position control and of the best spring. This program replaces the clock of C++: driver, stand-in and loop
// see the time that the test advances.
#include <atomic>
#include <chrono>
#include <iostream>
#include <memory>
#include <random>
#include <thread>

#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/session/open_device.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/driver_bench.hpp"
#ifdef ENAMEL_HAPLY_SERVICE
#include "support/haply_service.hpp"
#endif
#include "support/run_length.hpp"

namespace {
std::atomic<std::int64_t> clock_ns{1'000'000'000'000};
}

std::chrono::steady_clock::time_point std::chrono::steady_clock::now() noexcept {
  return time_point(std::chrono::nanoseconds(clock_ns.load()));
}

namespace enamel::test_drivers {

using test::openAt;

namespace {

constexpr double kPeriod = 1e-3, kHandPeriod = 1.0,
                 kHandWay = 4e-3;  // s, s, m: the hand moves by +-4 mm about the wall
constexpr double kRampOut = 0.1;   // s, after which a fault must have removed every force
constexpr double kRest = 0.3;      // s, from the end of a fault to the reset: nothing may come back before it

// A stand-in as the test sees it.
struct Rig {
  std::string url;
  double largest = 0.0;                                                  // force of the device, N
  std::function<void()> period;                                          // one period of the stand-in has passed
  std::function<double()> force;                                         // that the stand-in received, N
  std::function<void(double)> place = {};                                // of the hand, m
  std::function<void(HapticDevice&, Measurement&, Status&)> await = {};  // an answer that comes in real time
  struct Fault {
    std::string name;
    std::function<void(bool)> set;
    bool isDeaf = false;  // commands do not arrive, and the vendor keeps the last force
  };
  std::vector<Fault> faults = {};
  std::function<void(double)> push = {};  // of the hand against W's z, N
  std::function<double(bool)> path = {};  // lowest or mean z since restart, m
  std::function<void()> restart = {};     // of the path
};

// The device of a driver: each measure() is a step of the simulated time.
class SteppedDevice final : public HapticDevice {
 public:
  SteppedDevice(HapticDevice& device, const Rig& rig, double step) : device_(device), rig_(rig), step_(step) {}
  void open() override { device_.open(); }
  void close() noexcept override { device_.close(); }
  [[nodiscard]] Status measure(Measurement& m) noexcept override {
    clock_ns += static_cast<std::int64_t>(1e9 * step_);
    steps_ += step_;
    if (rig_.place) rig_.place(kHandWay * std::cos(2.0 * M_PI * steps_ / kHandPeriod));
    if ((passed_ += step_) > 0.999 * kPeriod) {
      passed_ = 0.0;
      rig_.period();
    }
    Status status = device_.measure(m);
    if (rig_.await) rig_.await(device_, m, status);
    return status;
  }
  [[nodiscard]] Status actuate(const Command& command) noexcept override { return device_.actuate(command); }
  double time() const noexcept { return steps_; }

 private:
  HapticDevice& device_;
  const Rig& rig_;
  double step_, steps_ = 0.0, passed_ = 0.0;  // s
};

// Position control, or a spring, at a flat wall through a driver.
struct DriverLoop {
  OpenedDevice opened;
  std::unique_ptr<Renderer> renderer;
  Scene scene = flatWall();
  Tool tool;
  SteppedDevice device;
  HapticTick haptics;
  HapticLoopOptions options;

  explicit DriverLoop(const Rig& rig, const ImpedanceOptions* spring = nullptr)
      : opened(openAt(rig.url)),
        renderer(rendererFor(opened, spring)),
        device(*opened.device, rig, opened.poll > 0.0 ? opened.poll : kPeriod),
        haptics(*opened.mechanism, scene, tool, *renderer, kPeriod) {
    options.period = opened.poll;
  }

 private:
  static std::unique_ptr<Renderer> rendererFor(const OpenedDevice& opened, const ImpedanceOptions* spring) {
    if (spring != nullptr) return std::make_unique<ImpedanceRenderer>(*spring);
    return std::make_unique<PositionControlRenderer>(
        positionControlFor(*opened.mechanism, kPeriod, opened.delay.low, opened.delay.high));
  }
};

struct Result {
  std::map<std::string, int> faults;                     // begun
  std::array<int, kGuardReasons> latched{};              // faults of the guard
  std::uint64_t ticks = 0, inContact = 0, tooLarge = 0;  // tooLarge: forces above that of the device
  std::uint64_t late = 0, early = 0;          // forces more than kRampOut after a fault; and after it, before a reset
  std::string unexpected;                     // faults of the guard other than late and device
  int restarts = 0, stretches = 0, felt = 0;  // free of faults for at least two periods of the hand; with contact
};

Result run(const Rig& rig, double duration) {
  DriverLoop loop(rig);
  SteppedDevice& device = loop.device;
  HapticTick& haptics = loop.haptics;
  std::mt19937_64 random(test::seed());
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  Result result;
  const Rig::Fault* active = nullptr;
  std::size_t begun = 0;
  double toggle = 3.0, latched = -1.0, ended = 0.0, free = 0.0;  // s: next change; times of events; -1: no fault
  std::uint64_t contactBefore = 0;
  while (device.time() < duration) {
    LoopBody body(device, haptics, loop.options);
    while (device.time() < duration) {
      const double now = device.time();
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
      const double force = rig.force();
      if (!(force <= rig.largest * (1.0 + 1e-9))) ++result.tooLarge;
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
      latched = -1.0;
      const Status status = body.tick().device;
      if (fault == GuardReason::device || (status != Status::ok && status != Status::stale)) break;  // start again
      body.reset();
      for (int i = 0; i < 8 && haptics.guard().fault() != GuardReason::none; ++i) (void)body.step();
    }
    ++result.restarts;
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
  std::cout << "; " << result.restarts << " starts; " << result.felt << " of " << result.stretches
            << " stretches without faults with contact\n";
  CHECK(result.tooLarge == 0);
  CHECK(result.late == 0);
  CHECK(result.early == 0);
  CHECK(result.felt == result.stretches);
  CHECK(result.stretches > 0);
  CHECK(result.faults.size() == rig.faults.size());  // each fault came
  CHECK(result.unexpected == "");
}

// The task push of `enamel compare` through a driver: rest under a preload, then a step of force.
struct Pushes {
  double preload, force, noise;  // N
  double stiffness, damping;     // of the best spring (lib/docs/devices.md), N/m, N s/m
};

// Mean depth stiffness of pushes, N/m. Each begins at another moment of a tick.
double depthStiffness(const Rig& rig, const Pushes& pushes, bool isSpring) {
  const ImpedanceOptions spring{pushes.stiffness, pushes.damping};
  DriverLoop loop(rig, isSpring ? &spring : nullptr);
  SteppedDevice& device = loop.device;
  LoopBody body(device, loop.haptics, loop.options);
  std::mt19937_64 random(test::seed());
  std::normal_distribution<double> noise(0.0, pushes.noise);
  const auto hold = [&](double force, double duration) {
    for (const double end = device.time() + duration; device.time() < end;) {
      rig.push(force + noise(random));
      (void)body.step();
    }
  };
  hold(pushes.preload, 0.5);
  double sum = 0.0;
  const int count = test::count(4, 20);
  for (int i = 0; i < count; ++i) {
    hold(pushes.preload, 0.4 + i * kPeriod / count);
    rig.restart();
    hold(pushes.preload, 0.1);
    const double rest = rig.path(true);
    rig.restart();
    hold(pushes.force, 0.1);
    sum += pushes.force / (rest - rig.path(false));
    hold(pushes.force, 0.1);
  }
  CHECK(loop.haptics.guard().fault() == GuardReason::none);
  rig.push(0.0);
  return sum / count;
}

void compare(const std::string& name, const Rig& rig, const Pushes& pushes, double least) {
  const double control = depthStiffness(rig, pushes, false), spring = depthStiffness(rig, pushes, true);
  std::cout << name << ": K_d of position control " << 1e-3 * control << " kN/m, of the spring " << 1e-3 * spring
            << " kN/m, ratio " << control / spring << '\n';
  CHECK(control > (test::longRun() ? least : 0.85 * least) * spring);  // few pushes scatter
}

}  // namespace

#ifdef ENAMEL_DHD_STAND_IN
TEST_CASE("the Force Dimension driver in simulated time, with faults", "[drivers]") {
  const test::StandIn standIn(ENAMEL_DHD_STAND_IN, "dhd");
  const auto set = [&](const char* what, double value) { standIn.set(what, value); };
  set("model", 3.0);
  Rig rig{std::string("forcedimension://0?library=") + ENAMEL_DHD_STAND_IN, std::sqrt(3.0) * 12.0, [] {},
          [&] { return standIn.force().norm(); }};
  rig.place = [&](double z) { set("place-z", z); };
  rig.faults = {{"early", [&](bool on) { set("early", on); }},
                {"forces cut", [&](bool on) { set("forces", !on); }},
                {"unplugged", [&](bool on) { set("unplugged", on); }}};
  check("forcedimension", rig);
}

TEST_CASE("pushes through the Force Dimension driver", "[drivers]") {
  const test::StandIn standIn(ENAMEL_DHD_STAND_IN, "dhd");
  const auto path = standIn.find<double(int)>("dhdStandInPath");
  standIn.set("model", 3.0);
  Rig rig{std::string("forcedimension://0?library=") + ENAMEL_DHD_STAND_IN, 0.0, [] {}, {}};
  rig.push = [&](double force) { standIn.set("push", force); };
  rig.path = [=](bool mean) { return path(mean ? 1 : 0); };
  rig.restart = [&] { standIn.set("path", 0.0); };
  compare("omega.3", rig, {0.24, 2.76, 0.12, 14.7e3, 100.0}, 2.0);
}
#endif

#ifdef ENAMEL_HD_STAND_IN
TEST_CASE("the OpenHaptics driver in simulated time, with faults", "[drivers]") {
  const test::StandIn standIn(ENAMEL_HD_STAND_IN, "hd");
  const auto set = [&](const char* what, double value) { standIn.set(what, value); };
  const auto periods = standIn.find<void(int)>("hdStandInPeriods");
  set("manual", 1.0);
  Rig rig{std::string("openhaptics://Default Device?library=") + ENAMEL_HD_STAND_IN, 3.3, [=] { periods(1); },
          [&] { return standIn.force().norm(); }};
  rig.place = [&](double z) { set("place-z", z); };
  rig.faults = {{"stalled", [&](bool on) { set("stalled", on); }, true},
                {"warm", [&](bool on) { set("warm", on); }},
                {"unplugged", [&](bool on) { set("unplugged", on); }}};
  check("openhaptics", rig);
  set("manual", 0.0);
}

TEST_CASE("pushes through the OpenHaptics driver", "[drivers]") {
  const test::StandIn standIn(ENAMEL_HD_STAND_IN, "hd");
  const auto path = standIn.find<double(int)>("hdStandInPath");
  const auto periods = standIn.find<void(int)>("hdStandInPeriods");
  standIn.set("manual", 1.0);
  Rig rig{std::string("openhaptics://Default Device?library=") + ENAMEL_HD_STAND_IN, 0.0, [=] { periods(1); }, {}};
  rig.push = [&](double force) { standIn.set("push", force); };
  rig.path = [=](bool mean) { return path(mean ? 1 : 0); };
  rig.restart = [&] { standIn.set("path", 0.0); };
  compare("Touch", rig, {0.066, 0.759, 0.033, 2.114e3, 15.75}, 1.0);
  standIn.set("manual", 0.0);
}
#endif

#ifdef ENAMEL_HAPLY_SERVICE
// The service answers over a socket in real time: wait for at most 0.2 s.
static void awaitAnswer(HapticDevice& device, Measurement& m, Status& status) {
  for (int i = 0; i < 10000 && status == Status::stale; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(20));
    status = device.measure(m);
  }
}

TEST_CASE("the Haply driver in simulated time, with faults", "[drivers]") {
  test::HaplyService service(test::deviceFile("inverse3.toml"), kHandWay, -kHandWay);
  bool isSilent = false;
  Rig rig{"haply://" + service.address(), std::sqrt(3.0) * 6.0, [] {}, [&] { return std::abs(service.force.load()); }};
  rig.await = [&](HapticDevice& device, Measurement& m, Status& status) {
    if (!isSilent) awaitAnswer(device, m, status);
  };
  const auto silent = [&](std::atomic<bool>& fault) { return [&](bool on) { fault = isSilent = on; }; };
  rig.faults = {{"no device", silent(service.isUnplugged)},
                {"garbage", silent(service.isGarbage)},
                {"shuffled", [&](bool on) { service.isShuffled = on; }},
                {"slow", [&](bool on) { service.isSlow = on; }},
                {"closed", [&](bool on) { service.isClosing = isSilent = on; }}};
  check("haply", rig);
}

TEST_CASE("pushes through the Haply driver", "[drivers]") {
  test::HaplyService service(test::deviceFile("inverse3.toml"), 0.0, 0.0);
  Rig rig{"haply://" + service.address(), 0.0, [] {}, {}};
  rig.await = awaitAnswer;
  rig.push = [&](double force) { service.push = force; };
  rig.path = [&](bool mean) { return mean ? service.mean() : service.lowest(); };
  rig.restart = [&] { service.isNewPath = true; };
  compare("Inverse3", rig, {0.12, 1.38, 0.06, 5.87e3, 35.0}, 2.0);
}
#endif

}  // namespace enamel::test_drivers
