// Rigid-body dynamics of the TAU without constraint multipliers.
//
// Each chain is a planar two-link arm on a yaw column, with the coordinates (a, b, w) and a 3 x 3 inertia in closed
// form. Its rates are linear in the velocity of its tip, so it acts on the platform like a body at its tip:
//
//   Lambda V' + h(V) + gravity = F + J^-T tau,   M(q) = J^T Lambda J.
//
// V = [v; w] is the twist and F = [f; m] the wrench, both at the TCP and in the axes of W. The inertias of the rotors
// act at the driven joints.
//
// Every function is noexcept, does not allocate, and may be called from any thread on a shared model. Configurations
// must come from inverseKinematics() or forwardKinematics(), which never return a singular one.
#pragma once

#include "enamel/device/tau/model.hpp"

namespace enamel {

/// Return the inertia Lambda at the TCP, 6 x 6, symmetric: kinetic energy = V^T Lambda V / 2. Realtime: yes.
Mat6 taskInertia(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Return the joint-space mass matrix M = J^T Lambda J, 6 x 6, symmetric, kg m^2. `jacobian` is that of the
/// configuration. Realtime: yes.
Mat6 massMatrix(const TauModel& model, const TauConfiguration& configuration, const Mat6& jacobian) noexcept;
Mat6 massMatrix(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Return the joint torque that balances gravity at rest, N m. `jacobian` is that of the configuration. Realtime: yes.
Vec6 gravityTorque(const TauModel& model, const TauConfiguration& configuration, const Mat6& jacobian) noexcept;
Vec6 gravityTorque(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Return the joint torque g(q) + J^T F, N m. At rest it balances gravity and applies the wrench F to the platform.
/// Realtime: yes.
Vec6 staticTorque(const TauModel& model, const TauConfiguration& configuration, const Vec6& wrench) noexcept;

/// Return the joint torque that balances all velocity-dependent terms, N m: Coriolis and centrifugal terms, viscous
/// friction of the joints and damping of the TCP. Realtime: yes.
Vec6 biasTorque(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept;

/// Forward dynamics: return the acceleration V' = [v'; w'] of the TCP, with gravity, friction and damping. Inputs are
/// the joint torques tau (N m) and the wrench F on the platform at the TCP (N, N m). Realtime: yes.
Vec6 forwardDynamics(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                     const Vec6& torque, const Vec6& wrench) noexcept;

/// Inverse dynamics: return the joint torques tau, N m, for an acceleration V' under a wrench F. Realtime: yes.
Vec6 inverseDynamics(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                     const Vec6& acceleration, const Vec6& wrench) noexcept;

/// Return the joint accelerations q'', rad/s^2, of a twist and its derivative. Realtime: yes.
Vec6 jointAccelerations(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                        const Vec6& acceleration) noexcept;

/// Return the kinetic energy, J. Realtime: yes.
double kineticEnergy(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept;

/// Return the potential energy in gravity, J, up to a constant of the device. Realtime: yes.
double potentialEnergy(const TauModel& model, const TauConfiguration& configuration) noexcept;

}  // namespace enamel
