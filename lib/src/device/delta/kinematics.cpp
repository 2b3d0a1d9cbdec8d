#include "enamel/device/delta/kinematics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

// The vector (x, y, z) of equation (1).
Vec3 deltaReach(const DeltaModel& model, int i, const Vec3& position) noexcept {
  return {model.cosPhi[i] * position.x() + model.sinPhi[i] * position.y() - model.radial,
          model.cosPhi[i] * position.y() - model.sinPhi[i] * position.x() + model.lateral,
          position.z() + model.homeDistance};
}

// Rotate a direction from the frame of a leg to W.
Vec3 deltaToWorld(const DeltaModel& model, int i, const Vec3& v) noexcept {
  return {model.cosPhi[i] * v[0] - model.sinPhi[i] * v[1], model.sinPhi[i] * v[0] + model.cosPhi[i] * v[1], v[2]};
}

// Complete a configuration from the three angles of every leg. Rejects configurations off the branch of home.
Status completeDelta(const DeltaModel& model, DeltaConfiguration& c) noexcept {
  std::array<Vec3, 3> bar;
  double smallest = 1.0;
  for (int i = 0; i < 3; ++i) {
    DeltaLeg& leg = c.leg[i];
    if (!(leg.sin2 > 0.0)) return Status::unreachable;
    leg.cosElbow = leg.cos1 * leg.cos2 + leg.sin1 * leg.sin2;
    leg.sinElbow = leg.cos1 * leg.sin2 - leg.sin1 * leg.cos2;
    bar[i] = deltaToWorld(model, i, {leg.sin3 * leg.cos2, leg.cos3, leg.sin3 * leg.sin2});
    smallest = std::min({smallest, leg.sin3, leg.sinElbow});
  }
  c.parallel = model.order * bar[0].dot(bar[1].cross(bar[2]));
  if (!(std::min(smallest, c.parallel) >= kSmallestDeltaMeasure)) return Status::singular;
  for (int i = 0; i < 3; ++i) c.leg[i].row = bar[i] / (model.a * c.leg[i].sin3 * c.leg[i].sinElbow);
  return Status::ok;
}

// Newton's method from `position`. Returns false if it does not converge.
bool findDelta(const DeltaModel& model, Vec3 position, DeltaConfiguration& c) noexcept {
  const double longestStep = 0.5 * model.b, lastStep = 1e-7 * model.b;
  for (int iteration = 0; iteration < kMaxDeltaIterations; ++iteration) {
    std::array<Vec3, 3> slope;
    Vec3 residual;
    for (int i = 0; i < 3; ++i) {
      const DeltaLeg& leg = c.leg[i];
      const Vec3 reach = deltaReach(model, i, position);
      const double x = reach[0] - model.a * leg.cos1, y = reach[1], z = reach[2] - model.a * leg.sin1;
      const double rho = std::sqrt(x * x + z * z), bent = rho - model.link;
      residual[i] = 0.5 * (bent * bent + y * y - model.b * model.b);
      const double share = bent / rho;
      slope[i] = deltaToWorld(model, i, {share * x, y, share * z});
    }
    const Vec3 normal0 = slope[1].cross(slope[2]), normal1 = slope[2].cross(slope[0]),
               normal2 = slope[0].cross(slope[1]);
    Vec3 step = (residual[0] * normal0 + residual[1] * normal1 + residual[2] * normal2) / -slope[0].dot(normal0);
    const double length = std::sqrt(step.dot(step));
    if (!std::isfinite(length)) return false;
    if (length > longestStep) step *= longestStep / length;
    position += step;
    if (length < lastStep) {  // quadratic convergence: the remaining error is (1e-7)^2 of the size
      c.position = position;
      return true;
    }
  }
  return false;
}

// Set the angles t2 and t3 of a position that Newton's method found, and check it. A leg on the inner sheet of its
// surface (t3 < 0) is not on this branch.
Status settleDelta(const DeltaModel& model, DeltaConfiguration& c) noexcept {
  for (int i = 0; i < 3; ++i) {
    DeltaLeg& leg = c.leg[i];
    const Vec3 reach = deltaReach(model, i, c.position);
    const double x = reach[0] - model.a * leg.cos1, z = reach[2] - model.a * leg.sin1;
    leg.reach = std::sqrt(x * x + z * z);
    if (!(leg.reach > model.link)) return Status::unreachable;
    leg.cos2 = x / leg.reach;
    leg.sin2 = z / leg.reach;
    leg.cos3 = reach[1] / model.b;
    leg.sin3 = (leg.reach - model.link) / model.b;
  }
  return completeDelta(model, c);
}

}  // namespace

Status inverseKinematics(const DeltaModel& model, const Vec3& position, DeltaConfiguration& configuration) noexcept {
  if (!position.allFinite()) return Status::notFinite;
  DeltaConfiguration c;
  c.position = position;
  for (int i = 0; i < 3; ++i) {
    DeltaLeg& leg = c.leg[i];
    const Vec3 reach = deltaReach(model, i, position);
    leg.cos3 = reach[1] / model.b;
    if (!(std::abs(leg.cos3) <= 1.0)) return Status::unreachable;
    leg.sin3 = std::sqrt((1.0 - leg.cos3) * (1.0 + leg.cos3));
    leg.reach = model.link + model.b * leg.sin3;
    // The triangle of base joint, elbow and platform joint in the plane of the leg.
    const double distance = std::sqrt(reach[0] * reach[0] + reach[2] * reach[2]);
    const double cosine =
        (model.a * model.a + (distance - leg.reach) * (distance + leg.reach)) / (2.0 * model.a * distance);
    if (!(std::abs(cosine) <= 1.0)) return Status::unreachable;
    const double sine = std::sqrt((1.0 - cosine) * (1.0 + cosine));
    const double towards = reach[0] / distance, up = reach[2] / distance;
    leg.cos1 = towards * cosine + up * sine;
    leg.sin1 = up * cosine - towards * sine;
    leg.cos2 = (reach[0] - model.a * leg.cos1) / leg.reach;
    leg.sin2 = (reach[2] - model.a * leg.sin1) / leg.reach;
  }
  const Status status = completeDelta(model, c);
  if (status == Status::ok) configuration = c;
  return status;
}

Status forwardKinematics(const DeltaModel& model, const Vec3& q, DeltaConfiguration& configuration) noexcept {
  if (!q.allFinite()) return Status::notFinite;
  DeltaConfiguration c;
  for (int i = 0; i < 3; ++i) {
    c.leg[i].cos1 = std::cos(q[i]);
    c.leg[i].sin1 = std::sin(q[i]);
  }
  Status status = Status::unreachable;
  if (configuration.position.allFinite() && findDelta(model, configuration.position, c)) status = settleDelta(model, c);
  if (status != Status::ok) {
    const Vec3 front(0.0, 0.0, model.a + model.link + model.b - model.homeDistance);
    status = findDelta(model, front, c) ? settleDelta(model, c) : Status::unreachable;
  }
  if (status == Status::ok) configuration = c;
  return status;
}

Vec3 jointAngles(const DeltaConfiguration& configuration) noexcept {
  Vec3 q;
  for (int i = 0; i < 3; ++i) q[i] = std::atan2(configuration.leg[i].sin1, configuration.leg[i].cos1);
  return q;
}

Mat3 jacobian(const DeltaConfiguration& configuration) noexcept {
  const Vec3 &row0 = configuration.leg[0].row, &row1 = configuration.leg[1].row, &row2 = configuration.leg[2].row;
  Mat3 j;
  j.col(0) = row1.cross(row2);
  j.col(1) = row2.cross(row0);
  j.col(2) = row0.cross(row1);
  j /= row0.dot(j.col(0));
  return j;
}

}  // namespace enamel
