#include "enamel/collision/guide.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/message.hpp"
#include "enamel/collision/scene.hpp"

namespace enamel {
namespace {

// Errors in the frame of the guide.
GuideError errorAt(const Polyline& line, const Vec3& p, const Vec3& velocity) noexcept {
  Vec3 from = p - line.points[0], across = velocity;  // of the nearest point; the part across the line
  double least = from.squaredNorm();
  for (std::size_t i = 1; i < line.points.size(); ++i) {
    const Vec3& a = line.points[i - 1];
    const Vec3 edge = line.points[i] - a;
    const double along = std::clamp((p - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    const Vec3 offset = p - a - along * edge;
    if (const double square = offset.squaredNorm(); square < least) {
      least = square;
      from = offset;
      across = velocity;
      if (along > 0.0 && along < 1.0) across -= velocity.dot(edge) / edge.squaredNorm() * edge;
    }
  }
  if (line.radius == 0.0) return {from, across, false};
  const double distance = std::sqrt(least);
  if (distance <= line.radius) return {Vec3::Zero(), Vec3::Zero(), true};
  // The nearest point is on the surface: it follows the part across, reduced by radius / distance.
  const double inside = line.radius / distance;
  const Vec3 outward = from / distance;
  return {(1.0 - inside) * from, (1.0 - inside) * across + inside * outward.dot(across) * outward, true};
}

GuideError errorAt(const Plane&, const Vec3& p, const Vec3& velocity) noexcept {
  return {{0.0, 0.0, p.z()}, {0.0, 0.0, velocity.z()}, false};
}

GuideError errorAt(const HalfSpace&, const Vec3& p, const Vec3& velocity) noexcept {
  if (p.z() >= 0.0) return {Vec3::Zero(), Vec3::Zero(), true};
  return {{0.0, 0.0, p.z()}, {0.0, 0.0, velocity.z()}, true};
}

GuideError errorAt(const Box& box, const Vec3& p, const Vec3& velocity) noexcept {
  const Vec3 offset = p - p.cwiseMax(-box.half).cwiseMin(box.half);
  return {offset, (offset.array() == 0.0).select(Vec3::Zero(), velocity), true};
}

}  // namespace

void checkGuide(const Guide& guide, const std::string& name) {
  const auto isWithin = [](double x, double high) { return x >= 0.0 && x <= high; };
  require(isWithin(guide.stiffness, kLargestGuideStiffness), name + ": the stiffness is " +
                                                                 formatNumber(guide.stiffness) + ", must be in 0 to " +
                                                                 formatNumber(kLargestGuideStiffness) + " N/m");
  require(isWithin(guide.maxForce, kLargestGuideForce), name + ": the largest force is " +
                                                            formatNumber(guide.maxForce) + ", must be in 0 to " +
                                                            formatNumber(kLargestGuideForce) + " N");
  const auto isNear = [](const Vec3& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() <= kFarthest; };
  require(isNear(guide.pose.position),
          name + ": the position must be within " + formatNumber(kFarthest) + " m; are its lengths in metres?");
  require(guide.pose.rotation.allFinite() && isRotation(guide.pose.rotation),
          name + ": the rotation is not a right-handed orthonormal matrix to 1e-6");
  if (const auto* box = std::get_if<Box>(&guide.shape))
    require(box->half.minCoeff() > 0.0 && isNear(box->half), name + ": the size of the box must be positive");
  const auto* const line = std::get_if<Polyline>(&guide.shape);
  if (line == nullptr) return;
  require(!line->points.empty() && line->points.size() <= kMaxGuidePoints,
          name + ": the line has " + std::to_string(line->points.size()) + " points, must have 1 to " +
              std::to_string(kMaxGuidePoints));
  require(isWithin(line->radius, kFarthest),
          name + ": the radius is " + formatNumber(line->radius) + ", must be at least 0 m and finite");
  for (std::size_t i = 0; i < line->points.size(); ++i) {
    require(isNear(line->points[i]),
            name + ": point " + std::to_string(i) + " must be within " + formatNumber(kFarthest) + " m");
    require(i == 0 || (line->points[i] - line->points[i - 1]).squaredNorm() > 0.0,
            name + ": points " + std::to_string(i - 1) + " and " + std::to_string(i) + " of the line are equal");
  }
}

GuideError errorOf(const Guide& guide, const Vec3& point, const Vec3& velocity) noexcept {
  const Mat3& R = guide.pose.rotation;
  const Vec3 p = R.transpose() * (point - guide.pose.position), v = R.transpose() * velocity;
  GuideError error;
  if (const auto* line = std::get_if<Polyline>(&guide.shape))
    error = errorAt(*line, p, v);
  else if (const auto* box = std::get_if<Box>(&guide.shape))
    error = errorAt(*box, p, v);
  else if (std::holds_alternative<HalfSpace>(guide.shape))
    error = errorAt(HalfSpace{}, p, v);
  else
    error = errorAt(Plane{}, p, v);
  error.offset = R * error.offset;
  error.rate = R * error.rate;
  return error;
}

}  // namespace enamel
