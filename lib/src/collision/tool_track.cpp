// The path of a tool's axis outside surfaces: a god object for the whole segment.
#include <algorithm>
#include <cmath>

#include "tool_parts.hpp"

namespace enamel::kernel {
namespace {

constexpr double kSkin = 1e-5;                          // of a mesh's size: least distance of the axis from the surface
constexpr double kAnalyticSkin = 1e-6;                  // m
constexpr double kSolidSkin = 0.2, kSolidStuck = 0.01;  // cells
constexpr double kMovesAhead = 8.0;                     // moves that one search shall cover
constexpr double kSolidReach = 2e-3;                    // m: search limit for the surface of a solid
constexpr double kShrink = 0.9;                         // of the available room: start radius of a sweep
constexpr int kMostSteps = 12, kMostSegmentSteps = 4;   // sweeps of a tick
constexpr int kAdvances = 6;  // an undecided triangle then counts as an obstacle; the next step tests it again
constexpr int kMostPlanes = 6;
constexpr int kProjections = 16;
constexpr double kSettled = 1e-10;  // m

double lengthOf(const Segment& a, const Segment& b) noexcept {
  return std::max((b.a - a.a).norm(), (b.b - a.b).norm());
}

Segment onWay(const Segment& from, const Segment& to, double time) noexcept {
  return {from.a + time * (to.a - from.a), from.b + time * (to.b - from.b)};
}

Vec3 placeOn(const Segment& axis, double t) noexcept { return axis.a + t * (axis.b - axis.a); }

double skinOf(const MeshModel& mesh) noexcept { return kSkin * Inside::of(mesh).size; }
double skinOf(const Solid& solid) noexcept { return kSolidSkin * solid.cell(); }
template <typename Analytic>
double skinOf(const Analytic&) noexcept {
  return kAnalyticSkin;
}

// An axis nearer than this has met the surface in spite of its sweeps, which are inexact for a sampled surface.
double stuckOf(const Solid& solid) noexcept { return kSolidStuck * solid.cell(); }
template <typename Analytic>
double stuckOf(const Analytic&) noexcept {
  return -1.0;
}

// Distance of an axis that crosses no surface.
double distanceOf(const MeshModel& mesh, const Segment& axis, PartCache* cache) noexcept {
  if (axis.a == axis.b) return closestPoint(Inside::of(mesh), axis.a, pointOf(cache, 0), kNoLimit).distance;
  return closestToSegment(mesh, axis, kNoLimit, cache == nullptr ? -1 : cache->nearest).distance;
}

double distanceOf(const Solid& solid, const Segment& axis, PartCache*, double reach = kSolidReach) noexcept {
  return std::min(closestToSegment(solid, axis, reach).distance, reach);
}

template <typename Analytic>
double distanceOf(const Analytic& shape, const Segment& axis, PartCache*) noexcept {
  const double ends = std::min(signedDistance(shape, axis.a).distance, signedDistance(shape, axis.b).distance);
  const double t = axis.a == axis.b ? -1.0 : kernel::nearestOnAxis(shape, axis);
  return t < 0.0 ? ends : std::min(ends, signedDistance(shape, placeOn(axis, t)).distance);
}

// Lower bound of the distance of an axis. Distant solids are not searched.
double clearOf(const Solid& solid, const Segment& axis, PartCache* cache, double move) noexcept {
  return distanceOf(solid, axis, cache, std::min(kMovesAhead * move + 1e-4, kSolidReach));
}

template <typename ShapeType>
double clearOf(const ShapeType& shape, const Segment& axis, PartCache* cache, double) noexcept {
  return distanceOf(shape, axis, cache);
}

SurfacePoint nearestOf(const MeshModel& mesh, const Vec3& p, PartCache* cache, int end, bool isSheet) noexcept {
  return signedDistance(Inside::of(mesh), p, pointOf(cache, static_cast<std::size_t>(end)), kNoLimit, isSheet);
}

SolidPoint nearestOf(const Solid& solid, const Vec3& p, PartCache*, int, bool) noexcept {
  return signedDistance(solid, p);
}

template <typename Analytic>
ShapePoint nearestOf(const Analytic& shape, const Vec3& p, PartCache*, int, bool) noexcept {
  return signedDistance(shape, p);
}

// Lower bound of the distance of the goal by what the search for contacts found in an earlier tick. Each place of that
// axis had a ball without surface around it. The axis and the goal are both in these balls, so the way is free.
double knownClearance(const MeshModel& mesh, const Segment& axis, const Segment& goal,
                      const PartCache* cache) noexcept {
  if (cache == nullptr || cache->revision != Inside::of(mesh).view.revision) return -1.0;
  return lengthOf(cache->axis, axis) < cache->clear ? cache->clear - lengthOf(cache->axis, goal) : -1.0;
}

template <typename ShapeType>
double knownClearance(const ShapeType&, const Segment&, const Segment&, const PartCache*) noexcept {
  return -1.0;
}

// Find the axis outside the surface when it is first seen. A point on the surface is placed just before it.
template <typename ShapeType>
bool findOpen(const ShapeType& shape, const Segment& goal, PartCache* cache, bool isSheet, Segment& axis) noexcept {
  const double skin = skinOf(shape);
  const auto atA = nearestOf(shape, goal.a, cache, 0, isSheet);
  axis = goal;
  if (goal.a == goal.b) {
    if (atA.distance <= skin) axis.a = axis.b = goal.a + (2.0 * skin - atA.distance) * atA.normal;
    return atA.distance > -skin;
  }
  return atA.distance > 0.0 && nearestOf(shape, goal.b, cache, 1, isSheet).distance > 0.0 &&
         distanceOf(shape, goal, cache) > skin;
}

std::uint64_t revisionOf(const MeshModel& mesh) noexcept { return Inside::of(mesh).view.revision; }
std::uint64_t revisionOf(const Solid& solid) noexcept { return solid.restorations(); }  // a cut does not close any path
template <typename Analytic>
std::uint64_t revisionOf(const Analytic&) noexcept {
  return 1;
}

// The place of the axis at `t` must stay in front of a plane.
struct Plane {
  Vec3 normal;
  double height, t;
};

// The axis nearest to `goal`, by its ends, in front of all planes (projected Gauss-Seidel).
Segment nearestInFront(const Segment& goal, const Plane* planes, int count) noexcept {
  std::array<double, kMostPlanes> push{};
  Segment axis = goal;
  bool isSettled = false;
  for (int pass = 0; pass < kProjections && !isSettled; ++pass) {
    isSettled = true;
    for (int k = 0; k < count; ++k) {
      const Plane& plane = planes[k];
      const double wa = 1.0 - plane.t, wb = plane.t;
      const double missing = (plane.height - plane.normal.dot(placeOn(axis, plane.t))) / (wa * wa + wb * wb);
      const double change = std::max(push[k] + missing, 0.0) - push[k];
      push[k] += change;
      axis.a += change * wa * plane.normal;
      axis.b += change * wb * plane.normal;
      isSettled = isSettled && change == 0.0;
    }
  }
  return axis;
}

template <typename ShapeType>
PartTrack::State followOn(const ShapeType& shape, const Obstacle& obstacle, const Segment& goal, PartCache* cache,
                          PartTrack& track) noexcept {
  using State = PartTrack::State;
  const double move = lengthOf(track.axis, goal);
  if (!track.isKnown || track.revision != revisionOf(shape) || !(move <= kLargestMove)) {
    track.isKnown = findOpen(shape, goal, cache, obstacle.thickness > 0.0, track.axis);
    track.revision = revisionOf(shape);
    track.clear = -1.0;
    return !track.isKnown ? State::unknown : track.axis.a == goal.a ? State::open : State::held;
  }
  const auto arrive = [&](double clear) {
    track.axis = goal;
    track.clear = clear;
    return State::open;
  };
  if (move < track.clear) return arrive(track.clear - move);
  if (const double clear = knownClearance(shape, track.axis, goal, cache); clear > 0.0) return arrive(clear);
  if (const double clear = clearOf(shape, goal, cache, move); move < clear) return arrive(clear);

  // Move until a triangle is in the way, then along it. If the way along it leaves a convex surface, move down again.
  const double skin = skinOf(shape);
  const bool isPoint = goal.a == goal.b && track.axis.a == track.axis.b;
  std::array<Plane, kMostPlanes> planes;
  int count = 0;
  Segment& axis = track.axis;
  Segment target = goal;
  track.clear = -1.0;
  for (int step = 0; step < (isPoint ? kMostSteps : kMostSegmentSteps); ++step) {
    const double distance = distanceOf(shape, axis, cache), radius = std::min(skin, kShrink * distance);
    if (distance < stuckOf(shape)) {
      track.isKnown = false;
      return State::unknown;
    }
    const SweepHit hit = sweepPart(obstacle, axis, target, radius, kAdvances, cache);
    if (!hit.hit) {
      if (count == 0) return arrive(-1.0);
      axis = target;
      count = 0;
      target = goal;
      continue;
    }
    axis = onWay(axis, target, hit.time);
    const Vec3 span = axis.b - axis.a;
    const double t = isPoint ? 0.0 : std::clamp((hit.point - axis.a).dot(span) / span.squaredNorm(), 0.0, 1.0);
    const Vec3 away = std::min(skin - radius, 0.5 * radius) * hit.normal;  // everything is at least `radius` away
    axis.a += away;
    axis.b += away;
    if (count == kMostPlanes) break;
    planes[count++] = {hit.normal, hit.normal.dot(placeOn(axis, t)), t};
    target = nearestInFront(goal, planes.data(), count);
    if (isPoint) target.b = target.a;
    if (lengthOf(axis, target) < kSettled) break;
  }
  return State::held;
}

}  // namespace

PartTrack::State PartTrack::follow(const Obstacle& obstacle, const Segment& goal, PartCache* cache) noexcept {
  if (std::holds_alternative<HalfSpace>(obstacle.shape)) return State::unknown;  // it has no other side
  return onShape(obstacle, [&](const auto& shape) { return followOn(shape, obstacle, goal, cache, *this); });
}

}  // namespace enamel::kernel
