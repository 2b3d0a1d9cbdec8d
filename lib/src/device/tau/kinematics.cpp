#include "enamel/device/tau/kinematics.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/assert.hpp"
#include "loop.hpp"

namespace enamel {

Status inverseKinematics(const TauModel& model, const Pose& pose, TauConfiguration& configuration) noexcept {
  if (!pose.position.allFinite() || !pose.rotation.allFinite()) return Status::notFinite;
  TauConfiguration result;
  result.pose = pose;
  for (int i = 0; i < 3; ++i) {
    const ChainModel& chain = model.chain[i];
    ChainConfiguration& c = result.chain[i];
    c.arm = pose.rotation * chain.platform;
    c.tip = pose.position + c.arm;
    const Vec3 d = c.tip - chain.base;
    const double l1 = chain.length1, l2 = chain.length2;

    const double radiusSquared = d.x() * d.x() + d.z() * d.z();
    const double distanceSquared = radiusSquared + d.y() * d.y();
    const double cosElbow = (distanceSquared - l1 * l1 - l2 * l2) / (2.0 * l1 * l2);
    const double sineSquared = (1.0 - cosElbow) * (1.0 + cosElbow);
    if (!(sineSquared >= -kSingular * kSingular)) return Status::unreachable;
    c.radius = std::sqrt(radiusSquared);
    if (!(sineSquared > kSingular * kSingular && c.radius > kSingular * (l1 + l2))) return Status::singular;
    c.sinElbow = chain.elbow * std::sqrt(sineSquared);

    const double inverseRadius = 1.0 / c.radius;
    c.sinYaw = d.x() * inverseRadius;
    c.cosYaw = d.z() * inverseRadius;
    // In the plane of the leg, as complex numbers: rho + i h = e^{ib} (L1 + L2 e^{ic}).
    const double along = l1 + l2 * cosElbow, across = l2 * c.sinElbow;
    const double inverse = 1.0 / distanceSquared;
    c.cosLift = (c.radius * along + d.y() * across) * inverse;
    c.sinLift = (d.y() * along - c.radius * across) * inverse;
    c.cosLink2 = c.cosLift * cosElbow - c.sinLift * c.sinElbow;
    c.sinLink2 = c.sinLift * cosElbow + c.cosLift * c.sinElbow;
  }
  configuration = result;
  return Status::ok;
}

Vec6 jointAngles(const TauConfiguration& configuration) noexcept {
  Vec6 q;
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    q[2 * i] = std::atan2(c.sinYaw, c.cosYaw);
    q[2 * i + 1] = std::atan2(c.sinLift, c.cosLift);
  }
  return q;
}

Vec3 elbowAngles(const TauConfiguration& configuration) noexcept {
  Vec3 elbow;
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    elbow[i] = std::atan2(c.sinElbow, c.cosLink2 * c.cosLift + c.sinLink2 * c.sinLift);
  }
  return elbow;
}

Status inverseKinematics(const TauModel& model, const Pose& pose, Vec6& q) noexcept {
  TauConfiguration configuration;
  const Status status = inverseKinematics(model, pose, configuration);
  if (status == Status::ok) q = jointAngles(configuration);
  return status;
}

// ---- velocities ------------------------------------------------------------------------------------------------

namespace {

// The rows that map the tip's velocity to q'.
struct RateRows {
  Vec3 yaw, lift;
};

RateRows rateRows(const ChainModel& chain, const ChainConfiguration& c) noexcept {
  const double inverseRadius = 1.0 / c.radius;
  return {{c.cosYaw * inverseRadius, 0.0, -c.sinYaw * inverseRadius},
          link2Direction(c) * (1.0 / (chain.length1 * c.sinElbow))};
}

}  // namespace

Vec3 kneePoint(const ChainModel& chain, const ChainConfiguration& configuration) noexcept {
  return chain.base + chain.length1 * elevated(configuration, configuration.cosLift, configuration.sinLift);
}

Mat6 inverseJacobian(const TauModel& model, const TauConfiguration& configuration) noexcept {
  Mat6 inverse;
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    const RateRows rows = rateRows(model.chain[i], c);
    inverse.row(2 * i) << rows.yaw.transpose(), c.arm.cross(rows.yaw).transpose();
    inverse.row(2 * i + 1) << rows.lift.transpose(), c.arm.cross(rows.lift).transpose();
  }
  return inverse;
}

Vec6 jointRates(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept {
  Vec6 rates;
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    const RateRows rows = rateRows(model.chain[i], c);
    const Vec3 velocity = twist.head<3>() + twist.tail<3>().cross(c.arm);
    rates[2 * i] = rows.yaw.dot(velocity);
    rates[2 * i + 1] = rows.lift.dot(velocity);
  }
  return rates;
}

Vec6 wrenchFromTorques(const TauModel& model, const TauConfiguration& configuration, const Vec6& torque) noexcept {
  Vec6 wrench = Vec6::Zero();
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    const RateRows rows = rateRows(model.chain[i], c);
    const Vec3 force = torque[2 * i] * rows.yaw + torque[2 * i + 1] * rows.lift;
    wrench.head<3>() += force;
    wrench.tail<3>() += c.arm.cross(force);
  }
  return wrench;
}

namespace {

// The map from rates to the twist, prepared once per configuration. First the tips' velocities at free elevations, then
// the rates of the elevations from the loop equations, then the rigid motion of the three tips. A Pair holds a number
// for the yaw joint and one for the lift joint of a chain, so both rates are mapped at once.
class TwistMap {
 public:
  using Pair = Eigen::Array<double, 2, 1>;

  TwistMap(const TauModel& model, const TauConfiguration& configuration) noexcept
      : slopes_(slopesOf(model, configuration)), sides_(sidesOf(configuration)), arm0_(configuration.chain[0].arm) {
    const LoopMatrix matrix = loopMatrix(sides_, slopes_);
    const double determinant = matrix.determinant(), inverse = determinant != 0.0 ? -1.0 / determinant : 0.0;
    rates_ = inverse * matrix.adjugate();
    d1_ = -sides_[0];
    d2_ = sides_[2];
    normal_ = d1_.cross(d2_);
    const double scale = 1.0 / normal_.squaredNorm();
    n_ = scale * normal_;                                  // n / |n|^2
    inPlane_ = n_.cross(d1_) * (1.0 / d1_.squaredNorm());  // (n x d1) / (|n|^2 |d1|^2)
    for (int i = 0; i < 3; ++i) slopeAlongN_[i] = n_.dot(slopes_[i]);
    slopeInPlane_ = Vec3(inPlane_.dot(slopes_[0]), inPlane_.dot(slopes_[1]), 0.0);
  }

  /// Set the columns of chain i: the twists for the two velocities of its tip at fixed elevations. The yaw velocity has
  /// no y. The other tips move only with their elevations.
  template <int i>
  void setColumns(const Vec3& yaw, const Vec3& lift, Mat6& jacobian) const noexcept {
    const Pair x(yaw.x(), lift.x()), y = Pair(0.0, 1.0) * lift.y(), z(yaw.z(), lift.z());
    const auto along = [&](const Vec3& v) -> Pair { return v.x() * x + v.y() * y + v.z() * z; };
    constexpr int before = (i + 2) % 3;
    const Pair drift = along(sides_[i]), driftBefore = along(sides_[before]);
    Pair rate[3];  // of the elevations
    for (int j = 0; j < 3; ++j) rate[j] = rates_(j, i) * drift - rates_(j, before) * driftBefore;
    // e1 and e2 are the velocities of tips 1 and 2 relative to tip 0.
    //
    // Solve w x d1 = e1 and w x d2 = e2 in the basis d1, d2 and their normal N, with n = N / |N|^2:
    //
    //   w = (n.e2) d1 - (n.e1) d2 + ((n x d1).e1 / |d1|^2) N.
    Pair n1 = slopeAlongN_[1] * rate[1] - slopeAlongN_[0] * rate[0];
    Pair n2 = slopeAlongN_[2] * rate[2] - slopeAlongN_[0] * rate[0];
    Pair p1 = slopeInPlane_[1] * rate[1] - slopeInPlane_[0] * rate[0];
    const Pair own = along(n_);
    if (i == 0) n1 -= own, n2 -= own, p1 -= along(inPlane_);
    if (i == 1) n1 += own, p1 += along(inPlane_);
    if (i == 2) n2 += own;
    Pair w[3], v[3];
    for (int k = 0; k < 3; ++k) w[k] = n2 * d1_[k] - n1 * d2_[k] + p1 * normal_[k];
    for (int k = 0; k < 3; ++k) v[k] = rate[0] * slopes_[0][k];
    if (i == 0) v[0] += x, v[1] += y, v[2] += z;
    v[0] += w[2] * arm0_[1] - w[1] * arm0_[2];  // - w x arm
    v[1] += w[0] * arm0_[2] - w[2] * arm0_[0];
    v[2] += w[1] * arm0_[0] - w[0] * arm0_[1];
    for (int column = 0; column < 2; ++column)
      for (int k = 0; k < 3; ++k) {
        jacobian(k, 2 * i + column) = v[k][column];
        jacobian(3 + k, 2 * i + column) = w[k][column];
      }
  }

 private:
  std::array<Vec3, 3> slopes_, sides_;
  Mat3 rates_;  // of the elevations from the drifts
  Vec3 arm0_, d1_, d2_, normal_, n_, inPlane_, slopeAlongN_, slopeInPlane_;
};

// Velocity of a tip per unit yaw rate and per unit lift rate, at a fixed elevation of link 2.
Vec3 tipPerYaw(const ChainConfiguration& c) noexcept { return {c.radius * c.cosYaw, 0.0, -c.radius * c.sinYaw}; }

Vec3 tipPerLift(const ChainModel& chain, const ChainConfiguration& c) noexcept {
  return chain.length1 * elevated(c, -c.sinLift, c.cosLift);
}

}  // namespace

Vec6 twistFromRates(const TauModel& model, const TauConfiguration& configuration, const Vec6& rates) noexcept {
  return jacobian(model, configuration) * rates;
}

Mat6 jacobian(const TauModel& model, const TauConfiguration& configuration) noexcept {
  const TwistMap map(model, configuration);
  const auto& c = configuration.chain;
  Mat6 j;
  map.setColumns<0>(tipPerYaw(c[0]), tipPerLift(model.chain[0], c[0]), j);
  map.setColumns<1>(tipPerYaw(c[1]), tipPerLift(model.chain[1], c[1]), j);
  map.setColumns<2>(tipPerYaw(c[2]), tipPerLift(model.chain[2], c[2]), j);
  return j;
}

// ---- singularities ---------------------------------------------------------------------------------------------

double loopMeasure(const TauModel& model, const TauConfiguration& configuration) noexcept {
  return loopMatrix(sidesOf(configuration), slopesOf(model, configuration)).determinant() / loopScale(model);
}

SingularityMeasures singularity(const TauModel& model, const TauConfiguration& configuration) noexcept {
  SingularityMeasures measures{1.0, 1.0, std::abs(loopMeasure(model, configuration))};
  for (int i = 0; i < 3; ++i) {
    const ChainModel& chain = model.chain[i];
    const ChainConfiguration& c = configuration.chain[i];
    measures.elbow = std::min(measures.elbow, std::abs(c.sinElbow));
    measures.yaw = std::min(measures.yaw, c.radius / (chain.length1 + chain.length2));
  }
  return measures;
}

double inverseCondition(const Mat6& jacobian, double length) noexcept {
  ENAMEL_ASSERT(length > 0.0);
  Mat6 scaled = jacobian;
  scaled.topRows<3>() /= length;
  const Eigen::JacobiSVD<Mat6> svd(scaled);
  return svd.singularValues()[0] > 0.0 ? svd.singularValues()[5] / svd.singularValues()[0] : 0.0;
}

}  // namespace enamel
