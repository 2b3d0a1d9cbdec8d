#include "enamel/control/device_plant.hpp"

#include "control/dense.hpp"
#include "enamel/control/discretise.hpp"
#include "enamel/control/servo_design.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_device_plant {

using namespace enamel::test;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

TauConfiguration configurationAt(const TauModel& model, const Pose& pose) {
  TauConfiguration c;
  REQUIRE(inverseKinematics(model, pose, c) == Status::ok);
  return c;
}

// Assemble the linear model from the mass matrix, the damping and the slope of gravity, without linearise(): M q'' =
// tau - dg/dq (q - q_op) - (J^T D J + c I) q'. Central differences of g with one extrapolation.
StateSpace assembled(const TauModel& model, const Pose& pose) {
  const TauConfiguration home = configurationAt(model, pose);
  const Mat6 J = jacobian(model, home), inverse = solve(MatrixXd(massMatrix(model, home)), Mat6::Identity());
  const auto slope = [&](double h) {
    Mat6 S;
    for (int i = 0; i < 6; ++i) {
      Vec6 g[2];
      for (const int side : {0, 1}) {
        Pose moved = pose;
        const double step = side == 1 ? h : -h;
        if (i < 3)
          moved.position[i] += step;
        else
          moved.rotation = rotationAbout(Vec3::Unit(i - 3), step) * pose.rotation;
        g[side] = gravityTorque(model, configurationAt(model, moved));
      }
      S.col(i) = (g[1] - g[0]) / (2.0 * h);
    }
    return S;
  };
  const Mat6 S = (4.0 * slope(0.5e-3) - slope(1e-3)) / 3.0 * J;
  const Mat6 damping = Mat6(J.transpose() * model.damping.asDiagonal() * J) + model.viscousFriction * Mat6::Identity();
  StateSpace plant{MatrixXd::Zero(12, 12), MatrixXd::Zero(12, 6)};
  plant.A.topLeftCorner(6, 6) = -inverse * damping;
  plant.A.topRightCorner(6, 6) = -inverse * S;
  plant.A.bottomLeftCorner(6, 6).setIdentity();
  plant.B.topRows(6) = inverse;
  return plant;
}

Linearisation linearised(const DevicePlant& plant) { return linearise(plant.f, plant.h, plant.x0, plant.u0); }

}  // namespace

TEST_CASE("the nominal device at home gives the reference model, from the mechanism to the gain") {
  const DevicePlant plant = devicePlant(std::make_shared<TauMechanism>(nominal()), Pose{});
  const Linearisation linear = linearised(plant);
  CHECK(linear.error < 1e-10);
  CHECK(linear.offset.cwiseAbs().maxCoeff() < 1e-10);  // rest: accelerations of 100 m/s^2 cancel except for rounding
  const ServoDesign design = designServo(outputsAsStates(linear), 1e-3, ServoWeights{});
  // The project's limits; measured 1e-11 (the reference's own differences), 2e-12, 1e-13.
  CHECK(relativeError(design.plant.A, reference("A")) < 1e-8);
  CHECK(relativeError(design.plant.B, reference("B")) < 1e-8);
  CHECK(relativeError(design.augmented.A, reference("Ad")) < 1e-9);
  CHECK(relativeError(design.augmented.B, reference("Bd")) < 1e-9);
  CHECK(relativeError(design.K, reference("K")) < 1e-7);
  CHECK(relativeError(design.P, reference("P")) < 1e-7);
}

TEST_CASE("the linear model of any device is that of its mass matrix, damping and gravity") {
  int devices = 0;
  const auto check = [&devices](const TauParameters& device, const Pose& pose) {
    INFO(device.name);
    const TauModel model = makeModel(device);
    const DevicePlant plant = devicePlant(std::make_shared<TauMechanism>(device), pose);
    const Linearisation linear = linearised(plant);
    const StateSpace y = outputsAsStates(linear), expected = assembled(model, pose);
    CHECK(linear.error < 1e-8);
    // The slope of gravity is accurate to (1 mm / 50 mm)^4 of the stiffness of gravity: 1e-7 with a margin.
    CHECK(relativeError(y.A, expected.A) < 1e-6);
    CHECK(relativeError(y.A.leftCols(6), expected.A.leftCols(6)) < 1e-9);
    CHECK(relativeError(y.B, expected.B) < 1e-10);
    CHECK(relativeError(plant.f(plant.x0, plant.u0) + VectorXd::Ones(12), VectorXd::Ones(12)) < 1e-10);
    const ServoDesign design = designServo(y, 1e-3, ServoWeights{});
    CHECK(relativeError(design.K, designServo(expected, 1e-3, ServoWeights{}).K) < 1e-6);
    ++devices;
  };
  for (const TauParameters& device : someDevices()) check(device, Pose{});
  Pose away;
  away.position = Vec3(0.01, -0.015, 0.02);
  away.rotation = rotationFromEuler(Vec3(0.1, -0.15, 0.05));
  check(nominal(), away);
  check(detailed(), away);
  for (int seed = 101; seed < 101 + count(5, 200); ++seed)
    check(randomDevice(static_cast<std::uint64_t>(seed)), Pose{});
  CHECK(devices == 8 + count(5, 200));
}

TEST_CASE("the rotation vector is a coordinate of the orientation") {
  // Along any motion of x, the twist in x must be that of the pose in x: joint rates are the derivative of q.
  const DevicePlant plant = devicePlant(std::make_shared<TauMechanism>(nominal()), Pose{});
  Random random(5);
  for (int i = 0; i < 50; ++i) {
    VectorXd x(12);
    x << random.vector6(0.01, 0.2), random.vector6(0.1, 2.0);
    const VectorXd rate = plant.f(x, plant.u0);
    const double h = 1e-4;
    const VectorXd ahead = plant.h(x + h * rate), behind = plant.h(x - h * rate), y = plant.h(x);
    // Central difference: error h^2 q''' / 6.
    CHECK(relativeError((ahead - behind).tail(6) / (2.0 * h), y.head(6)) < 1e-5);
  }
}

TEST_CASE("a pose out of reach is refused") {
  Pose far;
  far.position = Vec3(0.0, 0.0, 1.0);
  CHECK_THROWS_AS(devicePlant(std::make_shared<TauMechanism>(nominal()), far), DesignError);
}

}  // namespace enamel::test_device_plant
