// The plant in Simbody compared with the closed form. The two programs share only the device file and the geometry of
// the start.
#include <cmath>
#include <thread>

#include "enamel/core/error.hpp"
#include "enamel/multibody/multibody_plant.hpp"
#include "enamel/sim/push.hpp"
#include "support/catch.hpp"
#include "support/mechanisms.hpp"
#include "support/pushes.hpp"
#include "support/relative_error.hpp"
#include "support/run_length.hpp"

namespace enamel::test_multibody {

namespace {

const auto nothing = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };

JointVector torqueOf(test::Random& random, const Mechanism& device) {
  return randomJoints(random, device.joints(), 0.5 * device.limits().effort.minCoeff());
}

}  // namespace

TEST_CASE("multibody: accelerations of every shipped device", "[multibody]") {
  test::Random random(23);
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    DeviceParameters parameters = shipped.parameters();
    addFriction(parameters, 2e-3);
    addDamping(parameters, (Vec6() << 1.0, 2.0, 3.0, 0.01, 0.02, 0.03).finished());
    const auto device = makeMechanism(parameters);
    MultibodyPlant plant(parameters);
    double worst = 0.0, closure = 0.0;
    for (int i = 0; i < 100; ++i) {
      const Pose pose = shipped.pose(random);
      const Vec6 twist = shipped.twist(random), wrench = random.vector6(10.0, 0.3);
      const JointVector torque = torqueOf(random, *device);
      Vec6 closed, other;
      REQUIRE(device->accelerate(pose, twist, torque, wrench, closed) == Status::ok);
      REQUIRE(plant.accelerate(pose, twist, torque, wrench, other) == Status::ok);
      worst = std::max(worst, test::relativeError(other, closed));
      closure = std::max(closure, plant.closureError());
    }
    // Sums of about 30 terms, times the condition number of the inertia (up to 1e3).
    CHECK(worst < 1e-11);
    CHECK(closure < 1e-14);
  }
}

TEST_CASE("multibody: linear models of every shipped device", "[multibody]") {
  constexpr double h = 1e-5;
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto device = shipped.mechanism();
    MultibodyPlant plant(shipped.parameters());
    const int n = device->joints();
    // Change of the acceleration with pose, twist and torques, about rest at home.
    const auto model = [&](const auto& accelerate) {
      const auto at = [&](int i, double by) {
        Pose pose;
        Vec6 twist = Vec6::Zero(), acceleration = Vec6::Zero();
        JointVector torque = device->home().gravity;
        if (i < 3) pose.position[i] += by;
        if (i >= 3 && i < 6) pose.rotation = test::rotationAbout(Vec3::Unit(i - 3), by);
        if (i >= 6 && i < 12) twist[i - 6] += by;
        if (i >= 12) torque[i - 12] += by;
        REQUIRE(accelerate(pose, twist, torque, acceleration) == Status::ok);
        return acceleration;
      };
      Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(6, 12 + n);
      for (int i = 0; i < 12 + n; ++i)
        if (shipped.turn > 0.0 || i < 3 || (i >= 6 && i < 9) || i >= 12)
          slope.col(i) = (at(i, h) - at(i, -h)) / (2 * h);
      return slope;
    };
    const Eigen::MatrixXd closed = model([&](const Pose& p, const Vec6& v, const JointVector& tau, Vec6& a) {
      return device->accelerate(p, v, tau, Vec6::Zero(), a);
    });
    const Eigen::MatrixXd other = model([&](const Pose& p, const Vec6& v, const JointVector& tau, Vec6& a) {
      return plant.accelerate(p, v, tau, Vec6::Zero(), a);
    });
    for (const auto& [first, columns] : {std::pair(0, 12), std::pair(12, n)}) {  // A, B
      const Eigen::MatrixXd a = closed.middleCols(first, columns), b = other.middleCols(first, columns);
      CHECK((a - b).cwiseAbs().maxCoeff() <= 1e-6 * a.cwiseAbs().maxCoeff());
    }
  }
}

TEST_CASE("multibody: the reference runs to 10 nm, closed to 0.1 nm", "[multibody]") {
  for (const test::ReferenceRun& run : test::referenceRuns()) {
    const TauParameters parameters = run.servo ? test::nominal() : test::dampedNominal();
    HoldRenderer hold = test::holdRenderer(test::asInThePaper());
    ImpedanceRenderer spring({6000.0, 0.0});
    PushSetup setup = test::referenceSetup(run);
    setup.duration = 1e-3 * test::count(1200, 3000);  // the push comes at 1 s; Simbody needs about one second for each
    const TauMechanism model(parameters);
    auto plant = std::make_unique<MultibodyPlant>(parameters);
    const MultibodyPlant& simbody = *plant;
    double worst = 0.0, closure = 0.0;
    const PushResult result = runPush(std::move(plant), model, run.servo ? static_cast<Renderer&>(hold) : spring, setup,
                                      [&](const TickRecord& tick, const VirtualLoop&) {
                                        worst = std::max(worst, std::abs(tick.pose.position.z() - run.z[tick.tick]));
                                        closure = std::max(closure, simbody.closureError());
                                      });
    CHECK(result.status == Status::ok);
    CHECK(result.ticks >= 1200);
    CHECK(worst < 1e-8);
    CHECK(closure < 1e-10);
  }
}

TEST_CASE("multibody: a delta moves as its closed form", "[multibody]") {
  const DeviceParameters parameters = loadDevice(test::deviceFile("delta.toml"));
  const auto device = makeMechanism(parameters);
  MultibodyPlant plant(parameters);
  ClosedFormPlant closed(*device, Integrator::rungeKutta4, 4);
  Pose start;
  start.position = Vec3(0.01, -0.02, 0.015);
  const auto spring = [](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>() = -300.0 * pose.position - 2.0 * twist.head<3>() + 3.0 * std::sin(50.0 * time) * Vec3::UnitX();
    return wrench;
  };
  REQUIRE(plant.start(start) == Status::ok);
  REQUIRE(closed.start(start) == Status::ok);
  double worst = 0.0, angles = 0.0;
  for (int i = 0; i < 200; ++i) {
    const JointVector torque = device->home().gravity;
    REQUIRE(plant.advance(i * 1e-3, 1e-3, torque, spring) == Status::ok);
    REQUIRE(closed.advance(i * 1e-3, 1e-3, torque, spring) == Status::ok);
    worst = std::max(worst, (plant.state().position - closed.state().position).norm());
    Kinematics truth;
    REQUIRE(device->reach(plant.state().pose(), plant.state().twist, false, truth) == Status::ok);
    JointVector q, rates;
    plant.read(truth, q, rates);
    angles =
        std::max({angles, (q - truth.q).cwiseAbs().maxCoeff(), 1e-2 * (rates - truth.rates).cwiseAbs().maxCoeff()});
  }
  CHECK(plant.state().position.norm() > 1e-4);
  CHECK(worst < 1e-8);
  CHECK(angles < 1e-9);
  CHECK(plant.closureError() < 1e-10);
}

TEST_CASE("multibody: the same bits in two threads, failures change nothing", "[multibody]") {
  const auto end = [] {
    MultibodyPlant plant(test::nominal());
    (void)plant.start(Pose());
    const JointVector torque = 1.2 * plant.mechanism().home().gravity;
    for (int i = 0; i < 50; ++i) (void)plant.advance(i * 1e-3, 1e-3, torque, nothing);
    return plant.state();
  };
  DeviceState one, two;
  std::thread other([&] { one = end(); });
  two = end();
  other.join();
  CHECK(one.position == two.position);
  CHECK(one.twist == two.twist);
  CHECK(one.position != Vec3(Vec3::Zero()));

  MultibodyPlant plant(test::nominal());
  Pose away;
  away.position.x() = 1.0;
  CHECK(plant.start(away) != Status::ok);
  REQUIRE(plant.start(Pose()) == Status::ok);
  const DeviceState before = plant.state();
  const JointVector gravity = plant.mechanism().home().gravity;
  const auto blow = [](double, const Pose&, const Vec6&) { return Vec6(1e6 * Vec6::Unit(2)); };
  CHECK(plant.advance(0.0, 1e-3, gravity, blow) != Status::ok);
  CHECK(plant.state().position == before.position);
  CHECK(plant.state().twist == before.twist);
  CHECK(plant.advance(0.0, 1e-3, gravity.head(3), nothing) == Status::outOfRange);
  CHECK(plant.advance(0.0, 1e-3, std::nan("") * gravity, nothing) == Status::notFinite);
  CHECK(plant.advance(0.0, 1e-3, gravity, nothing) == Status::ok);
  CHECK((plant.state().position - before.position).norm() < 1e-9);  // it does not move
  CHECK_THROWS_WITH(MultibodyPlant(test::nominal(), 1.0), test::ContainsSubstring("accuracy is 1"));
}

TEST_CASE("multibody: a copy of a plant in motion moves on bit for bit", "[multibody]") {
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    MultibodyPlant plant(shipped.parameters());
    const JointVector gravity = plant.mechanism().home().gravity;
    const auto drive = [&](Plant& driven, int first, int last) {
      for (int i = first; i < last; ++i) {
        const JointVector torque = (1.0 + 0.1 * std::sin(0.1 * i)) * gravity;
        const auto push = [&](double time, const Pose&, const Vec6&) {
          return (Vec6() << std::sin(40.0 * time), 0.3, -0.5, 0.0, 0.0, 0.0).finished();
        };
        REQUIRE(driven.advance(i * 1e-3, 1e-3, torque, push) == Status::ok);
      }
    };
    const auto same = [](const Plant& a, const Plant& b) {
      return a.state().position == b.state().position && a.state().twist == b.state().twist &&
             a.state().orientation.coeffs() == b.state().orientation.coeffs();
    };
    REQUIRE(plant.start(Pose{}) == Status::ok);
    const auto early = plant.clone();  // before the first step
    drive(plant, 0, 20);
    const auto late = plant.clone();
    CHECK(same(plant, *late));
    drive(plant, 20, 40);
    CHECK_FALSE(same(plant, *late));  // it has not moved
    drive(*late, 20, 40);
    CHECK(same(plant, *late));
    drive(*early, 0, 40);
    CHECK(same(plant, *early));
    // A copy that starts again equals the plant that does.
    REQUIRE(plant.start(Pose{}) == Status::ok);
    REQUIRE(late->start(Pose{}) == Status::ok);
    drive(plant, 0, 20);
    drive(*late, 0, 20);
    CHECK(same(plant, *late));
  }
}

}  // namespace enamel::test_multibody
