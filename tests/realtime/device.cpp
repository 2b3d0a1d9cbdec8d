// No real-time function of the device allocates. Allocations are counted by interposition, with valid and invalid
// input.
#include <new>

#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/sim/integrator.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/mechanisms.hpp"

namespace enamel::test_device {

TEST_CASE("the counter counts", "[realtime]") {
  const long before = test::allocationCount();
  for (int i = 0; i < 2; ++i) {
    void* volatile kept = ::operator new(100);  // volatile: Clang removes unused allocations
    ::operator delete(kept);
  }
  CHECK(test::allocationCount() >= before + 2);
}

TEST_CASE("the device module allocates nothing in a tick", "[realtime]") {
  const TauMechanism device(test::detailed());
  const TauModel& model = device.model();
  test::Random random(61);
  double sum = 0.0;
  long allocated = 0;
  for (int i = 0; i < 1000; ++i) {
    Pose pose = random.workspacePose();
    if (i % 10 == 0) pose.position *= 20.0;
    if (i % 25 == 0) pose.position[0] = std::nan("");
    const Vec6 v = random.vector6(1.0, 1.0);
    const long before = test::allocationCount();
    TauConfiguration c = model.home, cold = model.home;
    Vec6 q = model.homeAngles;
    if (inverseKinematics(model, pose, q) == Status::ok) sum += q[0];
    if (forwardKinematics(model, q + 0.3 * v, c).status == Status::ok) sum += c.pose.position[0];
    if (forwardKinematicsFromHome(model, q + 0.3 * v, cold).status == Status::ok) sum += cold.pose.position[0];
    sum += jacobian(model, c)(0, 0) + inverseJacobian(model, c)(0, 0) + massMatrix(model, c)(0, 0);
    sum += gravityTorque(model, c)[0] + biasTorque(model, c, v)[0] + jointRates(model, c, v)[0];
    const Vec6 acceleration = forwardDynamics(model, c, v, v, v);
    sum += jointAccelerations(model, c, v, acceleration)[0] + inverseDynamics(model, c, v, acceleration, v)[0];
    sum += kineticEnergy(model, c, v) + potentialEnergy(model, c) + twistFromRates(model, c, v)[0];
    sum += effectiveMass(device.home(), Vec3::Zero(), Vec3::UnitZ()) + singularity(model, c).parallel;
    sum += largestForce(device.home(), device.limits().effort, Vec3::Zero(), Vec3::UnitZ());
    Kinematics k = device.home();
    if (device.track(q + 0.3 * v, v, i % 2 == 0, k) == Status::ok) sum += wrenchOf(k, k.gravity)[2];
    if (device.reach(pose, v, i % 2 == 0, k) == Status::ok) sum += staticTorque(k, v)[1] + twistOf(k.jacobian, k.rates)[0];
    sum += inverseCondition(jacobian(model, c), 0.04);
    DeviceState state;
    if (stepRungeKutta4(
            device, 0.0, 1e-3, v, [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); }, state) ==
        Status::ok)
      sum += state.position[0];
    allocated += test::allocationCount() - before;
  }
  CHECK(std::isfinite(sum));
  CHECK(allocated == 0);
}

TEST_CASE("a mechanism of any kind allocates nothing in a tick", "[realtime]") {
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto mechanism = shipped.mechanism();
    const int n = mechanism->joints();
    test::Random random(62);
    Kinematics kinematics = mechanism->home(), reached = mechanism->home();
    double sum = 0.0;
    long allocated = 0;
    int good = 0, bad = 0;
    for (int i = 0; i < 1000; ++i) {
      Pose pose = shipped.pose(random);
      if (i % 10 == 0) pose.position *= 20.0;
      if (i % 25 == 0) pose.position[0] = std::nan("");
      const Vec6 twist = shipped.twist(random), wrench = random.vector6(5.0, 0.2);
      const JointVector torque = test::randomJoints(random, i % 50 == 7 ? n - 1 : n, 1.0);
      JointVector far = mechanism->home().q + test::randomJoints(random, n, 3.0);
      Vec6 acceleration = Vec6::Zero();
      const auto count = [&](Status status) { ++(status == Status::ok ? good : bad); };
      const long before = test::allocationCount();
      const bool withInertia = i % 2 == 0;
      count(mechanism->reach(pose, twist, withInertia, reached));
      count(mechanism->track(reached.q, reached.rates, withInertia, kinematics));
      count(mechanism->track(far, reached.rates, withInertia, kinematics));
      count(mechanism->accelerate(pose, twist, torque, wrench, acceleration));
      sum += acceleration[0] + twistOf(kinematics.jacobian, kinematics.rates)[0];
      sum += torqueOf(kinematics.jacobian, wrench)[0] + wrenchOf(kinematics, kinematics.gravity)[0];
      sum += largestForce(kinematics, mechanism->limits().effort, kinematics.pose.position, Vec3::UnitZ());
      sum += effectiveMass(mechanism->home(), Vec3::Zero(), Vec3::UnitX());
      allocated += test::allocationCount() - before;
    }
    CHECK(std::isfinite(sum));
    CHECK(good > 2000);
    CHECK(bad > 100);
    CHECK(allocated == 0);
  }
}
}  // namespace enamel::test_device
