// Position control of a device that differs from its file: masses, cables, friction, lost samples, late ticks, delay.
// Also of a device that does not report the torque that acts.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/parallel.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "support/silent_device.hpp"

namespace enamel::test_wrong_model {

namespace {

constexpr double kPeriod = 1e-3;  // s

// The file that the controller gets, and the device, both from the shipped file. `stated`: the delay that it assumes.
struct Error {
  std::string name;
  std::function<void(TauParameters& file)> inFile = {};
  std::function<void(TauParameters& device)> inDevice = {};
  Delay delay = {}, stated = delay;
  bool isSilent = false, isGuarded = true;
};

std::function<void(TauParameters&)> massesTimes(double factor) {
  return [factor](TauParameters& tau) {
    const auto scale = [&](auto& body) {
      body.mass *= factor;
      body.inertia *= factor;
    };
    for (ChainParameters& chain : tau.chain) {
      scale(chain.link1);
      scale(chain.link2);
    }
    scale(tau.platform);
  };
}

std::function<void(TauParameters&)> cablesTimes(double factor) {
  return [factor](TauParameters& tau) { tau.imperfections.cableStiffness *= factor; };
}

std::function<void(TauParameters&)> rotorsTimes(double factor) {
  return [factor](TauParameters& tau) { tau.motor.rotorInertia *= factor; };
}

void turnPlatform(TauParameters& tau) {
  const Mat3 turn = Eigen::AngleAxisd(20.0 * M_PI / 180.0, Vec3(1, 1, 1).normalized()).toRotationMatrix();
  tau.platform.inertia = turn * tau.platform.inertia * turn.transpose();
}

std::vector<Error> errorsAt(int delay) {
  std::vector<Error> errors = {
      {"none"},
      {"masses of the file x 0.7", massesTimes(0.7)},
      {"masses of the file x 1.3", massesTimes(1.3)},
      {"rotors of the file x 0.9", rotorsTimes(0.9)},
      {"rotors of the file x 1.1", rotorsTimes(1.1)},
      {"cables of the file x 0.7", cablesTimes(0.7)},
      {"cables of the file x 0.9", cablesTimes(0.9)},
      {"cables of the file x 1.1", cablesTimes(1.1)},
      {"cables of the file x 1.3", cablesTimes(1.3)},
      {"platform's inertia turned by 20 deg", turnPlatform},
      {"friction of the device x 3", {}, [](TauParameters& tau) { tau.imperfections.coulombFriction *= 3.0; }},
      {"3 % of the samples lost", {}, [](TauParameters& tau) { tau.imperfections.lostSamples = 0.03; }},
      {"ticks late by up to 0.3 ms", {}, [](TauParameters& tau) { tau.imperfections.jitter = 0.3; }},
  };
  for (Error& error : errors) error.delay = error.stated = {delay, delay};
  errors.push_back({"delay longer by a tick, stated as a range", {}, {}, {delay + 1, delay + 1}, {delay, delay + 1}});
  return errors;
}

StudyPlan pushesAt(const Delay& delay) {
  StudyPlan plan;
  plan.scenarios = {1};
  plan.insideTick = true;
  plan.setup.period = kPeriod;
  plan.setup.delay = delay;
  plan.setup.duration = 2.2;
  plan.setup.encoders = {true, RateSource::difference};
  plan.setup.seed = test::seed() + 11;
  return plan;
}

// Push a device under position control that has a file and a stated delay.
void addDevice(const DeviceParameters& device, const DeviceParameters& file, const Delay& stated, StudyPlan& plan) {
  StudyColumn column;
  column.name = "position-control";
  column.plant = makeMechanism(modelFor(kImperfect, device));
  column.model = makeMechanism(modelFor(kImperfect, file));
  column.makePlant = plantMaker(kImperfect, device, {}, plan.setup);
  column.make = [options = positionControlFor(*column.model, kPeriod, stated.low, stated.high)](std::size_t) {
    return std::make_unique<PositionControlRenderer>(options);
  };
  plan.columns = {column};
}

StudyPlan planOf(const Error& error, double cable, int runs) {
  TauParameters device = loadTau(test::deviceFile("tau-detailed.toml"));
  device.imperfections.cableStiffness = cable;
  if (cable == 0.0) device.imperfections.cableDamping = 0.0;
  TauParameters file = device;
  if (error.inFile) error.inFile(file);
  if (error.inDevice) error.inDevice(device);
  StudyPlan plan = pushesAt(error.delay);
  plan.grid = test::count(2, 3);
  plan.runs = runs;
  plan.setup.hand.preload = 1.0;
  plan.setup.guarded = error.isGuarded;
  if (error.isSilent) plan.setup.wrapper = [](VirtualDevice& d) { return std::make_unique<test::SilentDevice>(d); };
  addDevice(device, file, error.stated, plan);
  return plan;
}

struct Result {
  int lost = 0;
  double stiffness = 0.0;  // mean K_d, N/m
};

Result resultOf(const Error& error, double cable) {
  const StudyPlan plan = planOf(error, cable, test::count(1, 20));
  std::vector<StudyResult> results(plan.size());
  parallelFor(plan.size(), availableThreads(), [&](std::size_t i) { results[i] = performRun(plan, runAt(plan, i)); });
  Result result;
  std::vector<double> stiffness;
  for (const StudyResult& r : results) {
    result.lost += r.status != Status::ok || isLost(r);
    if (r.metrics.depthStiffness) stiffness.push_back(*r.metrics.depthStiffness);
  }
  result.stiffness = spreadOf(stiffness).mean;
  if (test::longRun())
    std::printf("cable %5.0f N m/rad, delay %d..%d, %-42s lost %3d of %3zu, K_d %6.1f kN/m\n", cable, error.delay.low,
                error.delay.high, error.name.c_str(), result.lost, plan.size(), 1e-3 * result.stiffness);
  return result;
}

}  // namespace

TEST_CASE("position control loses no push on a device that differs from its file", "[hard]") {
  for (const double cable : {0.0, 1000.0})
    for (int delay = test::count(1, 0); delay <= test::count(1, 2); ++delay) {
      const std::vector<Error> errors = errorsAt(delay);
      const double right = resultOf(errors[0], cable).stiffness;
      for (std::size_t i = 1; i < errors.size(); ++i) {
        if (cable == 0.0 && errors[i].name.find("cables") != std::string::npos) continue;
        const Result result = resultOf(errors[i], cable);
        INFO("cable " << cable << " N m/rad, delay " << delay << ", " << errors[i].name);
        CHECK(result.lost == 0);
        if (errors[i].delay.low == delay) CHECK(result.stiffness > 0.75 * right);
      }
    }
}

// In each tick one of several commands acts, and nobody knows which one.
TEST_CASE("position control loses no push at a range of delays, if the device reports no torque", "[hard]") {
  for (const double cable : {0.0, 1000.0})
    for (const Delay& stated : {Delay{0, 1}, Delay{0, 2}, Delay{1, 3}})
      for (const Delay& delay : {stated, Delay{0, 0}, Delay{1, 1}}) {
        if (delay.low == delay.high && stated.high > 1) continue;  // see the next test
        const std::string range = std::to_string(stated.low) + ".." + std::to_string(stated.high);
        const Result told = resultOf({range + ", reports", {}, {}, delay, stated}, cable),
                     silent = resultOf({range + ", no reports", {}, {}, delay, stated, true}, cable);
        INFO("cable " << cable << " N m/rad, stated " << range << ", delay " << delay.low << ".." << delay.high);
        CHECK(silent.lost == 0);
        CHECK(silent.stiffness > 0.5 * told.stiffness);
      }
}

TEST_CASE("position control learns a constant delay: of a range, or two ticks away from the stated one", "[hard]") {
  for (const double cable : {0.0, 1000.0})
    for (const Delay& stated : {Delay{1, 1}, Delay{2, 2}, Delay{0, 2}})
      for (int delay = std::max(0, stated.low - 2); delay <= stated.high + 2; ++delay)
        for (const bool isSilent : {false, true}) {
          if (!test::longRun() && (cable > 0.0 || !isSilent)) continue;
          const Delay truth{delay, delay};
          const std::string range = std::to_string(stated.low) + ".." + std::to_string(stated.high),
                            reports = isSilent ? ", no reports" : ", reports";
          const Result known = resultOf({"known" + reports, {}, {}, truth, truth, isSilent}, cable),
                       learnt = resultOf({"stated " + range + reports, {}, {}, truth, stated, isSilent}, cable);
          INFO("cable " << cable << " N m/rad, stated " << range << ", delay " << delay << reports);
          CHECK(learnt.lost == 0);
          CHECK(learnt.stiffness > 0.75 * known.stiffness);
        }
}

TEST_CASE("position control loses no push behind soft and stiff cables that differ from the file", "[hard]") {
  for (const double cable : {300.0, 3000.0})
    for (const double factor : {0.7, 1.3}) {
      INFO("cable " << cable << " N m/rad, in the file x " << factor);
      CHECK(resultOf({"cables of the file", cablesTimes(factor)}, cable).lost == 0);
    }
}

// The guard does not know the rotors, and stops a few of these pushes.
TEST_CASE("position control loses no push if rotors and masses are wrong", "[hard]") {
  for (const double factor : {0.7, 1.3}) {
    Error error{"rotors and masses of the file"};
    error.inFile = [factor](TauParameters& tau) {
      massesTimes(factor)(tau);
      rotorsTimes(factor)(tau);
    };
    error.isGuarded = false;
    INFO("in the file x " << factor);
    CHECK(resultOf(error, 1000.0).lost == 0);
  }
}

// A tick moves a light device by less than a count of its encoders. Impacts saturate its motors.
TEST_CASE("position control loses hardly a push of a light device with coarse encoders and a wrong mass", "[hard]") {
  struct Device {
    const char* file;
    double cable;  // stiffness over mass, N/m per kg; 0: rigid
  };
  for (const auto& [file, cable] :
       {Device{"touch.toml", 0.0}, Device{"inverse3.toml", 0.0}, Device{"inverse3.toml", 1e6}})
    for (const double factor : {0.7, 0.85, 1.0, 1.15, 1.3}) {
      auto inFile = std::get<CartesianParameters>(loadDevice(test::deviceFile(file)));
      inFile.imperfections = {};
      inFile.imperfections.currentBandwidth = 1000.0;
      if (cable > 0.0) {
        inFile.rotorMass = 0.2 * inFile.mass;
        inFile.imperfections.cableStiffness = cable * inFile.mass;
        inFile.imperfections.cableDamping = 54.0 * inFile.mass;
      }
      CartesianParameters device = inFile;
      device.mass *= factor;
      std::vector<StudyPlan> plans;
      for (const double share : {0.25, 0.4, 0.57, 0.65})  // of the motors' force
        for (int delay = 0; delay <= 3; ++delay) {
          StudyPlan plan = pushesAt({delay, delay});
          plan.grid = 1;
          plan.runs = test::count(3, 25);
          plan.lowestForce = plan.highestForce = share * device.maxForce;
          plan.setup.hand.preload = device.maxForce / 12.0;
          plan.setup.hand.noise = 0.01 * device.maxForce;
          addDevice(device, inFile, plan.setup.delay, plan);
          plans.push_back(plan);
        }
      const std::size_t size = plans.front().size();
      std::vector<int> lost(plans.size() * size);
      parallelFor(lost.size(), availableThreads(), [&](std::size_t i) {
        const StudyResult r = performRun(plans[i / size], runAt(plans[i / size], i % size));
        lost[i] = r.status != Status::ok || isLost(r);
      });
      const auto sum = std::accumulate(lost.begin(), lost.end(), 0);
      if (test::longRun())
        std::printf("%s, cables %g, mass x %.2f: %d of %zu lost\n", file, cable, factor, sum, lost.size());
      INFO(file << ", cables " << cable << ", mass x " << factor);
      CHECK(sum <= 0.05 * static_cast<double>(lost.size()));
    }
}

// Above half the sample rate, a resonance looks like one below it. Then the estimate can be wrong.
TEST_CASE("position control learns the stiffness of cables that resonate below half the sample rate", "[hard]") {
  constexpr double kCable = 1000.0, kSoon = 0.1;  // N m/rad, 430 Hz; s
  for (const int delay : {0, 2})
    for (const double factor : {0.7, 1.0, 1.3}) {
      const StudyPlan whole = planOf({"", cablesTimes(factor), {}, {delay, delay}}, kCable, test::count(2, 10));
      std::vector<PositionControlState> soon(whole.size()), learnt(whole.size());
      parallelFor(whole.size(), availableThreads(), [&](std::size_t i) {
        StudyPlan plan = whole;
        const PositionControlRenderer* renderer = nullptr;
        plan.columns[0].make = [&](std::size_t point) {
          auto made = whole.columns[0].make(point);
          renderer = dynamic_cast<const PositionControlRenderer*>(made.get());
          return made;
        };
        (void)performRun(plan, runAt(plan, i), [&](const TickRecord& tick) {
          learnt[i] = renderer->state();
          if (tick.time < kSoon) soon[i] = learnt[i];
        });
      });
      const auto errorOf = [factor](const PositionControlState& state) { return std::log(state.cable * factor); };
      const auto rms = [&](const std::vector<PositionControlState>& states) {
        double square = 0.0;
        for (const PositionControlState& state : states) square += std::pow(errorOf(state), 2);
        return std::sqrt(square / static_cast<double>(states.size()));
      };
      const int inside =
          static_cast<int>(std::count_if(learnt.begin(), learnt.end(), [&](const PositionControlState& state) {
            return std::abs(errorOf(state)) <= 1.96 * state.cableDeviation;
          }));
      const double early = rms(soon), late = rms(learnt);
      if (test::longRun())
        std::printf(
            "delay %d, cables of the file x %.1f: error %.3f after 0.1 s, %.3f after the push, %d of %zu "
            "intervals contain the truth\n",
            delay, factor, early, late, inside, learnt.size());
      INFO("delay " << delay << ", cables of the file x " << factor << ": error " << early << ", then " << late << ", "
                    << inside << " of " << learnt.size() << " intervals contain the truth");
      CHECK(early < 0.15);
      CHECK(late < 0.1);
      CHECK(inside >= 0.8 * static_cast<double>(learnt.size()));
    }
}

}  // namespace enamel::test_wrong_model
