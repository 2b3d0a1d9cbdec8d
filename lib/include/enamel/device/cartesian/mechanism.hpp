// A Cartesian device as a Mechanism.
//
// With 3 axes, q is the position of the TCP (m), tau is the force (N), and the platform keeps the axes of W.
//
// With 6 axes, q = (p, v) with the rotation R = exp([v]x), V = J q' and tau = J^T F, where
//
//   J = diag(1, E),  E(v) = 1 + (1 - cos t)/t^2 [v]x + (t - sin t)/t^3 [v]x^2,  t = |v|,  det E = 2 (1 - cos t)/t^2.
//
// E is the left Jacobian of SO(3) (T. D. Barfoot, "State Estimation for Robotics", 2017, eq. 7.77). The last three
// torques equal the moment near home. Elsewhere they are conjugate to v'.
#pragma once

#include "enamel/device/cartesian/parameters.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Largest rotation from home, rad. v is unique below pi, and the singularity of E at 2 pi is far away.
inline constexpr double kMaxCartesianTurn = 2.5;

/// Mechanism of a Cartesian device. It has no singularity. limits() has max_force for the first three joints,
/// max_moment for the others, and 0 for an axis without a motor. Its encoder steps are position_step and angle_step.
/// Status unreachable means:
/// - a position outside the workspace;
/// - a rotation by more than kMaxCartesianTurn;
/// - with 3 axes, a pose rotated by more than 1e-9 rad, or a twist that rotates faster than 1e-9 rad/s.
class CartesianMechanism final : public Mechanism {
 public:
  /// Throws ConfigurationError: as checkCartesian() and setHome(). Realtime: no.
  explicit CartesianMechanism(const CartesianParameters& parameters);

  [[nodiscard]] Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  /// Mechanism::accelerate() from m v' = f + F + m g - D v and I w' + w x I w = the moments - D w.
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) const noexcept override;
  /// Return three bars through the TCP along the axes of P: the links of the device are unknown.
  std::vector<Bar> bars(const Pose& pose) const override;

 private:
  Status reach(const Pose& pose, const Vec6& twist, Vec3& turn) const noexcept;
  double massAt(const Vec3& position, Vec3& gradient) const noexcept;
  void evaluate(const Vec3& turn, bool withInertia, Kinematics& kinematics) const noexcept;

  CartesianParameters device_;
};

}  // namespace enamel
