// Kinematics of the TAU: inverse kinematics, Jacobians, forward kinematics, distance to singularities.
//
// Every function is noexcept, allocates nothing and may be called from any thread on a shared model.
#pragma once

#include "enamel/device/tau/model.hpp"

namespace enamel {

/// TauConfiguration of the device at a pose: the closed-form inverse kinematics without its angles (law of cosines,
/// chain by chain). `pose.rotation` must be a rotation matrix.
/// Returns notFinite, unreachable (a chain cannot reach) or singular (elbow straight or folded, or a tip on its
/// yaw axis, to 1e-6); `configuration` is then unchanged. Realtime: yes.
[[nodiscard]] Status inverseKinematics(const TauModel& model, const Pose& pose, TauConfiguration& configuration) noexcept;

/// Joint angles q = (yaw1, lift1, yaw2, lift2, yaw3, lift3) of a configuration, rad, each in (-pi, pi].
/// Realtime: yes.
Vec6 jointAngles(const TauConfiguration& configuration) noexcept;

/// Passive elbow angles c, rad, in (-pi, pi]. Realtime: yes.
Vec3 elbowAngles(const TauConfiguration& configuration) noexcept;

/// Inverse kinematics: joint angles of a pose, rad. Statuses as of the overload above; on failure `q` is unchanged.
/// Realtime: yes.
[[nodiscard]] Status inverseKinematics(const TauModel& model, const Pose& pose, Vec6& q) noexcept;

/// Result of a forward kinematics.
struct ForwardKinematicsReport {
  Status status;
  int iterations;   ///< solutions of the 3 x 3 linear system, all continuation steps together
  double residual;  ///< largest error of the three distances between the tips, m
};

/// Forward kinematics, warm start: the configuration with joint angles `q` on the branch that is continued from
/// home.
///
/// The unknowns are the three elevations w_i, the equations the three fixed distances between the tips; Newton's
/// steps are extended by Chebyshev's second-order term (cubic convergence; Traub 1964). `configuration` holds the
/// start (the previous tick's solution, or any configuration nearby; only its tips are read) and receives the solution. A start from which
/// the iteration does not contract at once is dropped and the solution is walked to from home, as
/// forwardKinematicsFromHome() does.
/// Returns notFinite, unreachable, singular or notConverged; `configuration` is then unchanged.
/// Realtime: yes (at most 8 iterations from a near start, kMaxWalkIterations else).
[[nodiscard]] ForwardKinematicsReport forwardKinematics(const TauModel& model, const Vec6& q,
                                                        TauConfiguration& configuration) noexcept;

/// Forward kinematics, cold start: follows the solution along the straight line in joint space from home to `q` in
/// steps short enough that no singularity can lie inside one (the determinant of the loop equations, predicted and
/// corrected, changes by less than 40 % a step) and with the elbows keeping their signs.
/// Returns notFinite; unreachable (the tips cannot be joined at these angles whatever the elbows do); singular (the
/// way meets a singularity: these angles are not on the branch of home along this way). `configuration` is then
/// unchanged. Realtime: yes (at most kMaxWalkIterations).
[[nodiscard]] ForwardKinematicsReport forwardKinematicsFromHome(const TauModel& model, const Vec6& q,
                                                                TauConfiguration& configuration) noexcept;

/// Bound of the iterations of one walk from home.
inline constexpr int kMaxWalkIterations = 600;

/// Knee K of a chain, in W, m. Realtime: yes.
Vec3 kneePoint(const ChainModel& chain, const ChainConfiguration& configuration) noexcept;

/// Inverse Jacobian, 6 x 6: q' = inverseJacobian V, with V = [v; w] the twist of the TCP. Row by row in closed form:
/// yaw rate = t.v_P / rho, lift rate = l2.v_P / (L1 sin c), v_P = v + w x arm. Realtime: yes.
Mat6 inverseJacobian(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Jacobian, 6 x 6: V = J q', tau = J^T F ("A Position-Control Based Approach ...", eq. 3). Closed form: the passive
/// rates follow from the three loop equations, the twist from the velocities of the three tips. Undefined (but
/// finite) at a parallel singularity; see singularity(). Realtime: yes.
Mat6 jacobian(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Joint rates q', rad/s, of a twist [m/s; rad/s]. Realtime: yes.
Vec6 jointRates(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept;

/// Twist of the TCP, [m/s; rad/s], of joint rates, rad/s. Realtime: yes.
Vec6 twistFromRates(const TauModel& model, const TauConfiguration& configuration, const Vec6& rates) noexcept;

/// Wrench on the platform at the TCP, [N; N m], that joint torques (N m) put there: F = J^-T tau. Realtime: yes.
Vec6 wrenchFromTorques(const TauModel& model, const TauConfiguration& configuration, const Vec6& torque) noexcept;

/// Distances to the singularities, dimensionless: 0 at a singularity, at most about 1 far from it.
struct SingularityMeasures {
  double elbow;     ///< smallest |sin c|: serial, a chain straight or folded
  double yaw;       ///< smallest rho / (L1 + L2): serial, a tip on its yaw axis
  double parallel;  ///< |det| of the loop equations, scaled by link and side lengths: the platform gains a freedom
};

/// Distances of a configuration to both kinds of singularity. Realtime: yes.
SingularityMeasures singularity(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Smallest over largest singular value of the Jacobian with lengths measured in units of `length` (m), in [0, 1].
/// Not closed-form (an SVD, about 10 us) but allocation-free. Realtime: yes.
double inverseCondition(const Mat6& jacobian, double length) noexcept;

}  // namespace enamel
