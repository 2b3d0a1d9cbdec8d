// Rigid-body dynamics of the delta in the three coordinates of the platform: no constraint forces appear.
//
// Each leg has the coordinates t = (t1, t2, t3) of model.hpp, with t' = B x' from (2) and (3), and the kinetic energy
// of the upper link and rotor and of the two bars. A bar is a uniform thin rod whose ends have the velocities of E and
// G (its neighbour's ends have the same: the crossbars turn about v only), so
//   2 T = I1 t1'^2 + M |vE|^2 + M vE.vb + M |vb|^2 / 3,   vE = a t1' l1' + e t2' l2',   vb = d(b n)/dt,
// M the mass of both bars; the crossbars count with the links they are fixed to. The platform then sees
//   Lambda = m 1 + sum B^T m_t B,  Lambda v' = F + sum B^T (tau - friction - gravity - Coriolis + m_t B x''(t'' = 0))
//            + m g - D v.
#pragma once

#include "enamel/device/delta/model.hpp"

namespace enamel {

/// Lambda, kg, axes of W. Realtime: yes.
Mat3 taskInertia(const DeltaModel& model, const DeltaConfiguration& configuration) noexcept;

/// Force on the platform, N, that balances gravity at rest. Realtime: yes.
Vec3 gravityForce(const DeltaModel& model, const DeltaConfiguration& configuration) noexcept;

/// Acceleration v', m/s^2, under joint torques (N m) and a force on the platform (N), with gravity, friction and
/// damping. Realtime: yes.
Vec3 forwardDynamics(const DeltaModel& model, const DeltaConfiguration& configuration, const Vec3& velocity,
                     const Vec3& torque, const Vec3& force) noexcept;

}  // namespace enamel
