// Kinematics of the delta: closed inverse, Newton forward; equations in model.hpp.
#pragma once

#include "enamel/core/status.hpp"
#include "enamel/device/delta/model.hpp"

namespace enamel {

/// Iterations that forward kinematics makes at most from one start; it tries two starts.
inline constexpr int kMaxDeltaIterations = 30;

/// Smallest distance from a singularity (sin g, sin t3, parallel; dimensionless) that is not called singular.
inline constexpr double kSmallestDeltaMeasure = 1e-3;

/// Inverse kinematics: configuration of a position (TCP in W, m), from (1). Statuses: notFinite; unreachable (a leg
/// does not reach, or would lean away from the user); singular (at or beyond a singularity). `configuration` is then
/// unchanged. Realtime: yes.
[[nodiscard]] Status inverseKinematics(const DeltaModel& model, const Vec3& position,
                                       DeltaConfiguration& configuration) noexcept;

/// Forward kinematics: configuration of joint angles q (rad) by Newton's method on ((rho - d - e)^2 + y^2 - b^2) / 2 =
/// 0, rho the distance of the platform joint from the elbow in the plane of a leg. `configuration.position` is where
/// the search begins; where that fails, it begins again in front of all elbows, from where the convex surfaces are met
/// from outside. Statuses: notFinite; unreachable (no convergence: the legs do not meet; or a leg leans away from the
/// user); singular; `configuration` is then unchanged. Far outside the workspace a joint vector that
/// has a pose may be refused (1 in 1e5 of random ones). Realtime: yes (at most 2 kMaxDeltaIterations iterations).
[[nodiscard]] Status forwardKinematics(const DeltaModel& model, const Vec3& q,
                                       DeltaConfiguration& configuration) noexcept;

/// Driven angles t1, rad, in (-pi, pi]. Realtime: yes.
Vec3 jointAngles(const DeltaConfiguration& configuration) noexcept;

/// v = J q', m per rad: the inverse of the rows (2). Realtime: yes.
Mat3 jacobian(const DeltaConfiguration& configuration) noexcept;

}  // namespace enamel
