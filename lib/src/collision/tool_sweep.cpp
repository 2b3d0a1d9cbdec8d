#include "enamel/collision/tool_sweep.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "solid_query.hpp"
#include "tool_parts.hpp"

namespace enamel {
namespace {

using namespace kernel;

// Analytic shapes: the signed distance of the sphere's centre is convex in time, so Newton's steps from the left never
// pass its first root. A capsule advances until one of its ends meets the separating plane.
template <typename Analytic>
SweepHit sweepShape(const Analytic& shape, const Segment& from, const Segment& to, double radius, int, PartCache*) {
  SweepHit result;
  const Vec3 motionA = to.a - from.a, motionB = to.b - from.b;
  const bool isSphere = from.a == from.b && to.a == to.b;
  const double speed = std::max(motionA.norm(), motionB.norm());
  const double tolerance = 1e-15 * (1.0 + from.a.norm() + radius + speed);
  double time = 0.0;
  for (int step = 0; step < 256; ++step) {
    const Segment now{from.a + time * motionA, from.b + time * motionB};
    double t = isSphere ? 0.0 : nearestOnAxis(shape, now);
    if (t < 0.0) t = signedDistance(shape, now.a).distance < signedDistance(shape, now.b).distance ? 0.0 : 1.0;
    const Vec3 centre = now.a + t * (now.b - now.a);
    const ShapePoint near = signedDistance(shape, centre);
    const double gap = near.distance - radius;
    if (gap <= tolerance || step == 255) {
      result.hit = true;
      result.time = time;
      result.point = near.point;
      result.normal = near.normal;
      result.feature = near.feature;
      result.featureIndex = near.featureIndex;
      return result;
    }
    const auto waitOf = [&](const Vec3& end,
                            const Vec3& motion) {  // until the end meets the plane over the nearest point
      const double closing = -near.normal.dot(motion);
      return closing > 0.0 ? std::max(near.normal.dot(end - near.point) - radius, gap) / closing : kNoLimit;
    };
    time += std::min(waitOf(now.a, motionA), waitOf(now.b, motionB));
    if (!(time <= 1.0)) return result;
  }
  return result;
}

// Advance by the present distance: no point of the axis can cover it sooner.
SweepHit sweepShape(const Solid& solid, const Segment& from, const Segment& to, double radius, int advances,
                    PartCache*) {
  const int most = std::min(advances, 64);
  SweepHit result;
  const Vec3 motionA = to.a - from.a, motionB = to.b - from.b;
  const double path = std::max(motionA.norm(), motionB.norm()), tolerance = 1e-3 * solid.cell();
  double time = 0.0;
  SolidCache cache;
  for (int step = 0; step < most; ++step) {
    const Segment now{from.a + time * motionA, from.b + time * motionB};
    const double left = (1.0 - time) * path;
    const SolidPoint near = kernel::closestToSegment(solid, now, radius + left + tolerance, cache);
    if (!near.found) return result;
    const Vec3 centre = now.a + near.parameter * (now.b - now.a);
    const double gap = (isInside(solid, centre) ? -near.distance : near.distance) - radius;
    if (gap <= tolerance || step + 1 == most) {
      result.hit = true;
      result.time = time;
      result.point = near.point;
      result.normal = near.normal;
      return result;
    }
    if (gap > left) return result;
    time += gap / path;
  }
  return result;
}

SweepHit sweepShape(const MeshModel& mesh, const Segment& from, const Segment& to, double radius, int advances,
                    PartCache* cache) {
  if (from.a == from.b && to.a == to.b) return sweepSphere(Inside::of(mesh), from.a, to.a, radius, pointOf(cache, 0));
  return sweepCapsule(mesh, from, to, radius, advances);
}

}  // namespace

SweepHit kernel::sweepPart(const Obstacle& obstacle, const Segment& from, const Segment& to, double radius,
                           int advances, PartCache* cache) noexcept {
  return onShape(obstacle, [&](const auto& shape) { return sweepShape(shape, from, to, radius, advances, cache); });
}

ToolSweep sweepTool(const Scene& scene, const Tool& tool, const Pose& from, const Pose& to, ToolCache* cache) noexcept {
  ToolSweep result;
  result.status = checkPlace(from);
  if (result.status == Status::ok) result.status = checkPlace(to);
  if (result.status == Status::ok) result.status = checkTool(tool);
  if (result.status != Status::ok) return result;
  const std::vector<Obstacle>& obstacles = scene.obstacles();
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const Obstacle& obstacle = obstacles[i];
    if (!isFinite(obstacle.pose)) {
      result = ToolSweep();
      result.status = Status::notFinite;
      return result;
    }
    const double pad = 0.5 * obstacle.thickness;
    for (int k = 0; k < tool.count; ++k) {
      const ToolPart& part = tool.parts[k];
      const Segment first = axisOf(part, from, obstacle), last = axisOf(part, to, obstacle);
      PartCache* known = PartCache::of(cache, i, k);
      const SweepHit hit = kernel::sweepPart(obstacle, first, last, part.radius + pad, kMostAdvances, known);
      if (!hit.hit || (result.hit && !(hit.time < result.time))) continue;
      result.hit = true;
      result.time = hit.time;
      Contact& contact = result.contact;
      contact.normal = obstacle.pose.rotation * hit.normal;
      contact.point = obstacle.pose.rotation * hit.point + obstacle.pose.position + pad * contact.normal;
      contact.gap = 0.0;
      complete({&obstacle, static_cast<int>(i), k}, hit, contact);
    }
  }
  return result;
}

}  // namespace enamel
