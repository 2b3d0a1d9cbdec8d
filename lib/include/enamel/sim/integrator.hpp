// Fixed-step integration of the device's motion in pose and twist: no drift off the constraints, because the pose
// is the state and the chains follow from it.
#pragma once

#include <Eigen/Geometry>

#include "enamel/device/dynamics.hpp"
#include "enamel/device/kinematics.hpp"

namespace enamel {

/// State of the device in motion.
struct DeviceState {
  Vec3 position = Vec3::Zero();                                                   ///< TCP in W, m
  Eigen::Quaternion<double> orientation = Eigen::Quaternion<double>::Identity();  ///< of P in W, unit length
  Vec6 twist = Vec6::Zero();                                                      ///< [v; w], m/s, rad/s

  Pose pose() const noexcept { return {position, orientation.toRotationMatrix()}; }
};

/// One step of the classical fourth-order Runge-Kutta method (Kutta 1901) under constant joint torques (N m) and the
/// wrench load(time, pose, twist) on the platform at the TCP (N, N m). The quaternion is integrated as a vector and
/// brought back to unit length at every evaluation. Returns the status of the first configuration that is not
/// regular; `state` is then unchanged.
/// Realtime: yes, if `load` is.
template <typename Load>
[[nodiscard]] Status stepRungeKutta4(const DeviceModel& model, double time, double dt, const Vec6& torque,
                                     const Load& load, DeviceState& state) noexcept {
  struct Slope {
    Vec3 position;
    Eigen::Matrix<double, 4, 1> orientation;
    Vec6 twist;
  };
  const auto slopeAt = [&](double t, const DeviceState& s, Slope& slope) -> Status {
    Configuration configuration;
    const Pose pose{s.position, s.orientation.normalized().toRotationMatrix()};
    const Status status = configure(model, pose, configuration);
    if (status != Status::ok) return status;
    const Vec3 w = s.twist.tail<3>();
    slope.position = s.twist.head<3>();
    slope.orientation = 0.5 * (Eigen::Quaternion<double>(0.0, w.x(), w.y(), w.z()) * s.orientation).coeffs();
    slope.twist = forwardDynamics(model, configuration, s.twist, torque, load(t, pose, s.twist));
    return Status::ok;
  };
  const auto moved = [&state](const Slope& slope, double h) {
    DeviceState s = state;
    s.position += h * slope.position;
    s.orientation.coeffs() += h * slope.orientation;
    s.twist += h * slope.twist;
    return s;
  };
  Slope k1, k2, k3, k4;
  if (const Status s = slopeAt(time, state, k1); s != Status::ok) return s;
  if (const Status s = slopeAt(time + 0.5 * dt, moved(k1, 0.5 * dt), k2); s != Status::ok) return s;
  if (const Status s = slopeAt(time + 0.5 * dt, moved(k2, 0.5 * dt), k3); s != Status::ok) return s;
  if (const Status s = slopeAt(time + dt, moved(k3, dt), k4); s != Status::ok) return s;
  const double sixth = dt / 6.0;
  state.position += sixth * (k1.position + 2.0 * (k2.position + k3.position) + k4.position);
  state.orientation.coeffs() += sixth * (k1.orientation + 2.0 * (k2.orientation + k3.orientation) + k4.orientation);
  state.orientation.normalize();
  state.twist += sixth * (k1.twist + 2.0 * (k2.twist + k3.twist) + k4.twist);
  return Status::ok;
}

}  // namespace enamel
