// Kinematics of the TAU: inverse kinematics, Jacobians, forward kinematics, distance to singularities.
//
// Every function is noexcept, does not allocate, and may be called from any thread on a shared model.
#pragma once

#include "enamel/device/tau/model.hpp"

namespace enamel {

/// Inverse kinematics: compute the configuration of a pose, chain by chain, with the law of cosines. The solution is in
/// closed form and needs no angles. `pose.rotation` must be a rotation matrix. After an error `configuration` is
/// unchanged. Realtime: yes.
/// Statuses: notFinite; unreachable (a chain cannot reach); singular within 1e-6 (a straight or folded elbow, or a tip
/// on its yaw axis).
[[nodiscard]] Status inverseKinematics(const TauModel& model, const Pose& pose,
                                       TauConfiguration& configuration) noexcept;

/// Return the joint angles q = (yaw1, lift1, yaw2, lift2, yaw3, lift3) of a configuration, rad, each in (-pi, pi].
/// Realtime: yes.
Vec6 jointAngles(const TauConfiguration& configuration) noexcept;

/// Return the passive elbow angles c, rad, in (-pi, pi]. Realtime: yes.
Vec3 elbowAngles(const TauConfiguration& configuration) noexcept;

/// Inverse kinematics: compute the joint angles of a pose, rad. Statuses as for the overload above. After an error `q`
/// is unchanged. Realtime: yes.
[[nodiscard]] Status inverseKinematics(const TauModel& model, const Pose& pose, Vec6& q) noexcept;

/// Result of forward kinematics.
struct ForwardKinematicsReport {
  Status status;
  int iterations;   ///< solved 3 x 3 linear systems, in all continuation steps together
  double residual;  ///< largest error of the three distances between the tips, m
};

/// Forward kinematics, warm start: compute the configuration with joint angles `q`, on the branch that continues from
/// home.
///
/// The unknowns are the three elevations w_i. The equations are the three fixed distances between the tips. Newton's
/// steps have Chebyshev's second-order term, for cubic convergence (Traub 1964).
///
/// On input `configuration` holds the start: the previous tick's solution or any configuration nearby. Only its tips
/// are read. On output it holds the solution. If the iteration does not contract at once, the search starts again from
/// home, as in forwardKinematicsFromHome().
///
/// Statuses: notFinite; unreachable; singular; notConverged. After an error `configuration` is unchanged.
/// Realtime: yes (at most 8 iterations from a near start, otherwise at most kMaxWalkIterations).
[[nodiscard]] ForwardKinematicsReport forwardKinematics(const TauModel& model, const Vec6& q,
                                                        TauConfiguration& configuration) noexcept;

/// Forward kinematics, cold start: follow the solution along the straight line in joint space from home to `q`. The
/// steps are so short that no singularity fits inside one: the predicted and corrected determinant of the loop
/// equations changes by less than 40 % a step. The elbows keep their signs.
///
/// Statuses: notFinite; unreachable; singular. After an error `configuration` is unchanged.
/// - unreachable: the tips cannot meet at these angles for any elbow angles.
/// - singular: the path crosses a singularity, so these angles are not on the branch of home along this path.
///
/// Realtime: yes (at most kMaxWalkIterations).
[[nodiscard]] ForwardKinematicsReport forwardKinematicsFromHome(const TauModel& model, const Vec6& q,
                                                                TauConfiguration& configuration) noexcept;

/// Largest number of iterations of one walk from home.
inline constexpr int kMaxWalkIterations = 600;

/// Return the knee K of a chain, in W, m. Realtime: yes.
Vec3 kneePoint(const ChainModel& chain, const ChainConfiguration& configuration) noexcept;

/// Return the inverse Jacobian, 6 x 6: q' = inverseJacobian V, where V = [v; w] is the twist of the TCP. Each row has a
/// closed form: yaw rate = t.v_P / rho, lift rate = l2.v_P / (L1 sin c), v_P = v + w x arm. Realtime: yes.
Mat6 inverseJacobian(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Return the Jacobian, 6 x 6: V = J q', tau = J^T F ("A Position-Control Based Approach ...", eq. 3). It has a closed
/// form: the passive rates follow from the three loop equations, the twist from the velocities of the three tips. At a
/// parallel singularity the result is finite but undefined; see singularity(). Realtime: yes.
Mat6 jacobian(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Return the joint rates q', rad/s, of a twist [m/s; rad/s]. Realtime: yes.
Vec6 jointRates(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept;

/// Return the twist of the TCP, [m/s; rad/s], of joint rates, rad/s. Realtime: yes.
Vec6 twistFromRates(const TauModel& model, const TauConfiguration& configuration, const Vec6& rates) noexcept;

/// Return the wrench on the platform at the TCP, [N; N m], from joint torques (N m): F = J^-T tau. Realtime: yes.
Vec6 wrenchFromTorques(const TauModel& model, const TauConfiguration& configuration, const Vec6& torque) noexcept;

/// Distances to the singularities, dimensionless: 0 at a singularity, at most about 1 far from it.
struct SingularityMeasures {
  double elbow;     ///< serial singularity of a straight or folded chain: smallest |sin c|
  double yaw;       ///< serial singularity of a tip on its yaw axis: smallest rho / (L1 + L2)
  double parallel;  ///< parallel singularity: |det| of the loop equations, scaled by link and side lengths
};

/// Return the distances of a configuration to the serial and parallel singularities. Realtime: yes.
SingularityMeasures singularity(const TauModel& model, const TauConfiguration& configuration) noexcept;

/// Return the smallest singular value of the Jacobian divided by the largest, in [0, 1]. Lengths are in units of
/// `length` (m). The SVD takes about 10 us and does not allocate. Realtime: yes.
double inverseCondition(const Mat6& jacobian, double length) noexcept;

}  // namespace enamel
