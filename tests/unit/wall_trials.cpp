// The trials of a wall.
#include "enamel/study/wall_trials.hpp"

#include <cmath>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_wall_trials {

using test::ContainsSubstring;

namespace {

WallTrialSetup setupFor(const std::string& device, int delay) {
  WallTrialSetup setup;
  setup.plant = setup.model = makeMechanism(loadDevice(test::deviceFile(device)));
  setup.delay = {delay, delay};
  setup.runs = 3;
  setup.renderer = [options = positionControlFor(*setup.plant, setup.period, delay, delay)] {
    return std::make_unique<PositionControlRenderer>(options);
  };
  return setup;
}

double figure(const std::vector<WallFigure>& figures, const std::string& trial, const std::string& name) {
  for (const WallFigure& f : figures)
    if (f.trial == trial && f.figure == name) return f.value;
  FAIL(trial << ": " << name << " is missing");
  return 0.0;
}

}  // namespace

TEST_CASE("a spring without damping is told from a servo by every trial", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  const auto servo = runWallTrials(setup, "", 2);
  setup.renderer = [] { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{}); };
  const auto spring = runWallTrials(setup, "", 2);
  REQUIRE(servo.size() == spring.size());
  CHECK(figure(servo, "step", "share of the limit") > 50.0 * figure(spring, "step", "share of the limit"));
  for (const auto& [trial, name] : {std::pair{"step", "bounce"},
                                    {"step", "chatter"},
                                    {"ramp", "depth"},
                                    {"impact 0.2 m/s", "depth of the allowed"},
                                    {"impact 0.5 m/s", "bounce"},
                                    {"release", "speed over the unavoidable"},
                                    {"slide", "rms depth"}}) {
    INFO(trial << ": " << name);
    CHECK(figure(servo, trial, name) < 0.5 * figure(spring, trial, name));
  }
  // A spring pushes from the surface on: its depth under a ramp to 11 N is the force divided by its stiffness, plus its
  // oscillation.
  CHECK(figure(spring, "ramp", "depth") > 1e6 * 10.0 / ImpedanceOptions{}.stiffness);
  for (const WallFigure& f : servo) CHECK(f.lost == 0);
}

TEST_CASE("trials are the same on any number of threads, and filtered ones the same as among all", "[wall_trials]") {
  const WallTrialSetup setup = setupFor("tau-nominal.toml", 1);
  const auto one = runWallTrials(setup, "impact", 1), three = runWallTrials(setup, "impact", 3),
             fast = runWallTrials(setup, "0.5", 2);
  REQUIRE(one.size() == 12);
  REQUIRE(three.size() == 12);
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(one[i].value == three[i].value);
  REQUIRE(fast.size() == 4);
  for (std::size_t i = 0; i < fast.size(); ++i) CHECK(fast[i].value == one[8 + i].value);
  CHECK(runWallTrials(setup, "wish", 1).empty());
}

TEST_CASE("a trial takes its time, and no more", "[wall_trials]") {
  class Counting final : public Renderer {
   public:
    explicit Counting(int& count) : count_(count), wall_(ImpedanceOptions{}) {}

   private:
    void prepare(double period) override { wall_.activate(period); }
    Status render(const TickFrame& input, TickOutput& output) noexcept override {
      ++count_;
      return wall_.step(input, output);
    }
    void resetState() noexcept override { wall_.reset(); }
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

    int& count_;
    ImpedanceRenderer wall_;
  };
  int ticks = 0;
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  setup.runs = 1;
  setup.renderer = [&ticks] { return std::make_unique<Counting>(ticks); };
  for (const auto& [trial, duration] : {std::pair{"step", 1250}, {"ramp", 800}}) {
    INFO(trial);
    ticks = 0;
    for (const WallFigure& f : runWallTrials(setup, trial, 1)) CHECK(f.lost == 0);
    CHECK(ticks == duration);
  }
}

TEST_CASE("in a corner a spring goes as deep as its stiffness says, a servo does not", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  const auto servo = runWallTrials(setup, "corner", 2);
  setup.renderer = [] { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{5000.0, 50.0}); };
  const auto spring = runWallTrials(setup, "corner", 2);
  // Two walls at 45 deg carry 10 N: each carries sqrt(1/2) of it, and its depth is its force divided by its stiffness.
  CHECK(figure(spring, "corner", "depth") ==
        Approx(1e6 * 10.0 * std::sqrt(0.5) / 5000.0).epsilon(0.2));  // plus the noise
  CHECK(figure(servo, "corner", "depth") < 100.0);
  for (const WallFigure& f : servo) CHECK(f.lost == 0);
}

constexpr double kMostBounce = 200.0;  // um

std::vector<WallFigure> impacts(int delay) {
  WallTrialSetup setup = setupFor("tau-nominal.toml", delay);
  setup.runs = test::count(30, 300);
  return runWallTrials(setup, "impact", 2);
}

// When ages of a jump above 1.5 ticks were not considered, one impact in a hundred was thrown back by up to 1 mm with 3
// ticks of delay.
TEST_CASE("no impact is thrown back", "[wall_trials]") {
  for (const int delay : {0, 3})
    for (const WallFigure& f : impacts(delay)) {
      INFO("delay " << delay << ", " << f.trial);
      CHECK(f.lost == 0);
      if (f.figure == "bounce" && !(delay == 3 && f.trial == "impact 0.05 m/s")) CHECK(f.value < kMostBounce);
    }
}

TEST_CASE("no slow impact is thrown back with 3 ticks of delay (expected failure, 240 um instead of 200)",
          "[!shouldfail][wall_trials]") {
  CHECK(figure(impacts(3), "impact 0.05 m/s", "bounce") < kMostBounce);
}

// The hand pushes while the tool sinks, so the speed rises a little.
TEST_CASE("the extended rate-hardness of a spring is its stiffness", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  for (const double stiffness : {500.0, 2000.0}) {
    setup.renderer = [stiffness] { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{stiffness, 0.0}); };
    const auto figures = runWallTrials(setup, "impact", 2);
    for (const char* trial : {"impact 0.2 m/s", "impact 0.5 m/s"})
      CHECK(figure(figures, trial, "extended rate-hardness") == Approx(1e-3 * stiffness).epsilon(0.05));
  }
}

TEST_CASE("a hand taps against the friction of a light device, and the transient is nearer to the material",
          "[wall_trials]") {
  WallTrialSetup setup = setupFor("touch.toml", 1);
  VirtualDeviceSetup device;
  device.encoders = {true, RateSource::difference};
  setup.makePlant = plantMaker(kImperfect, loadDevice(test::deviceFile("touch.toml")), {}, device);
  setup.runs = 20;
  const auto taps = runWallTrials(setup, "tap", 2);
  for (const WallFigure& f : taps) CHECK(f.lost == 0);
  CHECK(figure(taps, "tap transient", "mean match") > figure(taps, "tap plain", "mean match"));
}

TEST_CASE("a wall that lets go gives the unavoidable speed on average", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  setup.runs = 1;
  const auto one = runWallTrials(setup, "release", 1);
  CHECK(figure(one, "release", "mean speed over the unavoidable") ==
        figure(one, "release", "speed over the unavoidable"));
  setup.runs = 40;
  const auto many = runWallTrials(setup, "release", 2);
  // Between two samples it comes up to a tick earlier than assumed, or is seen a tick later: 0.9 to 1.15.
  CHECK(figure(many, "release", "mean speed over the unavoidable") == Approx(1.0).margin(0.02));
  CHECK(figure(many, "release", "speed over the unavoidable") < 1.2);
}

TEST_CASE("trials run on the plant that is made for them", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  const auto ideal = runWallTrials(setup, "release", 2);
  DeviceParameters heavy = loadDevice(test::deviceFile("tau-nominal.toml"));
  addMass(heavy, 0.5);
  const auto mechanism = makeMechanism(heavy);
  setup.makePlant = [&mechanism](std::uint32_t) {
    return std::make_unique<ClosedFormPlant>(*mechanism, Integrator::rungeKutta4, 1);
  };
  const double speed = figure(runWallTrials(setup, "release", 2), "release", "speed over the unavoidable");
  CHECK(speed < 0.8 * figure(ideal, "release", "speed over the unavoidable"));
}

TEST_CASE("forces become what a weaker device can answer", "[wall_trials]") {
  const auto tau = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml"))),
             delta = makeMechanism(loadDevice(test::deviceFile("delta.toml")));
  CHECK(forceShare(*tau) == 1.0);
  CHECK(15.0 * forceShare(*delta) ==
        Approx(0.3 * largestForce(delta->home(), delta->limits().effort, Vec3::Zero(), Vec3::UnitZ())).epsilon(1e-6));
}

TEST_CASE("trials refuse what cannot be run", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  setup.runs = 0;
  CHECK_THROWS_WITH(runWallTrials(setup, "", 1), "wall trials: the runs are 0, must be in 1 to 10000");
  setup = setupFor("tau-nominal.toml", 0);
  setup.renderer = nullptr;
  CHECK_THROWS_AS(runWallTrials(setup, "", 1), Error);
}

TEST_CASE("trials have names, each of which runs that trial alone", "[wall_trials]") {
  WallTrialSetup setup = setupFor("tau-nominal.toml", 0);
  setup.runs = 1;
  std::vector<std::string> names;
  for (const WallFigure& figure : runWallTrials(setup, "", 2))
    if (names.empty() || names.back() != figure.trial) names.push_back(figure.trial);
  CHECK(wallTrialNames() == names);
  for (const std::string& name : {names.front(), names[2], names[4]})
    for (const WallFigure& figure : runWallTrials(setup, name, 2)) CHECK(figure.trial == name);
}

}  // namespace enamel::test_wall_trials
