#include "enamel/device/tau/dynamics.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "enamel/device/tau/kinematics.hpp"

namespace enamel {
namespace {

// Dynamics of one chain in its frame (t, u, y) with the coordinates (a, b, w). The kinetic energy has three parts: that
// of link 1, which turns about the base, of link 2, which the knee carries, and of the rotors at a and b.
class ChainDynamics {
 public:
  ChainDynamics(const TauModel& model, const ChainModel& chain, const ChainConfiguration& c) noexcept
      : model_(model), m_(chain), c_(c) {
    inverseRadius_ = 1.0 / c.radius;
    const double inverse1 = 1.0 / (chain.length1 * c.sinElbow), inverse2 = -1.0 / (chain.length2 * c.sinElbow);
    liftU_ = c.cosLink2 * inverse1;
    liftY_ = c.sinLink2 * inverse1;
    link2U_ = c.cosLift * inverse2;
    link2Y_ = c.sinLift * inverse2;
  }

  /// Rotate a vector from W to (t, u, y), and back.
  Vec3 toChain(const Vec3& v) const noexcept {
    return {c_.cosYaw * v.x() - c_.sinYaw * v.z(), c_.sinYaw * v.x() + c_.cosYaw * v.z(), v.y()};
  }
  Vec3 toWorld(const Vec3& v) const noexcept {
    return {c_.cosYaw * v[0] + c_.sinYaw * v[1], v[2], c_.cosYaw * v[1] - c_.sinYaw * v[0]};
  }

  /// Rates (a', b', w') from a tip velocity in (t, u, y).
  Vec3 rates(const Vec3& v) const noexcept {
    return {inverseRadius_ * v[0], liftU_ * v[1] + liftY_ * v[2], link2U_ * v[1] + link2Y_ * v[2]};
  }

  /// Force at the tip, in (t, u, y), from generalised forces on (a, b, w): the transpose of rates().
  Vec3 tipForce(const Vec3& n) const noexcept {
    return {inverseRadius_ * n[0], liftU_ * n[1] + link2U_ * n[2], liftY_ * n[1] + link2Y_ * n[2]};
  }

  /// The same for a force on w alone.
  Vec3 link2Force(double n) const noexcept { return {0.0, link2U_ * n, link2Y_ * n}; }

  /// Inertia at the tip in the axes (t, u, y).
  Mat3 tipInertia() const noexcept {
    const double cb = c_.cosLift, sb = c_.sinLift, cw = c_.cosLink2, sw = c_.sinLink2;
    const Mat3 &i1 = m_.inertia1, &i2 = m_.inertia2;
    const double l1 = m_.length1, knee = m_.mass2 * l1 * l1;
    const double radial = m_.moment2.z() * cw - m_.moment2.y() * sw;
    const double aa = model_.rotorInertia + (i1(1, 1) + knee) * cb * cb + 2.0 * i1(1, 2) * sb * cb +
                      i1(2, 2) * sb * sb + i2(1, 1) * cw * cw + 2.0 * i2(1, 2) * sw * cw + i2(2, 2) * sw * sw +
                      2.0 * l1 * cb * radial;
    const double ab = (l1 * m_.moment2.x() - i1(0, 2)) * sb - i1(0, 1) * cb;
    const double aw = -(i2(0, 1) * cw + i2(0, 2) * sw);
    const double bb = model_.rotorInertia + i1(0, 0) + knee;
    const double bw = l1 * (m_.moment2.z() * cosElbow() - m_.moment2.y() * c_.sinElbow);
    const double ww = i2(0, 0);

    const double pu = bb * liftU_ + bw * link2U_, py = bb * liftY_ + bw * link2Y_;
    const double ru = bw * liftU_ + ww * link2U_, ry = bw * liftY_ + ww * link2Y_;
    Mat3 w;
    w(0, 0) = aa * inverseRadius_ * inverseRadius_;
    w(0, 1) = w(1, 0) = (ab * liftU_ + aw * link2U_) * inverseRadius_;
    w(0, 2) = w(2, 0) = (ab * liftY_ + aw * link2Y_) * inverseRadius_;
    w(1, 1) = liftU_ * pu + link2U_ * ru;
    w(1, 2) = w(2, 1) = liftU_ * py + link2U_ * ry;
    w(2, 2) = liftY_ * py + link2Y_ * ry;
    return w;
  }

  /// Coriolis and centrifugal forces on (a, b, w), from the derivatives of the inertias by b and w.
  Vec3 coriolis(const Vec3& r) const noexcept {
    const double cb = c_.cosLift, sb = c_.sinLift, cw = c_.cosLink2, sw = c_.sinLink2;
    const Mat3 &i1 = m_.inertia1, &i2 = m_.inertia2;
    const double l1 = m_.length1;
    const double radial = m_.moment2.z() * cw - m_.moment2.y() * sw;
    const double radialByW = -m_.moment2.z() * sw - m_.moment2.y() * cw;
    const double halfAaByB =
        (i1(2, 2) - i1(1, 1) - m_.mass2 * l1 * l1) * sb * cb + i1(1, 2) * (cb * cb - sb * sb) - l1 * sb * radial;
    const double halfAaByW = (i2(2, 2) - i2(1, 1)) * sw * cw + i2(1, 2) * (cw * cw - sw * sw) + l1 * cb * radialByW;
    const double abByB = i1(0, 1) * sb + (l1 * m_.moment2.x() - i1(0, 2)) * cb;
    const double awByW = i2(0, 1) * sw - i2(0, 2) * cw;
    const double bwByW = -l1 * (m_.moment2.z() * c_.sinElbow + m_.moment2.y() * cosElbow());
    return {2.0 * r[0] * (halfAaByB * r[1] + halfAaByW * r[2]) + abByB * r[1] * r[1] + awByW * r[2] * r[2],
            bwByW * r[2] * r[2] - halfAaByB * r[0] * r[0], -bwByW * r[1] * r[1] - halfAaByW * r[0] * r[0]};
  }

  /// Generalised forces on (a, b, w) that balance gravity.
  Vec3 gravity() const noexcept {
    const double cb = c_.cosLift, sb = c_.sinLift, cw = c_.cosLink2, sw = c_.sinLink2;
    const Vec3 g = toChain(model_.gravity);
    const Vec3 &s1 = m_.moment1, &s2 = m_.moment2;
    const double along1 = s1.z() + m_.mass2 * m_.length1;
    const double lateral = s1.x() + s2.x();
    const double radial = along1 * cb - s1.y() * sb + s2.z() * cw - s2.y() * sw;
    return {lateral * g[1] - radial * g[0], g[1] * (s1.y() * cb + along1 * sb) + g[2] * (s1.y() * sb - along1 * cb),
            g[1] * (s2.y() * cw + s2.z() * sw) + g[2] * (s2.y() * sw - s2.z() * cw)};
  }

  /// Acceleration of the tip at a'' = b'' = w'' = 0, in (t, u, y).
  Vec3 tipBias(const Vec3& v, const Vec3& r) const noexcept {
    const double b2 = m_.length1 * r[1] * r[1], w2 = m_.length2 * r[2] * r[2];
    return {2.0 * v[1] * r[0], -c_.cosLift * b2 - c_.cosLink2 * w2 - c_.radius * r[0] * r[0],
            -c_.sinLift * b2 - c_.sinLink2 * w2};
  }

  /// tipInertia() in the axes of W.
  Mat3 inertiaInWorld(const Mat3& w) const noexcept {
    const double c = c_.cosYaw, s = c_.sinYaw;
    Mat3 result;
    result(0, 0) = c * c * w(0, 0) + 2.0 * c * s * w(0, 1) + s * s * w(1, 1);
    result(2, 2) = s * s * w(0, 0) - 2.0 * c * s * w(0, 1) + c * c * w(1, 1);
    result(0, 2) = result(2, 0) = c * s * (w(1, 1) - w(0, 0)) + (c * c - s * s) * w(0, 1);
    result(0, 1) = result(1, 0) = c * w(0, 2) + s * w(1, 2);
    result(1, 2) = result(2, 1) = c * w(1, 2) - s * w(0, 2);
    result(1, 1) = w(2, 2);
    return result;
  }

 private:
  double cosElbow() const noexcept { return c_.cosLink2 * c_.cosLift + c_.sinLink2 * c_.sinLift; }

  const TauModel& model_;
  const ChainModel& m_;
  const ChainConfiguration& c_;
  double inverseRadius_, liftU_, liftY_, link2U_, link2Y_;  // the rows of rates()
};

// Inertia of the platform at the TCP in the axes of W.
struct PlatformInertia {
  double mass;
  Vec3 moment;
  Mat3 inertia;
};

PlatformInertia platformInertia(const TauModel& model, const Mat3& rotation) noexcept {
  const Mat3 half = rotation.lazyProduct(model.platformInertia);
  return {model.platformMass, rotation * model.platformMoment, half.lazyProduct(rotation.transpose())};
}

// Lambda = sum over the tips of [1, -[arm]x]^T W [1, -[arm]x], plus the platform.
void setPlatform(const PlatformInertia& p, Mat6& lambda) noexcept {
  lambda.topLeftCorner<3, 3>() = p.mass * Mat3::Identity();
  lambda.bottomLeftCorner<3, 3>() = crossMatrix(p.moment);
  lambda.bottomRightCorner<3, 3>() = p.inertia;
}

// Adds only the lower triangle, and the whole lower left block.
void addTip(const Mat3& w, const Vec3& arm, Mat6& lambda) noexcept {
  Mat3 turned;  // [arm]x W
  for (int j = 0; j < 3; ++j) turned.col(j) = arm.cross(w.col(j));
  lambda.topLeftCorner<3, 3>() += w;
  lambda.bottomLeftCorner<3, 3>() += turned;
  for (int i = 0; i < 3; ++i)
    lambda.bottomRightCorner<3, 3>().row(i) += arm.cross(turned.row(i).transpose()).transpose();  // -([arm]x W) [arm]x
}

void mirror(Mat6& m) noexcept {
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j) m(i, j) = m(j, i);
}

// One number at a time: a vector load of two would wait for both stores.
void addWrench(const Vec3& force, const Vec3& arm, Vec6& wrench) noexcept {
  const Vec3 moment = arm.cross(force);
  for (int k = 0; k < 3; ++k) {
    wrench[k] += force[k];
    wrench[3 + k] += moment[k];
  }
}

// Wrench at the TCP that balances gravity and the velocity terms. Also Lambda, with withInertia.
template <bool withGravity, bool withVelocity, bool withInertia>
void assemble(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist, const Vec6& torque,
              Vec6& wrench, Mat6& lambda) noexcept {
  const PlatformInertia platform = platformInertia(model, configuration.pose.rotation);
  const Vec3 v = twist.head<3>(), omega = twist.tail<3>();
  if (withInertia) setPlatform(platform, lambda);
  wrench.setZero();
  if (withGravity) {
    wrench.head<3>() -= platform.mass * model.gravity;
    wrench.tail<3>() -= platform.moment.cross(model.gravity);
  }
  if (withVelocity) {
    wrench.head<3>() += omega.cross(omega.cross(platform.moment));
    wrench.tail<3>() += omega.cross(platform.inertia * omega);
    wrench += model.damping.cwiseProduct(twist);
  }
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    const ChainDynamics chain(model, model.chain[i], c);
    Vec3 force = Vec3(-torque[2 * i], -torque[2 * i + 1], 0.0);
    if (withGravity) force += chain.gravity();
    Vec3 bias = Vec3::Zero();
    if (withVelocity) {
      const Vec3 spin = omega.cross(c.arm);
      const Vec3 velocity = chain.toChain(v + spin);
      const Vec3 rates = chain.rates(velocity);
      force += chain.coriolis(rates);
      force[0] += model.viscousFriction * rates[0];
      force[1] += model.viscousFriction * rates[1];
      bias = chain.toChain(omega.cross(spin)) - chain.tipBias(velocity, rates);
    }
    Vec3 tip = chain.tipForce(force);
    if (withVelocity || withInertia) {
      const Mat3 inertia = chain.tipInertia();
      if (withVelocity) tip += inertia * bias;
      if (withInertia) addTip(chain.inertiaInWorld(inertia), c.arm, lambda);
    }
    addWrench(chain.toWorld(tip), c.arm, wrench);
  }
  if (withInertia) mirror(lambda);
}

// Solve m x = b for a symmetric positive definite m by LDL^T without pivoting. Reads the lower triangle only.
Vec6 solvePositiveDefinite(const Mat6& m, const Vec6& b) noexcept {
  double l[6][6], inverse[6];
  for (int j = 0; j < 6; ++j) {
    double scaled[6];
    double d = m(j, j);
    for (int k = 0; k < j; ++k) {
      scaled[k] = l[j][k];  // L D so far
      l[j][k] *= inverse[k];
      d -= scaled[k] * l[j][k];
    }
    inverse[j] = 1.0 / d;
    for (int i = j + 1; i < 6; ++i) {
      double sum = m(i, j);
      for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      l[i][j] = sum;
    }
  }
  Vec6 x = b;
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < i; ++k) x[i] -= l[i][k] * x[k];
  for (int i = 0; i < 6; ++i) x[i] *= inverse[i];
  for (int i = 5; i >= 0; --i)
    for (int k = i + 1; k < 6; ++k) x[i] -= l[k][i] * x[k];
  return x;
}

}  // namespace

Mat6 taskInertia(const TauModel& model, const TauConfiguration& configuration) noexcept {
  Mat6 lambda;
  setPlatform(platformInertia(model, configuration.pose.rotation), lambda);
  for (int i = 0; i < 3; ++i) {
    const ChainDynamics chain(model, model.chain[i], configuration.chain[i]);
    addTip(chain.inertiaInWorld(chain.tipInertia()), configuration.chain[i].arm, lambda);
  }
  mirror(lambda);
  return lambda;
}

Mat6 massMatrix(const TauModel& model, const TauConfiguration& configuration, const Mat6& jacobian) noexcept {
  const Mat6 half = taskInertia(model, configuration).lazyProduct(jacobian);
  Mat6 m = jacobian.transpose().lazyProduct(half);
  mirror(m);
  return m;
}

Mat6 massMatrix(const TauModel& model, const TauConfiguration& configuration) noexcept {
  return massMatrix(model, configuration, jacobian(model, configuration));
}

// Forces on a and b are joint torques already. A force on w acts through the tip.
Vec6 gravityTorque(const TauModel& model, const TauConfiguration& configuration, const Mat6& jacobian) noexcept {
  const Vec3 moment = configuration.pose.rotation * model.platformMoment;
  Vec6 torque, wrench;
  wrench << -model.platformMass * model.gravity, -moment.cross(model.gravity);
  for (int i = 0; i < 3; ++i) {
    const ChainDynamics chain(model, model.chain[i], configuration.chain[i]);
    const Vec3 force = chain.gravity();
    torque[2 * i] = force[0];
    torque[2 * i + 1] = force[1];
    addWrench(chain.toWorld(chain.link2Force(force[2])), configuration.chain[i].arm, wrench);
  }
  return torque + jacobian.transpose() * wrench;
}

Vec6 gravityTorque(const TauModel& model, const TauConfiguration& configuration) noexcept {
  return gravityTorque(model, configuration, jacobian(model, configuration));
}

Vec6 staticTorque(const TauModel& model, const TauConfiguration& configuration, const Vec6& wrench) noexcept {
  const Mat6 jacobian = enamel::jacobian(model, configuration);
  return gravityTorque(model, configuration, jacobian) + jacobian.transpose() * wrench;
}

Vec6 biasTorque(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept {
  Vec6 wrench;
  Mat6 unused;
  assemble<false, true, false>(model, configuration, twist, Vec6::Zero(), wrench, unused);
  return jacobian(model, configuration).transpose() * wrench;
}

Vec6 forwardDynamics(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                     const Vec6& torque, const Vec6& wrench) noexcept {
  Vec6 opposing;
  Mat6 lambda;
  assemble<true, true, true>(model, configuration, twist, torque, opposing, lambda);
  return solvePositiveDefinite(lambda, wrench - opposing);
}

Vec6 inverseDynamics(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                     const Vec6& acceleration, const Vec6& wrench) noexcept {
  Vec6 opposing;
  Mat6 lambda;
  assemble<true, true, true>(model, configuration, twist, Vec6::Zero(), opposing, lambda);
  return jacobian(model, configuration).transpose() * (lambda * acceleration + opposing - wrench);
}

Vec6 jointAccelerations(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist,
                        const Vec6& acceleration) noexcept {
  Vec6 result;
  const Vec3 v = twist.head<3>(), omega = twist.tail<3>();
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    const ChainDynamics chain(model, model.chain[i], c);
    const Vec3 spin = omega.cross(c.arm);
    const Vec3 velocity = chain.toChain(v + spin);
    const Vec3 tip = acceleration.head<3>() + acceleration.tail<3>().cross(c.arm) + omega.cross(spin);
    const Vec3 second = chain.rates(chain.toChain(tip) - chain.tipBias(velocity, chain.rates(velocity)));
    result[2 * i] = second[0];
    result[2 * i + 1] = second[1];
  }
  return result;
}

double kineticEnergy(const TauModel& model, const TauConfiguration& configuration, const Vec6& twist) noexcept {
  return 0.5 * twist.dot(taskInertia(model, configuration) * twist);
}

double potentialEnergy(const TauModel& model, const TauConfiguration& configuration) noexcept {
  const Vec3 platform =
      model.platformMass * configuration.pose.position + configuration.pose.rotation * model.platformMoment;
  double energy = -model.gravity.dot(platform);
  for (int i = 0; i < 3; ++i) {
    const ChainModel& m = model.chain[i];
    const ChainConfiguration& c = configuration.chain[i];
    const double along1 = m.moment1.z() + m.mass2 * m.length1;
    // First moment of both links about the base, in (t, u, y).
    const Vec3 moment(
        m.moment1.x() + m.moment2.x(),
        along1 * c.cosLift - m.moment1.y() * c.sinLift + m.moment2.z() * c.cosLink2 - m.moment2.y() * c.sinLink2,
        along1 * c.sinLift + m.moment1.y() * c.cosLift + m.moment2.z() * c.sinLink2 + m.moment2.y() * c.cosLink2);
    energy -= model.gravity.dot(ChainDynamics(model, m, c).toWorld(moment));
  }
  return energy;
}

}  // namespace enamel
