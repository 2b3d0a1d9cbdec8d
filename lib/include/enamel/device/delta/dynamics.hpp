// Rigid-body dynamics of the delta in the three coordinates of the platform, without constraint forces.
//
// Each leg has the coordinates t = (t1, t2, t3) of model.hpp, and t' = B x' follows from (2) and (3). Its kinetic
// energy T is that of the upper link, the rotor and the two bars:
//
//   2 T = I1 t1'^2 + M |vE|^2 + M vE.vb + M |vb|^2 / 3,   vE = a t1' l1' + e t2' l2',   vb = d(b n)/dt.
//
// M is the mass of both bars. A bar is a uniform thin rod, and its ends have the velocities of E and G. The other bar's
// ends have the same velocities, because the crossbars rotate about v only. The mass of the crossbars belongs to the
// links that they are fixed to. The platform then has the equation of motion
//
//   Lambda v' = F + sum B^T (tau - friction - gravity - Coriolis + m_t B x''(t'' = 0)) + m g - D v,
//   Lambda = m 1 + sum B^T m_t B.
#pragma once

#include "enamel/device/delta/model.hpp"

namespace enamel {

/// Return the inertia Lambda, kg, axes of W. Realtime: yes.
Mat3 taskInertia(const DeltaModel& model, const DeltaConfiguration& configuration) noexcept;

/// Return the force on the platform, N, that balances gravity at rest. Realtime: yes.
Vec3 gravityForce(const DeltaModel& model, const DeltaConfiguration& configuration) noexcept;

/// Return the acceleration v', m/s^2, under joint torques (N m) and a force on the platform (N), with gravity, friction
/// and damping. Realtime: yes.
Vec3 forwardDynamics(const DeltaModel& model, const DeltaConfiguration& configuration, const Vec3& velocity,
                     const Vec3& torque, const Vec3& force) noexcept;

}  // namespace enamel
