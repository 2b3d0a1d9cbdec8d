// Kinematics of the delta: inverse in closed form, forward by Newton's method. The equations are in model.hpp.
#pragma once

#include "enamel/core/status.hpp"
#include "enamel/device/delta/model.hpp"

namespace enamel {

/// Largest number of iterations of forward kinematics from one start. It tries two starts.
inline constexpr int kMaxDeltaIterations = 30;

/// Smallest distance from a singularity (sin g, sin t3, parallel; dimensionless) that does not count as singular.
inline constexpr double kSmallestDeltaMeasure = 1e-3;

/// Inverse kinematics: compute the configuration of a position (TCP in W, m), from (1). After an error `configuration`
/// is unchanged. Realtime: yes.
/// Statuses: notFinite; unreachable (a leg cannot reach, or leans away from the user); singular (at or past a
/// singularity).
[[nodiscard]] Status inverseKinematics(const DeltaModel& model, const Vec3& position,
                                       DeltaConfiguration& configuration) noexcept;

/// Forward kinematics: compute the configuration of joint angles q (rad) with Newton's method. The equations are
/// ((rho - d - e)^2 + y^2 - b^2) / 2 = 0, where rho is the distance from elbow to platform joint in the plane of a leg.
///
/// The search starts at `configuration.position`. If it fails, it starts again in front of all elbows, outside the
/// convex surfaces. After an error `configuration` is unchanged.
/// Statuses: notFinite; unreachable (no convergence because the legs do not meet, or a leg leans away from the user);
/// singular. Far outside the workspace it may reject a joint vector that has a pose (1 in 1e5 random vectors).
/// Realtime: yes (at most 2 kMaxDeltaIterations iterations).
[[nodiscard]] Status forwardKinematics(const DeltaModel& model, const Vec3& q,
                                       DeltaConfiguration& configuration) noexcept;

/// Return the driven angles t1, rad, in (-pi, pi]. Realtime: yes.
Vec3 jointAngles(const DeltaConfiguration& configuration) noexcept;

/// Return the Jacobian of v = J q', m per rad: the inverse of the rows (2). Realtime: yes.
Mat3 jacobian(const DeltaConfiguration& configuration) noexcept;

}  // namespace enamel
