// A Cartesian device as a Mechanism.
//
// 3 axes: q is the position of the TCP (m), tau the force (N); the platform keeps the axes of W.
// 6 axes: q = (p, v) with the rotation R = exp([v]x). Then V = J q' with
//   J = diag(1, E),  E(v) = 1 + (1 - cos t)/t^2 [v]x + (t - sin t)/t^3 [v]x^2,  t = |v|,
// the left Jacobian of SO(3) (T. D. Barfoot, "State Estimation for Robotics", 2017, eq. 7.77), and tau = J^T F: the
// last three torques equal the moment near home and are conjugate to v' elsewhere. det E = 2 (1 - cos t)/t^2.
#pragma once

#include "enamel/device/cartesian/parameters.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Largest turn from home, rad: v is unique below pi, and E far from its singularity at 2 pi.
inline constexpr double kMaxCartesianTurn = 2.5;

/// limits(): max_force for the first three joints, max_moment for the others, 0 for an axis without a motor; encoder
/// steps likewise. Unreachable: a position outside the workspace and a turn of more than kMaxCartesianTurn; with 3 axes
/// also a pose turned by more than 1e-9 and a twist that turns faster than 1e-9 rad/s. Nothing is singular.
class CartesianMechanism final : public Mechanism {
 public:
  /// Throws ConfigurationError: as checkCartesian(). Realtime: no.
  explicit CartesianMechanism(const CartesianParameters& parameters);

  [[nodiscard]] Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  /// m v' = f + F + m g - D v; I w' + w x I w = the moments - D w.
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) const noexcept override;
  /// Three bars through the TCP along the axes of P: there is no mechanism to show.
  std::vector<Bar> bars(const Pose& pose) const override;

 private:
  Status reach(const Pose& pose, const Vec6& twist, Vec3& turn) const noexcept;
  double massAt(const Vec3& position, Vec3& gradient) const noexcept;
  void evaluate(const Vec3& turn, bool withInertia, Kinematics& kinematics) const noexcept;

  CartesianParameters device_;
};

}  // namespace enamel
