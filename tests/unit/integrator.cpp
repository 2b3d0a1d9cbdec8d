// The integrators of the plant: their orders, and that the default is unchanged.
#include "enamel/sim/integrator.hpp"

#include <cmath>

#include "enamel/device/tau/mechanism.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_integrator {

namespace {

// Move the device for 20 ms with a torque near gravity's, a spring and a changing force.
DeviceState after(Integrator integrator, int steps) {
  const TauMechanism device(test::nominal());
  DeviceState state;
  state.twist << 0.05, -0.03, 0.08, 0.4, -0.6, 0.3;
  const JointVector torque = device.home().gravity + (Vec6() << 5e-3, 1e-2, -4e-3, 8e-3, 2e-3, -1e-2).finished();
  const auto spring = [](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>() = -300.0 * pose.position - 2.0 * twist.head<3>();
    wrench[2] += 3.0 * std::sin(50.0 * time);
    return wrench;
  };
  const double dt = 0.02 / steps;
  for (int i = 0; i < steps; ++i)
    REQUIRE(stepMotion(integrator, device, i * dt, dt, torque, spring, state) == Status::ok);
  return state;
}

double distance(const DeviceState& a, const DeviceState& b) {
  return (a.position - b.position).norm() + angleBetween(a.pose().rotation, b.pose().rotation) +
         1e-2 * (a.twist - b.twist).norm();
}

}  // namespace

TEST_CASE("integrators converge with their orders to the same motion", "[integrator]") {
  const DeviceState reference = after(Integrator::rungeKutta4, 1024);
  const struct {
    Integrator integrator;
    double order;
  } cases[] = {{Integrator::semiImplicitEuler, 1.0}, {Integrator::midpoint, 2.0}, {Integrator::rungeKutta4, 4.0}};
  for (const auto& c : cases) {
    const double coarse = distance(after(c.integrator, 20), reference),
                 fine = distance(after(c.integrator, 40), reference);
    INFO("order " << c.order << ": " << coarse << ", " << fine);
    CHECK(fine > 0.0);
    // The next term of the error is a few per cent at these steps.
    CHECK(std::log2(coarse / fine) == Approx(c.order).margin(0.15));
  }
}

TEST_CASE("a step that leaves the workspace changes nothing", "[integrator]") {
  const TauMechanism device(test::nominal());
  for (const Integrator integrator : {Integrator::semiImplicitEuler, Integrator::midpoint, Integrator::rungeKutta4}) {
    DeviceState state;
    state.position.x() = 1.0;
    const auto none = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };
    CHECK(stepMotion(integrator, device, 0.0, 1e-3, JointVector::Zero(6), none, state) == Status::unreachable);
    CHECK(state.position == Vec3(1.0, 0.0, 0.0));
    CHECK(state.twist == Vec6::Zero());
  }
}

}  // namespace enamel::test_integrator
