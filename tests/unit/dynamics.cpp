// Rigid-body dynamics: reference rows, an assembled KKT system, energy, symmetry.
#include "enamel/device/tau/dynamics.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "bench/assembled_dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/reference.hpp"

namespace enamel::test_dynamics {

using test::relativeError;

namespace {

struct Moving {
  TauConfiguration configuration;
  Vec6 rates, twist;
};

Moving randomMotion(const TauModel& model, test::Random& random) {
  Moving m;
  REQUIRE(inverseKinematics(model, random.workspacePose(0.3), m.configuration) == Status::ok);
  m.rates = random.vector6(4.0, 4.0);
  m.twist = twistFromRates(model, m.configuration, m.rates);
  return m;
}

bench::TreeState treeState(const TauParameters& device, const Moving& m) {
  bench::TreeState state;
  const Vec6 q = jointAngles(m.configuration);
  const Vec3 elbow = elbowAngles(m.configuration);
  for (int i = 0; i < 3; ++i) state.angles[i] = {q[2 * i], q[2 * i + 1], elbow[i]};
  state.pose = m.configuration.pose;
  state.twist = m.twist;
  bench::setRates(device, state);
  return state;
}

}  // namespace

TEST_CASE("dynamics agree with independent engines", "[dynamics]") {
  for (const std::string name : {"tau-nominal", "tau-detailed"}) {
    const TauModel model = makeModel(loadTau(test::deviceFile(name + ".toml")));
    for (const test::ReferenceState& row : test::referenceStates(name)) {
      Pose pose;
      pose.position = row.position;
      pose.rotation = rotationFromEuler(row.euler);
      TauConfiguration c;
      REQUIRE(inverseKinematics(model, pose, c) == Status::ok);
      CHECK(relativeError(massMatrix(model, c), row.massMatrix) < 1e-13);
      CHECK(relativeError(gravityTorque(model, c), row.gravityTorque) < 1e-13);
      const Vec6 twist = twistFromRates(model, c, row.rates);
      const Vec6 torque = row.torque, wrench = row.wrench;
      const Vec6 acceleration = forwardDynamics(model, c, twist, torque, wrench);
      // The condition number of the mass matrix (about 20), in addition to the engines' own 2e-15.
      CHECK(relativeError(jointAccelerations(model, c, twist, acceleration), row.accelerations) < 1e-12);
      CHECK(relativeError(inverseDynamics(model, c, twist, acceleration, wrench), torque) < 1e-12);
    }
  }
}

TEST_CASE("forward dynamics equal an assembled system with loop closures", "[dynamics]") {
  test::Random random(21);
  for (const TauParameters& device : test::someDevices()) {
    const TauModel model = makeModel(device);
    for (int i = 0; i < 100; ++i) {
      const Moving m = randomMotion(model, random);
      const bench::TreeState state = treeState(device, m);
      const Vec6 torque = random.vector6(2.0, 2.0), wrench = random.vector6(10.0, 0.3);
      const bench::TreeAcceleration reference = bench::assembledForwardDynamics(device, state, torque, wrench);
      const Vec6 acceleration = forwardDynamics(model, m.configuration, m.twist, torque, wrench);
      // Pivoted LU of a 24 x 24 system with entries from 1e-5 to 1: up to 1e4 rounding errors.
      CHECK(relativeError(acceleration, reference.twist) < 1e-11);
      CHECK(relativeError(jointAccelerations(model, m.configuration, m.twist, acceleration), reference.joints) < 1e-11);
      CHECK(kineticEnergy(model, m.configuration, m.twist) == Approx(reference.kineticEnergy).epsilon(1e-12));
    }
  }
}

TEST_CASE("inverse dynamics invert forward dynamics, and split into their parts", "[dynamics]") {
  test::Random random(22);
  for (const TauParameters& device : test::someDevices()) {
    const TauModel model = makeModel(device);
    for (int i = 0; i < 50; ++i) {
      const Moving m = randomMotion(model, random);
      const Vec6 torque = random.vector6(2.0, 2.0), wrench = random.vector6(10.0, 0.3);
      const Vec6 acceleration = forwardDynamics(model, m.configuration, m.twist, torque, wrench);
      CHECK(relativeError(inverseDynamics(model, m.configuration, m.twist, acceleration, wrench), torque) < 1e-11);

      const Mat6 j = jacobian(model, m.configuration), mass = massMatrix(model, m.configuration);
      CHECK(mass == mass.transpose());
      CHECK(mass.llt().info() == Eigen::Success);  // positive definite
      const Vec6 second = jointAccelerations(model, m.configuration, m.twist, acceleration);
      // Joint form: M q'' + bias + gravity = tau + J^T F. The bias includes M times the derivative of the map from
      // rates to the twist; it is zero at rest.
      const Vec6 still = forwardDynamics(model, m.configuration, Vec6::Zero(), torque, wrench);
      const Vec6 stillJoints = jointAccelerations(model, m.configuration, Vec6::Zero(), still);
      CHECK(relativeError(mass * stillJoints + gravityTorque(model, m.configuration), torque + j.transpose() * wrench) <
            1e-11);
      CHECK(relativeError(staticTorque(model, m.configuration, wrench),
                          gravityTorque(model, m.configuration) + j.transpose() * wrench) < 1e-12);
      // The bias torque is the torque for V' = 0, without gravity.
      const Vec6 atRestTorque = inverseDynamics(model, m.configuration, m.twist, Vec6::Zero(), Vec6::Zero());
      CHECK(relativeError(biasTorque(model, m.configuration, m.twist) + gravityTorque(model, m.configuration),
                          atRestTorque) < 1e-12);
      CHECK(second.allFinite());
    }
  }
}

TEST_CASE("power balance: the energy changes by the work of torques, wrench, friction and damping", "[dynamics]") {
  test::Random random(23);
  for (const TauParameters& device : test::someDevices()) {
    const TauModel model = makeModel(device);
    for (int i = 0; i < 30; ++i) {
      const Moving m = randomMotion(model, random);
      const Vec6 torque = random.vector6(2.0, 2.0), wrench = random.vector6(10.0, 0.3);
      const Vec6 acceleration = forwardDynamics(model, m.configuration, m.twist, torque, wrench);
      const double power = torque.dot(m.rates) + wrench.dot(m.twist) -
                           m.twist.dot(device.platform.damping.cwiseProduct(m.twist)) -
                           device.motor.viscousFriction * m.rates.squaredNorm();
      // dE/dt by fourth-order differences along the second-order expansion of the motion. Accelerations of 1e4 rad/s^2
      // change the rates by 5 % within h: truncation below 1e-7, rounding 1e-16 E / h = 1e-11.
      const auto energyAt = [&](double t) {
        const Pose& pose = m.configuration.pose;
        Pose moved;
        moved.position = pose.position + t * m.twist.head<3>() + 0.5 * t * t * acceleration.head<3>();
        const Vec3 turn = t * m.twist.tail<3>() + 0.5 * t * t * acceleration.tail<3>();
        moved.rotation = test::rotationAbout(turn.normalized(), turn.norm()) * pose.rotation;
        TauConfiguration c;
        REQUIRE(inverseKinematics(model, moved, c) == Status::ok);
        return kineticEnergy(model, c, m.twist + t * acceleration) + potentialEnergy(model, c);
      };
      const double h = 5e-6;
      const double rate = (8.0 * (energyAt(h) - energyAt(-h)) - (energyAt(2 * h) - energyAt(-2 * h))) / (12.0 * h);
      CHECK(rate == Approx(power).epsilon(1e-6).margin(1e-6));
    }
  }
}

TEST_CASE("gravity torque is the derivative of the potential energy", "[dynamics]") {
  test::Random random(24);
  for (const TauParameters& device : test::someDevices()) {
    const TauModel model = makeModel(device);
    for (int i = 0; i < 30; ++i) {
      const Moving m = randomMotion(model, random);
      const Vec6 torque = gravityTorque(model, m.configuration);
      // Along a twist: dU/dt = tau . q'. Central differences at h = 1e-5 of lengths of 0.1: truncation 1e-8 relative.
      const auto energyAt = [&](double t) {
        Pose moved = m.configuration.pose;
        moved.position += t * m.twist.head<3>();
        moved.rotation =
            test::rotationAbout(m.twist.tail<3>().normalized(), t * m.twist.tail<3>().norm()) * moved.rotation;
        TauConfiguration c;
        REQUIRE(inverseKinematics(model, moved, c) == Status::ok);
        return potentialEnergy(model, c);
      };
      const double h = 1e-5;
      CHECK((energyAt(h) - energyAt(-h)) / (2.0 * h) == Approx(torque.dot(m.rates)).epsilon(1e-6).margin(1e-8));
    }
  }
}

TEST_CASE("effective mass at home, and by a push", "[dynamics]") {
  const TauMechanism device(test::nominal());
  const TauModel& model = device.model();
  CHECK(effectiveMass(device.home(), Vec3::Zero(), Vec3::UnitZ()) == Approx(0.273).margin(0.0005));
  // A unit force at a point accelerates that point along the force by 1 / mass.
  const Vec3 point(0.01, -0.02, 0.06), n = Vec3(1.0, 2.0, -0.5).normalized();
  Vec6 wrench;
  wrench << n, point.cross(n);
  const Vec6 change = forwardDynamics(model, model.home, Vec6::Zero(), Vec6::Zero(), wrench) -
                      forwardDynamics(model, model.home, Vec6::Zero(), Vec6::Zero(), Vec6::Zero());
  const double along = n.dot(change.head<3>() + change.tail<3>().cross(point));
  CHECK(effectiveMass(device.home(), point, n) == Approx(1.0 / along).epsilon(1e-12));
}

}  // namespace enamel::test_dynamics
