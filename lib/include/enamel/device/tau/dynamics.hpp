// Rigid-body dynamics of the TAU without constraint multipliers.
//
// Every chain is a planar two-link arm on a yaw column with the coordinates (a, b, w) and a 3 x 3 inertia in closed
// form. Its rates are linear in the velocity of its tip, so each chain acts on the platform like a body at its tip:
//   Lambda V' + h(V) + gravity = F + J^-T tau,   M(q) = J^T Lambda J,
// with V = [v; w] and the wrench F = [f; m] at the TCP in the axes of W. Rotor inertias stand at the driven joints.
//
// Every function is noexcept, allocates nothing and may be called from any thread on a shared model. Configurations
// must come from inverseKinematics() or forwardKinematics(): they are not singular.
#pragma once

#include "enamel/device/tau/model.hpp"

namespace enamel {

/// Inertia Lambda seen at the TCP, 6 x 6, symmetric: kinetic energy = V^T Lambda V / 2. Realtime: yes.
Mat6 taskInertia(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Joint-space mass matrix M = J^T Lambda J, 6 x 6, symmetric, kg m^2; `jacobian` is that of the configuration.
/// Realtime: yes.
Mat6 massMatrix(const TauModel& model, const TauConfiguration& configuration, const Mat6& jacobian) noexcept;
Mat6 massMatrix(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Joint torque that balances gravity at rest, N m; `jacobian` is that of the configuration. Realtime: yes.
Vec6 gravityTorque(const TauModel& model, const TauConfiguration& configuration, const Mat6& jacobian) noexcept;
Vec6 gravityTorque(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Joint torque that balances gravity and puts the wrench F on the platform at rest, N m: g(q) + J^T F. Realtime: yes.
Vec6 staticTorque(const TauModel& model, const TauConfiguration& configuration, const Vec6& wrench) noexcept;

/// Joint torque that balances everything that depends on velocity, N m: Coriolis and centrifugal terms, viscous
/// friction of the joints and damping of the TCP. Realtime: yes.
Vec6 biasTorque(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept;

/// Forward dynamics: acceleration V' = [v'; w'] of the TCP under joint torques tau (N m) and a wrench F on the
/// platform at the TCP (N, N m), with gravity, friction and damping. Realtime: yes.
Vec6 forwardDynamics(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                     const Vec6& torque, const Vec6& wrench) noexcept;

/// Inverse dynamics: joint torques tau, N m, for an acceleration V' under a wrench F. Realtime: yes.
Vec6 inverseDynamics(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                     const Vec6& acceleration, const Vec6& wrench) noexcept;

/// Joint accelerations q'', rad/s^2, of a twist and its derivative. Realtime: yes.
Vec6 jointAccelerations(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                        const Vec6& acceleration) noexcept;

/// Kinetic energy, J. Realtime: yes.
double kineticEnergy(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept;

/// Potential energy in gravity, J, up to a constant of the device. Realtime: yes.
double potentialEnergy(const TauModel& model, const TauConfiguration& configuration) noexcept;

}  // namespace enamel
