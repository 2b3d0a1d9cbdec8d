// Samples that are lost, late, repeated or have the same time: the controller predicts and does not restart.
#include <algorithm>
#include <cmath>
#include <functional>

#include "enamel/device/cartesian/mechanism.hpp"
#include "enamel/render/drill.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/virtual_coupling.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_lost_samples {

namespace {

constexpr double kPeriod = 1e-3;
constexpr int kFault = 500;  // tick of the first wrong sample

CartesianMechanism lightDevice() {
  CartesianParameters p;
  p.name = "light";
  p.mass = 0.1;
  p.halfWidths = Vec3::Constant(0.05);
  p.maxForce = 20.0;
  p.positionStep = 1e-5;
  return CartesianMechanism(p);
}

// Changes sample n as a device might; a status other than ok means that no sample comes.
using Fault = std::function<Status(int n, const Measurement& last, Measurement& m)>;

class FaultyDevice final : public HapticDevice {
 public:
  FaultyDevice(VirtualDevice& device, Fault fault) : device_(device), fault_(std::move(fault)) {}
  Status measure(Measurement& m) noexcept override {
    Measurement truth;
    Status status = device_.measure(truth);
    Measurement given = truth;
    if (status == Status::ok) status = fault_(number_++, last_, given);
    last_ = truth;
    if (status == Status::ok) m = given;
    return status;
  }
  Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

 private:
  VirtualDevice& device_;
  Fault fault_;
  Measurement last_;
  int number_ = 0;
};

struct Press {
  double before = 0.0;  // largest depth in the 100 ticks before the fault, m
  double after = 0.0;   // largest depth from the fault on, m
  double step = 0.0;    // largest change of a command from the fault on, N m or N
  GuardReason worst = GuardReason::none;
};

// 1 N, then `force` (N) into the wall z = 0. From kFault on, the samples are wrong.
Press press(const Mechanism& mechanism, Renderer& renderer, double force, const Fault& fault) {
  VirtualDeviceSetup setup;
  setup.start.position = {0.0, 0.0, 0.002};
  setup.encoders.quantised = true;
  setup.encoders.rates = RateSource::lowPass;
  VirtualDevice plant(mechanism, setup);
  FaultyDevice device(plant, fault);
  const Scene scene = flatWall();
  HapticTick haptics(mechanism, scene, Tool(), renderer, kPeriod, setup.start);
  LoopBody body(device, haptics, {});
  const auto hand = [force](double t, const Pose& p, const Vec6& v) {
    Vec6 w = Vec6::Zero();
    w[2] = t < 0.05 ? -1.0 : -force;
    w.head<2>() -= 200.0 * p.position.head<2>();
    w.head<3>() -= 5.0 * v.head<3>();
    w.tail<3>() -= 0.05 * v.tail<3>();
    return w;
  };
  Press result;
  JointVector last;
  for (int i = 0; i < 1000; ++i) {
    if (!body.step()) throw Error("the loop ended");
    const double depth = -plant.state().position.z();
    const JointVector& command = body.tick().command.effort;
    if (i >= kFault - 100 && i < kFault) result.before = std::max(result.before, depth);
    if (i >= kFault) {
      result.after = std::max(result.after, depth);
      result.step = std::max(result.step, (command - last).cwiseAbs().maxCoeff());
      result.worst = std::max(result.worst, body.tick().reason);
    }
    last = command;
    if (isFault(result.worst) && i > kFault + 200) break;  // the hand pushes the tool further
    if (plant.advance(hand) != Status::ok) throw Error("the plant was left");
  }
  return result;
}

Fault lost(int count) {
  return [count](int n, const Measurement&, Measurement&) {
    return n >= kFault && n < kFault + count ? Status::stale : Status::ok;
  };
}

const TauMechanism& tau() {
  static const TauMechanism mechanism(test::nominal());
  return mechanism;
}

}  // namespace

TEST_CASE("a lost sample does not erase what position control knows", "[lost]") {
  SECTION("TAU, 8 N") {
    auto servo = test::positionControl(tau());
    const Press p = press(tau(), servo, 8.0, lost(1)), whole = press(tau(), servo, 8.0, lost(0));
    INFO(1e6 * p.before << " um, then " << 1e6 * p.after << " um, torque steps " << p.step << " N m, without loss "
                        << whole.step);
    CHECK(p.after < 10e-6);
    CHECK(p.step < whole.step + 0.15);  // 0.57 N m for a controller that restarts
    CHECK(p.worst == GuardReason::none);
  }
  SECTION("0.1 kg, 10 N") {
    const CartesianMechanism light = lightDevice();
    const double most[] = {0.0, 20e-6, 60e-6};  // m, by lost samples
    for (const int count : {1, 2}) {
      auto servo = test::positionControl(light);
      const Press p = press(light, servo, 10.0, lost(count));
      INFO(count << " lost: " << 1e6 * p.before << " um, then " << 1e6 * p.after << " um");
      CHECK(p.before > 0.0);
      CHECK(p.after - p.before < most[count]);
      CHECK(p.worst == GuardReason::none);
    }
  }
}

TEST_CASE("samples that are late, repeated or stamped twice", "[lost]") {
  const CartesianMechanism light = lightDevice();
  const auto at = [](int n) { return n == kFault; };
  const std::pair<const char*, Fault> faults[] = {
      {"repeated",
       [at](int n, const Measurement& last, Measurement& m) {
         const double time = m.time;
         if (at(n)) m = last;
         m.time = time;
         return Status::ok;
       }},
      {"stamped twice",
       [at](int n, const Measurement& last, Measurement& m) {
         if (at(n)) m = last;
         return Status::ok;
       }},
      {"late by 0.45",
       [at](int n, const Measurement&, Measurement& m) {
         if (at(n)) m.time += 0.45e-3;
         return Status::ok;
       }},
      {"late by 0.9",
       [at](int n, const Measurement&, Measurement& m) {
         if (at(n)) m.time += 0.9e-3;
         return Status::ok;
       }},
      {"a tick that never came",
       [](int n, const Measurement&, Measurement& m) {
         if (n >= kFault) m.time += 1e-3;
         return Status::ok;
       }},
  };
  for (const Mechanism* mechanism : {static_cast<const Mechanism*>(&tau()), static_cast<const Mechanism*>(&light)})
    for (const auto& [name, fault] : faults) {
      auto servo = test::positionControl(*mechanism);
      const Press p = press(*mechanism, servo, 8.0, fault);
      INFO(mechanism->name() << ", " << name << ": " << 1e6 * p.before << " um, then " << 1e6 * p.after << " um");
      CHECK(p.after - p.before < 20e-6);
      CHECK(p.worst == GuardReason::none);
    }
}

TEST_CASE("gaps up to the guard's longest are bridged, longer ones ramp out", "[lost]") {
  const int longest = guardFor(tau(), kPeriod).longestGap;
  for (int count = 1; count <= longest + 1; ++count) {
    auto servo = test::positionControl(tau());
    const Press p = press(tau(), servo, 8.0, lost(count));
    INFO(count << " lost: " << 1e6 * p.before << " um, then " << 1e6 * p.after << " um");
    CHECK(p.worst == (count <= longest ? GuardReason::none : GuardReason::late));
    if (count <= longest) CHECK(p.after - p.before < 120e-6);
  }
}

TEST_CASE("one sample in a hundred that is lost costs at most a tenth of the stiffness", "[lost]") {
  const int runs = test::count(20, 100);
  const auto stiffness = [runs](double share) {
    double sum = 0.0;
    for (int run = 0; run < runs; ++run) {
      PushSetup setup;
      setup.hand.force = 12.0;
      setup.hand.preload = 1.0;
      setup.hand.instant = randomInstant(7, static_cast<std::uint32_t>(run));
      setup.encoders.quantised = true;
      setup.encoders.rates = RateSource::lowPass;
      setup.lostSamples = share;
      setup.duration = 1.5;
      setup.seed = 7;
      setup.run = static_cast<std::uint32_t>(run);
      auto servo = test::positionControl(tau());
      double mean = 0.0, deepest = 0.0;  // m
      const PushResult result = runPush(tau(), servo, setup, [&](const TickRecord& t) {
        const double depth = -t.pose.position.z();
        if (t.tick >= 900 && t.tick < 1000) mean += depth / 100.0;
        if (t.tick >= 1000 && t.tick < 1100) deepest = std::max(deepest, depth);
      });
      REQUIRE(result.status == Status::ok);
      sum += 11.0 / (deepest - mean) / runs;
    }
    return sum;
  };
  const double all = stiffness(0.0), some = stiffness(0.01);
  INFO(1e-3 * all << " kN/m, with lost samples " << 1e-3 * some << " kN/m");
  CHECK(some > 0.9 * all);
}

TEST_CASE("every renderer answers a tick without a sample", "[lost]") {
  const auto check = [](const char* name, Renderer& renderer, double growth) {
    for (const int count : {1, 3}) {
      const Press p = press(tau(), renderer, 2.0, lost(count));
      INFO(name << ", " << count << " lost: " << 1e6 * p.before << " um, then " << 1e6 * p.after << " um");
      CHECK(p.worst == GuardReason::none);
      CHECK(p.before > 0.0);
      CHECK(p.after - p.before < growth);
      renderer.deactivate();
    }
  };
  ImpedanceOptions soft;
  soft.stiffness = 1000.0;
  ImpedanceRenderer impedance(soft);
  check("impedance", impedance, 60e-6);
  auto hold = test::holdRenderer();
  check("hold", hold, 60e-6);
  VirtualCouplingOptions coupling;
  coupling.stiffness = 1000.0;
  coupling.damping = 3.0;
  VirtualCouplingRenderer virtualCoupling(coupling);
  check("virtual coupling", virtualCoupling, 60e-6);
  PassivityRenderer passive(std::make_unique<ImpedanceRenderer>(soft), PassivityBound::memory);
  check("passivity", passive, 60e-6);
}

TEST_CASE("an old sample is predicted by its rates", "[lost]") {
  // A spring in a wall that the tool enters at 10 mm/s: each period without a sample adds 10 um.
  Pose pose;
  pose.position.z() = -1e-3;
  Vec6 twist = Vec6::Zero();
  twist[2] = -0.01;
  ImpedanceOptions options;
  options.stiffness = 1000.0;
  ImpedanceRenderer renderer(options);
  renderer.activate(kPeriod);
  TickFrame input = test::frameAt(tau(), pose, 1.0, twist);
  TickOutput output;
  REQUIRE(renderer.step(input, output) == Status::ok);
  CHECK(output.normalForce == Approx(1.0).epsilon(1e-12));
  for (int age = 1; age <= 3; ++age) {
    input.time += kPeriod;
    input.age = age;
    REQUIRE(renderer.step(input, output) == Status::ok);
    CHECK(output.normalForce == Approx(1.0 + 0.01 * age).epsilon(1e-12));
  }
  input.time += kPeriod;
  input.age = -1;
  CHECK(renderer.step(input, output) == Status::outOfRange);
}

TEST_CASE("a tick before any sample is refused and commands nothing", "[lost]") {
  auto servo = test::positionControl(tau());
  const Scene scene = flatWall();
  HapticTick haptics(tau(), scene, Tool(), servo, kPeriod);
  Measurement m;
  m.q = tau().home().q;
  m.rates = JointVector::Zero(6);
  m.age = 1;
  Command command;
  CHECK(haptics(m, command) == Status::stale);
  CHECK(command.effort.isZero(0.0));
  CHECK(haptics.guard().fault() == GuardReason::none);
  m.age = 0;
  m.time = kPeriod;
  CHECK(haptics(m, command) == Status::ok);
}

}  // namespace enamel::test_lost_samples
