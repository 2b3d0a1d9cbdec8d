// The transient of a tap on simulated devices: the handle's acceleration follows the material, and no energy is gained.
#include "enamel/render/tap_transient.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/sim/virtual_device.hpp"
#include "enamel/study/tap_metrics.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_tap_transient {

namespace {

constexpr double kTick = 1e-3;  // s

struct Case {
  std::string device = "tau-nominal.toml", plant = kClosedForm;
  int delay = 0;         // ticks
  double speed = 0.2;    // of the tap, m/s
  std::string tap = {};  // "": none
  bool spring = false;   // 50 to 60 N s/m and 10 to 15 kN/m on the TAU: of the best springs
  bool movable = false;
  int spread = 0;         // ticks: the delay is random, up to this much longer
  double lost = 0.0;      // share of lost samples
  std::uint32_t run = 1;  // stream of the random numbers
};

struct Run {
  std::vector<TapSample> trace;
  std::vector<double> transient;  // force per tick, before the delay, N
  double energy = 0.0;            // least, that the motors have taken since the transient began, J
  double account = 0.0;           // the same as the transient counts it
  double tolerance = 0.0;         // of the account, J: half an encoder step under the largest force
  double push = 0.0;              // largest estimate of the hand, after the touch, N
  GuardReason fault = GuardReason::none;
};

// A tool that is thrown at the wall z = 0, then held with a small force.
class Bench {
 public:
  explicit Bench(const Case& c) : case_(c) {
    const DeviceParameters parameters = loadDevice(test::deviceFile(c.device));
    setup_.start.position = {0.0, 0.0, 0.02};
    setup_.encoders = {true, RateSource::difference};
    setup_.delay = {c.delay, c.delay + c.spread};
    mechanism_ = makeMechanism(modelFor(c.plant, parameters));
    const MakePlant plant = plantMaker(c.plant, parameters, {}, setup_);
    if (c.lost > 0.0) setup_.lostSamples = c.lost;
    setup_.run = c.run;
    device_ = plant ? std::make_unique<VirtualDevice>(plant(c.run), setup_)
                    : std::make_unique<VirtualDevice>(*mechanism_, setup_);
    const Kinematics& home = mechanism_->home();
    mass_ = effectiveMass(home, home.pose.position, Vec3::UnitZ());
    most_ = largestForce(home, mechanism_->limits().effort, home.pose.position, Vec3::UnitZ());
    Obstacle wall = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());
    if (!c.tap.empty()) wall.tap = tapOf(c.tap);
    if (c.movable) {
      Suspension tooth;
      tooth.inertia[2] = 2e-3;
      tooth.stiffness[2] = 1e5;
      wall.suspension = std::make_shared<const Suspension>(tooth);
    }
    scene_.add(wall);
    if (c.spring) {
      renderer_ = std::make_unique<ImpedanceRenderer>(ImpedanceOptions{5e4 * mass_, 250.0 * mass_});
    } else {
      auto control = std::make_unique<PositionControlRenderer>(
          positionControlFor(*mechanism_, kTick, c.delay, c.delay + c.spread));
      control_ = control.get();
      renderer_ = std::move(control);
    }
    haptics_ = std::make_unique<HapticTick>(*mechanism_, scene_, Tool{}, *renderer_, kTick, setup_.start);
  }

  // Run a tick under a force of the hand along z.
  void step(double force) {
    measurement_.age = device_->measure(measurement_) == Status::stale ? measurement_.age + 1 : 0;
    if (measurement_.age > 0) measurement_.time = device_->time();
    (void)(*haptics_)(measurement_, command_);
    REQUIRE(device_->actuate(command_) == Status::ok);
    rendered_ = wrenchOf(device_->kinematics(), device_->torque() - device_->kinematics().gravity)[2];
    REQUIRE(device_->advance([&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = guidingWrench(pose, twist, setup_.start, Vec3::UnitZ());
      wrench[2] += force;
      return wrench;
    }) == Status::ok);
  }

  double handAt(const Kinematics& k) const {
    if (touched_) return -std::min(1.0, 0.02 * most_);
    const bool isLed = k.pose.position.z() > 3e-4 + case_.speed * (case_.delay + 1) * kTick;
    return isLed ? -60.0 * mass_ * (k.twist[2] + case_.speed) : 0.0;
  }

  Run tap(double seconds = 0.12) {
    Run result;
    double energy = 0.0;
    int begun = -1;
    for (int i = 0; i < static_cast<int>((0.02 / case_.speed + seconds) / kTick); ++i) {
      const double gap = device_->state().position.z(), rate = device_->state().twist[2];
      step(handAt(device_->kinematics()));
      const auto& state = device_->state();
      result.trace.push_back({i * kTick, gap, rate, (state.twist[2] - rate) / kTick, rendered_});
      result.transient.push_back(haptics_->tap().force());
      touched_ = touched_ || gap < 2e-5;
      if (begun < 0 && result.transient.back() != 0.0) begun = i + case_.delay;
      if (begun >= 0 && i >= begun) {
        energy -= rendered_ * (state.position.z() - gap);
        result.energy = std::min(result.energy, energy);
      }
      result.account = std::min(result.account, haptics_->tap().energy());
      if (touched_ && control_) result.push = std::max(result.push, control_->state().push);
      if (haptics_->guard().fault() != GuardReason::none) result.fault = haptics_->guard().fault();
    }
    const JointVector& step = mechanism_->limits().encoderStep;
    const Vec6 up = Vec6::Unit(2);
    result.tolerance = 0.5 * most_ * (mechanism_->home().jacobian.transpose() * up).cwiseProduct(step).norm();
    return result;
  }

  HapticTick& haptics() { return *haptics_; }
  double mass() const { return mass_; }
  double most() const { return most_; }

 private:
  Case case_;
  VirtualDeviceSetup setup_;
  std::shared_ptr<const Mechanism> mechanism_;
  std::unique_ptr<VirtualDevice> device_;
  std::unique_ptr<Renderer> renderer_;
  const PositionControlRenderer* control_ = nullptr;
  Scene scene_;
  std::unique_ptr<HapticTick> haptics_;
  Measurement measurement_;
  Command command_;
  double mass_ = 0.0, most_ = 0.0, rendered_ = 0.0;
  bool touched_ = false;
};

Run tapOn(const Case& c) { return Bench(c).tap(); }

double matchOf(const Run& tap, const std::string& material) { return tapMetrics(tap.trace, tapOf(material)).match; }

}  // namespace

TEST_CASE("tap transient: nearer to the material than without and than a spring", "[tap]") {
  struct Device {
    const char *file, *plant;
    double speed;  // m/s: the motors can follow
  };
  for (const Device& d :
       {Device{"tau-nominal.toml", kClosedForm, 0.2}, Device{"tau-detailed.toml", kImperfectStiff, 0.2},
        Device{"tau-detailed.toml", kImperfect, 0.2}, Device{"delta.toml", kClosedForm, 0.1},
        Device{"cartesian-3.toml", kClosedForm, 0.1}})
    for (const char* material : {"enamel", "dentine", "plastic"})
      for (const int delay : {0, 1, 2}) {
        INFO(d.file << ", " << d.plant << ", " << material << ", delay " << delay);
        const Case plain{d.file, d.plant, delay, d.speed};
        Case with = plain, spring = plain;
        with.tap = material;
        spring.spring = true;
        const Run transient = tapOn(with);
        const double match = matchOf(transient, material);
        CHECK(transient.fault == GuardReason::none);
        CHECK(match > 0.75);
        CHECK(match > matchOf(tapOn(plain), material) + 0.1);
        if (delay == 0) CHECK(match > matchOf(tapOn(spring), material) + 0.1);
      }
}

TEST_CASE("tap transient: it never gives more energy than the impact took", "[tap]") {
  for (const char* device : {"tau-nominal.toml", "delta.toml", "cartesian-3.toml"})
    for (const char* material : {"enamel", "plastic"})
      for (const int delay : {0, 2})
        for (const double speed : {0.1, 0.2, 0.5}) {
          INFO(device << ", " << material << ", delay " << delay << ", " << speed << " m/s");
          const Run tap = tapOn({device, kClosedForm, delay, speed, material});
          CHECK(tap.fault == GuardReason::none);
          CHECK(tap.energy >= -tap.tolerance);
          CHECK(tap.account >= -tap.tolerance * 2.0);  // it sees rounded angles at both ends
          const double taken = 0.5 * Bench({device}).mass() * speed * speed;
          CHECK(tap.tolerance < 0.6 * taken);
        }
}

TEST_CASE("tap transient: position control does not act against it", "[tap]") {
  for (const int delay : {0, 1, 2}) {
    INFO("delay " << delay);
    const Run tap = tapOn({"tau-nominal.toml", kClosedForm, delay, 0.1, "enamel"});
    double own = 0.0, all = 0.0;  // sums of squares
    const auto begin = std::find_if(tap.transient.begin(), tap.transient.end(), [](double f) { return f != 0.0; });
    for (auto i = begin; i + delay < tap.transient.end() && i < begin + 40; ++i) {
      const double acted = tap.trace[static_cast<std::size_t>(i - tap.transient.begin() + delay)].force;
      own += (acted - *i) * (acted - *i);
      all += *i * *i;
    }
    CHECK(std::sqrt(own / all) < 0.15);
    CHECK(tap.push < 6.0);  // the hand pushes with 1 N; an unknown transient of 50 N would look like a push
  }
}

TEST_CASE("tap transient: lost samples, and cables that are too soft", "[tap]") {
  for (const int delay : {0, 2})
    for (std::uint32_t run = 0; run < 10; ++run) {
      INFO("delay " << delay << ", run " << run);
      Case lossy{"tau-nominal.toml", kClosedForm, delay, 0.2, "enamel"};
      lossy.lost = 0.03;
      lossy.run = run;
      const Run tap = tapOn(lossy);
      CHECK(tap.fault == GuardReason::none);
      CHECK(tap.energy >= -tap.tolerance);
      CHECK(matchOf(tap, "enamel") > 0.6);
    }
  // The cables of this device resonate below 310 Hz, so the transient is off.
  const Run plain = tapOn({"delta.toml", kImperfect, 1, 0.2}),
            soft = tapOn({"delta.toml", kImperfect, 1, 0.2, "enamel"});
  for (std::size_t i = 0; i < plain.trace.size(); ++i) REQUIRE(plain.trace[i].rate == soft.trace[i].rate);
}

TEST_CASE("tap transient: slow touches and movable obstacles have none, and the same bits", "[tap]") {
  Case slow{"tau-nominal.toml", kClosedForm, 1, 0.015}, movable{"tau-nominal.toml", kClosedForm, 1, 0.2};
  movable.movable = true;
  for (Case& c : {std::ref(slow), std::ref(movable)}) {
    const Run plain = tapOn(c);
    c.tap = "metal";
    const Run same = tapOn(c);
    CHECK(std::all_of(same.transient.begin(), same.transient.end(), [](double f) { return f == 0.0; }));
    for (std::size_t i = 0; i < plain.trace.size(); ++i) REQUIRE(plain.trace[i].rate == same.trace[i].rate);
  }
}

TEST_CASE("tap transient: a random delay turns it off from a quarter of a period on", "[tap]") {
  const auto with = [](const std::string& material, int spread) {
    Case c{"tau-nominal.toml", kClosedForm, 0, 0.2, material};
    c.spread = spread;
    return tapOn(c);
  };
  for (const auto& [material, least] : {std::pair{"enamel", 1}, {"plastic", 3}})  // periods of 3.2 and 10.3 ticks
    for (const int spread : {least - 1, least}) {
      INFO(material << ", 0 to " << spread << " ticks");
      const Run tap = with(material, spread), plain = with("", spread);
      CHECK(tap.fault == GuardReason::none);
      CHECK(std::any_of(tap.transient.begin(), tap.transient.end(), [](double f) { return f != 0.0; }) ==
            (spread < least));
      if (spread < least) CHECK(matchOf(tap, material) > matchOf(plain, material));
    }
}

TEST_CASE("tap transient: a saved state continues bit for bit, an invalid one starts again", "[tap]") {
  Bench bench({"tau-nominal.toml", kClosedForm, 1, 0.2, "metal"});
  for (int i = 0; bench.haptics().tap().force() == 0.0; ++i) {
    REQUIRE(i < 300);
    bench.step(i < 20 ? -0.2 * bench.mass() / 0.02 : 0.0);
  }
  std::vector<double> state((bench.haptics().stateSize() + 7) / sizeof(double));
  bench.haptics().saveState(state.data());
  TapTransient transient;
  std::vector<double> numbers(TapTransient::kNumbers);
  bench.haptics().tap().saveState(numbers.data());
  transient.loadState(numbers.data());
  CHECK(transient.force() == bench.haptics().tap().force());
  std::vector<double> again(TapTransient::kNumbers);
  transient.saveState(again.data());
  CHECK(again == numbers);
  // Two ticks after the same sample: the second one from the loaded state.
  const Measurement next = [&] {
    Measurement m;
    m.q = bench.haptics().frame().kinematics.q;
    m.rates = bench.haptics().frame().kinematics.rates;
    m.time = bench.haptics().frame().time + kTick;
    return m;
  }();
  Command first, second;
  CHECK(bench.haptics()(next, first) == Status::ok);
  const double force = bench.haptics().tap().force();
  CHECK(force != 0.0);
  bench.haptics().loadState(state.data());
  CHECK(bench.haptics()(next, second) == Status::ok);
  CHECK(bench.haptics().tap().force() == force);
  CHECK(first.effort == second.effort);
  int limited = 0;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    std::vector<double> broken = numbers;
    broken[i] = std::numeric_limits<double>::quiet_NaN();
    transient.loadState(broken.data());
    CHECK(transient.force() == 0.0);
    broken[i] = 1e300;
    transient.loadState(broken.data());
    limited += transient.force() == 0.0;
  }
  CHECK(limited >= 3);  // the numbers that a tick casts to integers
}

TEST_CASE("tap transient: a solid has the taps of its layers", "[tap]") {
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  const std::string path = std::string(ENAMEL_SOURCE_DIR) + "/data/scenes/drill.toml", drill = readFile(path);
  for (const std::string layer : {"enamel", "dentine"}) {
    std::string text = drill;
    const auto replace = [&](const std::string& line, const std::string& by) {
      REQUIRE(text.find(line) != std::string::npos);
      text.replace(text.find(line), line.size(), by);
    };
    replace("name = \"" + layer + "\"", "name = \"" + layer + "\"\n  tap = \"" + layer + "\"");
    replace("cell = 0.0002", "cell = 0.0008");
    const SceneFile file = parseScene(text, path);
    CHECK(hasTaps(file.scene));
    ImpedanceRenderer spring({1e3, 0.0});
    GuardOptions guard = guardFor(*mechanism, kTick);
    guard.on = false;  // the tool moves from the first tick on
    HapticTick tick(*mechanism, file.scene, file.tool, spring, guard, {file.start, Mat3::Identity()});
    bool vibrates = false;
    for (int i = 0; i < 250 && !vibrates; ++i) {
      Vec6 twist = Vec6::Zero();
      twist[2] = -0.1;
      Kinematics k;
      REQUIRE(mechanism->reach({file.start + i * kTick * twist.head<3>(), Mat3::Identity()}, twist, false, k) ==
              Status::ok);
      Measurement m;
      m.time = kTick * i;
      m.q = k.q;
      m.rates = k.rates;
      Command command;
      (void)tick(m, command);
      vibrates = tick.tap().force() != 0.0;
      if (tick.frame().contacts.count > 0 && tick.frame().contacts.contacts[0].gap < 0.0) break;
    }
    CHECK(vibrates == (layer == "enamel"));  // the surface is enamel
  }
}

TEST_CASE("tap transient: scenes that have one", "[tap]") {
  Scene scene = flatWall();
  CHECK_FALSE(hasTaps(scene));
  Obstacle metal = halfSpace("metal", Vec3::Zero(), Vec3::UnitX());
  metal.tap = tapOf("metal");
  scene.add(metal);
  CHECK(hasTaps(scene));
  metal.name = "other";
  metal.tap.frequency = 2000.0;
  CHECK_THROWS_WITH(scene.add(metal), test::ContainsSubstring("a tap has a frequency of 10 to 1000 Hz"));
}

}  // namespace enamel::test_tap_transient
