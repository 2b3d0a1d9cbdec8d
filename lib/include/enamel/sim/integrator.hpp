// Fixed-step integration of a mechanism's motion in pose and twist. The pose is the state, and the chains follow from
// it. The integration therefore does not drift off the constraints.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "enamel/device/mechanism.hpp"

namespace enamel {

/// State of the device in motion.
struct DeviceState {
  Vec3 position = Vec3::Zero();                                                   ///< TCP in W, m
  Eigen::Quaternion<double> orientation = Eigen::Quaternion<double>::Identity();  ///< of P in W, unit length
  Vec6 twist = Vec6::Zero();                                                      ///< [v; w], m/s, rad/s

  Pose pose() const noexcept { return {position, orientation.toRotationMatrix()}; }
};

/// Method of integration between two ticks. `enamel study --convergence` prints the cost of each method and its
/// distance from the converged motion.
enum class Integrator : std::uint8_t {
  rungeKutta4,        ///< classical, fourth order (Kutta 1901), four evaluations per step
  midpoint,           ///< Runge's second-order method (1895), two evaluations
  semiImplicitEuler,  ///< first order, one evaluation: the new velocity moves the pose
};

/// Rates of change of a state.
struct DeviceSlope {
  Vec3 position;                            ///< m/s
  Eigen::Matrix<double, 4, 1> orientation;  ///< of the quaternion's coefficients, 1/s
  Vec6 twist;                               ///< m/s^2, rad/s^2
};

namespace detail {

inline Eigen::Matrix<double, 4, 1> orientationRate(const DeviceState& s, const Vec6& twist) noexcept {
  return 0.5 * (Eigen::Quaternion<double>(0.0, twist[3], twist[4], twist[5]) * s.orientation).coeffs();
}

template <typename WrenchAt>
Status slopeAt(const Mechanism& mechanism, double time, const DeviceState& s, const JointVector& torque,
               const WrenchAt& load, DeviceSlope& slope) noexcept {
  const Pose pose{s.position, s.orientation.normalized().toRotationMatrix()};
  slope.position = s.twist.head<3>();
  slope.orientation = orientationRate(s, s.twist);
  return mechanism.accelerate(pose, s.twist, torque, load(time, pose, s.twist), slope.twist);
}

inline DeviceState moved(const DeviceState& state, const DeviceSlope& slope, double h) noexcept {
  DeviceState s = state;
  s.position += h * slope.position;
  s.orientation.coeffs() += h * slope.orientation;
  s.twist += h * slope.twist;
  return s;
}

inline DeviceSlope weighted(const DeviceSlope& k1, const DeviceSlope& k2, const DeviceSlope& k3,
                            const DeviceSlope& k4) noexcept {
  return {k1.position + 2.0 * (k2.position + k3.position) + k4.position,
          k1.orientation + 2.0 * (k2.orientation + k3.orientation) + k4.orientation,
          k1.twist + 2.0 * (k2.twist + k3.twist) + k4.twist};
}

// Kutta's step for any state with moved() and weighted(). `state` is unchanged if a slope fails.
template <typename Slope, typename State, typename SlopeAt>
Status rungeKutta4(double time, double dt, const SlopeAt& slopeAt, State& state) noexcept {
  Slope k1, k2, k3, k4;
  if (const Status s = slopeAt(time, state, k1); s != Status::ok) return s;
  if (const Status s = slopeAt(time + 0.5 * dt, moved(state, k1, 0.5 * dt), k2); s != Status::ok) return s;
  if (const Status s = slopeAt(time + 0.5 * dt, moved(state, k2, 0.5 * dt), k3); s != Status::ok) return s;
  if (const Status s = slopeAt(time + dt, moved(state, k3, dt), k4); s != Status::ok) return s;
  state = moved(state, weighted(k1, k2, k3, k4), dt / 6.0);
  return Status::ok;
}

}  // namespace detail

/// Integrate one step by the classical fourth-order Runge-Kutta method. The joint torques are constant (N m or N).
/// load(time, pose, twist) is the wrench on the platform at the TCP (N, N m). The quaternion is integrated as a vector
/// and normalised at every evaluation. Returns the status of the first singular configuration; `state` is then
/// unchanged. Realtime: yes, if `load` is.
template <typename WrenchAt>
[[nodiscard]] Status stepRungeKutta4(const Mechanism& mechanism, double time, double dt, const JointVector& torque,
                                     const WrenchAt& load, DeviceState& state) noexcept {
  const auto slopeAt = [&](double t, const DeviceState& s, DeviceSlope& slope) {
    return detail::slopeAt(mechanism, t, s, torque, load, slope);
  };
  const Status status = detail::rungeKutta4<DeviceSlope>(time, dt, slopeAt, state);
  if (status == Status::ok) state.orientation.normalize();
  return status;
}

/// Integrate one step by the midpoint method, otherwise as stepRungeKutta4(). Realtime: yes, if `load` is.
template <typename WrenchAt>
[[nodiscard]] Status stepMidpoint(const Mechanism& mechanism, double time, double dt, const JointVector& torque,
                                  const WrenchAt& load, DeviceState& state) noexcept {
  DeviceSlope slope;
  if (const Status s = detail::slopeAt(mechanism, time, state, torque, load, slope); s != Status::ok) return s;
  const DeviceState middle = detail::moved(state, slope, 0.5 * dt);
  if (const Status s = detail::slopeAt(mechanism, time + 0.5 * dt, middle, torque, load, slope); s != Status::ok)
    return s;
  state = detail::moved(state, slope, dt);
  state.orientation.normalize();
  return Status::ok;
}

/// Integrate one step by the semi-implicit Euler method, otherwise as stepRungeKutta4(). Realtime: yes, if `load` is.
template <typename WrenchAt>
[[nodiscard]] Status stepSemiImplicitEuler(const Mechanism& mechanism, double time, double dt,
                                           const JointVector& torque, const WrenchAt& load,
                                           DeviceState& state) noexcept {
  DeviceSlope slope;
  if (const Status s = detail::slopeAt(mechanism, time, state, torque, load, slope); s != Status::ok) return s;
  state.twist += dt * slope.twist;
  state.position += dt * state.twist.head<3>();
  state.orientation.coeffs() += dt * detail::orientationRate(state, state.twist);
  state.orientation.normalize();
  return Status::ok;
}

/// Integrate one step by the given method. Realtime: yes, if `load` is.
template <typename WrenchAt>
[[nodiscard]] Status stepMotion(Integrator integrator, const Mechanism& mechanism, double time, double dt,
                                const JointVector& torque, const WrenchAt& load, DeviceState& state) noexcept {
  switch (integrator) {
    case Integrator::midpoint: return stepMidpoint(mechanism, time, dt, torque, load, state);
    case Integrator::semiImplicitEuler: return stepSemiImplicitEuler(mechanism, time, dt, torque, load, state);
    case Integrator::rungeKutta4: break;
  }
  return stepRungeKutta4(mechanism, time, dt, torque, load, state);
}

}  // namespace enamel
