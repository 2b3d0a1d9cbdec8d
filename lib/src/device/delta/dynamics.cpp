#include "enamel/device/delta/dynamics.hpp"

#include <Eigen/LU>

namespace enamel {
namespace {

// Dynamics of one leg in its coordinates (t1, t2, t3).
class LegDynamics {
 public:
  LegDynamics(const DeltaModel& model, const DeltaConfiguration& configuration, int i) noexcept
      : model_(model), c_(configuration.leg[i]), cosPhi_(model.cosPhi[i]), sinPhi_(model.sinPhi[i]) {
    const double lower = -1.0 / (c_.reach * c_.sinElbow);
    b_.row(0) = c_.row;
    b_.row(1) = toWorld({c_.cos1 * lower, c_.cos3 / c_.sin3 * c_.cosElbow * lower, c_.sin1 * lower});
    b_.row(2) = toWorld({0.0, -1.0 / (model.b * c_.sin3), 0.0});

    // Bars: the centre of mass is at a l1 + h l2 + (b cos t3 / 2) v. hSlope_ and hBend_ are h' and h'' by t3.
    h_ = model.e + 0.5 * model.b * c_.sin3;
    hSlope_ = 0.5 * model.b * c_.cos3;
    hBend_ = -0.5 * model.b * c_.sin3;
    const double m = model.barsMass, be = model.b * model.e, bb = model.b * model.b;
    carried_ = m * model.a;
    m_(0, 0) = model.upperInertia + m * model.a * model.a;
    m_(0, 1) = m_(1, 0) = carried_ * h_ * c_.cosElbow;
    m_(0, 2) = m_(2, 0) = carried_ * hSlope_ * c_.sinElbow;
    m_(1, 1) = m * (model.e * model.e + be * c_.sin3 + bb * c_.sin3 * c_.sin3 / 3.0);
    m_(1, 2) = m_(2, 1) = 0.0;
    m_(2, 2) = m * bb / 3.0;
    lowerSlope_ = m * (be + bb * c_.sin3 / 1.5) * c_.cos3;  // derivative of m_(1, 1) by t3
  }

  Vec3 toLeg(const Vec3& v) const noexcept {
    return {cosPhi_ * v.x() + sinPhi_ * v.y(), cosPhi_ * v.y() - sinPhi_ * v.x(), v.z()};
  }
  Vec3 toWorld(const Vec3& v) const noexcept {
    return {cosPhi_ * v[0] - sinPhi_ * v[1], sinPhi_ * v[0] + cosPhi_ * v[1], v[2]};
  }

  Vec3 rates(const Vec3& velocity) const noexcept { return b_.lazyProduct(velocity); }
  Vec3 force(const Vec3& generalised) const noexcept { return b_.transpose().lazyProduct(generalised); }
  Mat3 inertia() const noexcept {
    const Mat3 half = m_.lazyProduct(b_);
    return b_.transpose().lazyProduct(half);
  }

  /// Generalised forces that balance gravity.
  Vec3 gravity() const noexcept {
    const Vec3 g = toLeg(model_.gravity);
    const double across1 = c_.cos1 * g[2] - c_.sin1 * g[0];
    const double across2 = c_.cos2 * g[2] - c_.sin2 * g[0], along2 = c_.cos2 * g[0] + c_.sin2 * g[2];
    const double m = model_.barsMass;
    return {-(model_.upperMoment + carried_) * across1, -m * h_ * across2, -m * (hSlope_ * along2 + hBend_ * g[1])};
  }

  /// Generalised Coriolis and centrifugal forces.
  Vec3 coriolis(const Vec3& t) const noexcept {
    const double outwards = hBend_ * t[2] * t[2] - h_ * t[1] * t[1], across = 2.0 * hSlope_ * t[1] * t[2];
    const double first = carried_ * t[0] * t[0];
    return {carried_ * (outwards * c_.sinElbow + across * c_.cosElbow),
            first * h_ * c_.sinElbow + lowerSlope_ * t[1] * t[2],
            -first * hSlope_ * c_.cosElbow - 0.5 * lowerSlope_ * t[1] * t[1]};
  }

  /// m_t B times the acceleration of the platform joint at t'' = 0.
  Vec3 bias(const Vec3& t) const noexcept {
    const double upper = model_.a * t[0] * t[0];
    const double outwards = -model_.b * c_.sin3 * t[2] * t[2] - c_.reach * t[1] * t[1];
    const double across = 2.0 * model_.b * c_.cos3 * t[1] * t[2];
    const Vec3 acceleration(outwards * c_.cos2 - across * c_.sin2 - upper * c_.cos1, -model_.b * c_.cos3 * t[2] * t[2],
                            outwards * c_.sin2 + across * c_.cos2 - upper * c_.sin1);
    return m_.lazyProduct(rates(toWorld(acceleration)));
  }

 private:
  const DeltaModel& model_;
  const DeltaLeg& c_;
  double cosPhi_, sinPhi_;
  Mat3 b_, m_;  // t' = b_ v in the axes of W; inertia matrix of t
  double h_, hSlope_, hBend_, carried_, lowerSlope_;
};

}  // namespace

Mat3 taskInertia(const DeltaModel& model, const DeltaConfiguration& configuration) noexcept {
  Mat3 lambda = model.platformMass * Mat3::Identity();
  for (int i = 0; i < 3; ++i) lambda += LegDynamics(model, configuration, i).inertia();
  return 0.5 * (lambda + lambda.transpose());
}

Vec3 gravityForce(const DeltaModel& model, const DeltaConfiguration& configuration) noexcept {
  Vec3 force = -model.platformMass * model.gravity;
  for (int i = 0; i < 3; ++i) {
    const LegDynamics leg(model, configuration, i);
    force += leg.force(leg.gravity());
  }
  return force;
}

Vec3 forwardDynamics(const DeltaModel& model, const DeltaConfiguration& configuration, const Vec3& velocity,
                     const Vec3& torque, const Vec3& force) noexcept {
  Mat3 lambda = model.platformMass * Mat3::Identity();
  Vec3 driving = force + model.platformMass * model.gravity - model.damping.cwiseProduct(velocity);
  for (int i = 0; i < 3; ++i) {
    const LegDynamics leg(model, configuration, i);
    const Vec3 t = leg.rates(velocity);
    Vec3 generalised = leg.bias(t) - leg.gravity() - leg.coriolis(t);
    generalised[0] += torque[i] - model.friction * t[0];
    driving += leg.force(generalised);
    lambda += leg.inertia();
  }
  return lambda.inverse() * driving;
}

}  // namespace enamel
