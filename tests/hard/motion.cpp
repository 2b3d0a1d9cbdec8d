// Long motion without drive: the energy is conserved, and the integrator has its order.
#include <iostream>

#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/sim/integrator.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_motion {

namespace {

// A conservative spring that keeps the device in its workspace: 100 N/m in translation. In rotation it is the gradient
// of k (3 - trace R) / 2, k = 0.5 N m/rad.
constexpr double kSpring = 100.0, kTurn = 0.5;

Vec6 springWrench(double, const Pose& pose, const Vec6&) {
  const Mat3& r = pose.rotation;
  Vec6 wrench;
  wrench << -kSpring * pose.position, -0.5 * kTurn * Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  return wrench;
}

double energy(const TauModel& model, const DeviceState& state) {
  TauConfiguration c;
  if (inverseKinematics(model, state.pose(), c) != Status::ok) return HUGE_VAL;
  return kineticEnergy(model, c, state.twist) + potentialEnergy(model, c) +
         0.5 * kSpring * state.position.squaredNorm() + 0.5 * kTurn * (3.0 - c.pose.rotation.trace());
}

DeviceState moved(const Mechanism& device, DeviceState state, double duration, double dt) {
  const int steps = static_cast<int>(std::lround(duration / dt));
  for (int i = 0; i < steps; ++i)
    REQUIRE(stepRungeKutta4(device, i * dt, dt, JointVector::Zero(6), springWrench, state) == Status::ok);
  return state;
}

TauParameters conservative(TauParameters device) {
  device.gravity.setZero();
  device.platform.damping.setZero();
  device.motor.viscousFriction = 0.0;
  return device;
}

DeviceState startState() {
  DeviceState state;
  state.position = {0.005, -0.004, 0.006};
  state.twist << 0.05, 0.08, -0.06, 0.5, -0.4, 0.6;
  return state;
}

}  // namespace

TEST_CASE("undriven motion keeps its energy for 10 s", "[hard]") {
  for (const TauParameters& device : {test::nominal(), test::detailed(), test::randomDevice(3)}) {
    const TauMechanism mechanism(conservative(device));
    const TauModel& model = mechanism.model();
    const DeviceState start = startState();
    const double before = energy(model, start);
    // Runge-Kutta loses (w h)^6 / 72 of the energy per step: 2e-11 in 10 s at h = 50 us and w = 80 rad/s.
    const double after = energy(model, moved(mechanism, start, 10.0, 5e-5));
    std::cout << device.name << ": relative energy drift over 10 s " << (after - before) / before << "\n";
    CHECK(std::abs(after - before) < 1e-10 * before);
  }
}

TEST_CASE("the integrator is of fourth order", "[hard]") {
  const TauMechanism device(conservative(test::detailed()));
  const DeviceState start = startState();
  const DeviceState exact = moved(device, start, 0.2, 0.2 / 3200);
  const auto errorAt = [&](int steps) {
    const DeviceState s = moved(device, start, 0.2, 0.2 / steps);
    return (s.position - exact.position).norm() + 0.1 * (s.orientation.coeffs() - exact.orientation.coeffs()).norm();
  };
  const double coarse = errorAt(50), middle = errorAt(100), fine = errorAt(200);
  std::cout << "halving the step divides the error by " << coarse / middle << ", " << middle / fine << "\n";
  // 16 in the limit; at these steps higher-order terms are still visible.
  CHECK(middle / fine > 13.0);
  CHECK(middle / fine < 19.0);
  CHECK(coarse / middle > 11.0);
}

}  // namespace enamel::test_motion
