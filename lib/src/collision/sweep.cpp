#include "enamel/collision/sweep.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "normals.hpp"

namespace enamel {
namespace {

using namespace kernel;

#include "exact.inl"

constexpr int kMostNewtonSteps = 64;
constexpr int kPlainAdvances = 16;
constexpr double kMostWindows = 1024.0;  // on a path as long as the mesh
constexpr double kFirstWindow = 0x1p-6;  // share of a whole window
constexpr int kPickPieces = 32;
constexpr int kMostBounds = 8;
constexpr double kFarSizes = 8.0;

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

struct Nearest {
  Vec3 point;
  double distance;
  int triangle;
  Feature feature;
  int featureIndex;
};

Nearest nearestOn(const Triangle& triangle, const Vec3& p) {
  Candidate c;
  closestOnTriangle(&triangle, p.data(), &c);
  Nearest here;
  here.point = vec(c.point);
  here.distance = std::sqrt(c.squared);
  here.triangle = triangle.index;
  setFeature(c.feature, here);
  return here;
}

struct SphereSweep {
  const MeshData* data;
  Vec3 from, motion;
  double radius, speed, tolerance;
  SweepHit best;
};

// The earlier touch wins; at the same time, the smaller triangle number.
bool isBetter(const SweepHit& best, double time, int triangle) {
  if (!best.hit || time < best.time) return true;
  return time == best.time && triangle < best.triangle;
}

template <typename Near>
void setTouch(double time, const Near& near, const Vec3& normal, SweepHit& hit) {
  hit.hit = true;
  hit.time = time;
  hit.point = near.point;
  hit.normal = normal;
  hit.triangle = near.triangle;
  hit.feature = near.feature;
  hit.featureIndex = near.featureIndex;
}

// Direction from the touched point to the tool; if they coincide, the triangle's normal against the motion.
Vec3 touchNormal(const MeshData& data, const Vec3& apart, double distance, int triangle, const Vec3& motion) {
  if (distance > 1e-9 * data.size) return apart / distance;
  const Triangle& t = data.triangles[data.slotOf[triangle]];
  const Vec3 n = unitNormal(vec(t.corner[0]), vec(t.corner[1]), vec(t.corner[2]));
  if (!n.isZero(0.0)) return n.dot(motion) > 0.0 ? Vec3(-n) : n;
  const double length = motion.norm();
  return length > 0.0 ? Vec3(-motion / length) : Vec3(Vec3::UnitZ());
}

double sweepTriangle(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<SphereSweep*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  const double latest = s.best.hit ? s.best.time : 1.0;
  double time = 0.0;
  for (int step = 0; step < kMostNewtonSteps; ++step) {
    const Vec3 p = s.from + time * s.motion;
    const Nearest near = nearestOn(triangle, p);
    const double gap = near.distance - s.radius;
    const Vec3 apart = p - near.point;
    const double closing = near.distance > 0.0 ? -apart.dot(s.motion) / near.distance : s.speed;
    const bool touches = gap <= s.tolerance;
    if (!touches) {
      if (!(closing > 0.0)) return reach;  // convex: the gap only grows from here
      const double next = time + gap / closing;
      if (!(next <= latest)) return reach;
      if (next > time + 1e-15 && step + 1 < kMostNewtonSteps) {
        time = next;
        continue;
      }
    }
    if (isBetter(s.best, time, triangle.index))
      setTouch(time, near, touchNormal(*s.data, apart, near.distance, triangle.index, s.motion), s.best);
    return reach;
  }
  return reach;
}

Axis axisOf(const Segment& segment) { return axisBetween(segment.a.data(), segment.b.data()); }

double footOn(const Axis& axis, const Vec3& p) {
  return within01((p - vec(axis.a)).dot(vec(axis.span)) * axis.perSquared);
}

SegmentPoint nearestOn(const Triangle& triangle, const Segment& segment) {
  const Axis axis = axisOf(segment);
  SegmentCandidate c;
  closestToAxis(&triangle, &axis, &c);
  SegmentPoint here;
  here.triangle = triangle.index;
  here.point = vec(c.point);
  here.parameter = c.parameter;
  here.distance = std::sqrt(c.squared);
  setFeature(c.feature, here);
  return here;
}

struct CapsuleSweep {
  const MeshData* data;
  Segment from;
  Vec3 motionA, motionB;
  double radius, speed, tolerance;
  double start, end;  // times of the searched window
  int advances;       // a triangle that takes more counts as touched
  SweepHit best;

  Segment at(double time) const { return {from.a + time * motionA, from.b + time * motionB}; }
};

// Least time until a piece of the axis touches the triangle. The plane across their shortest line separates them. The
// triangle rests and the ends move straight. So the first touch cannot come before an end has covered its height over
// that plane.
double waitOfPiece(const CapsuleSweep& s, const Segment& piece, const SegmentPoint& near, double first, double last) {
  const auto on = [](const Vec3& a, const Vec3& b, double t) { return Vec3(a + t * (b - a)); };
  const double gap = near.distance - s.radius;
  if (!(gap > 0.0) || !(near.distance > 1e-9 * s.data->size)) return gap > 0.0 ? gap / s.speed : 0.0;
  const Vec3 normal = (on(piece.a, piece.b, near.parameter) - near.point) / near.distance;
  const auto waitOf = [&](const Vec3& end, const Vec3& motion) {
    const double closing = -normal.dot(motion);
    return closing > 0.0 ? std::max(normal.dot(end - near.point) - s.radius, gap) / closing : kNoLimit;
  };
  return std::min(waitOf(piece.a, on(s.motionA, s.motionB, first)), waitOf(piece.b, on(s.motionA, s.motionB, last)));
}

// If far ends of a rotating axis limit the steps, the nearest place gets a short piece of its own. The other pieces
// grow with their distance from it.
double waitOfAxis(const CapsuleSweep& s, const Triangle& triangle, double time, double nearest) {
  double wait = kNoLimit, inner = 0x1p-26;
  const Segment axis = s.at(time);
  const auto consider = [&](double first, double last) {
    first = std::max(first, 0.0);
    last = std::min(last, 1.0);
    if (!(first < last)) return;
    const Segment piece{axis.a + first * (axis.b - axis.a), axis.a + last * (axis.b - axis.a)};
    wait = std::min(wait, waitOfPiece(s, piece, nearestOn(triangle, piece), first, last));
  };
  consider(nearest - inner, nearest + inner);
  for (; inner < 1.0; inner *= 4.0) {
    consider(nearest - 4.0 * inner, nearest - inner);
    consider(nearest + inner, nearest + 4.0 * inner);
  }
  return wait;
}

double sweepTriangleByCapsule(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<CapsuleSweep*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  const double latest = s.best.hit ? s.best.time : s.end;
  double time = s.start;
  for (int step = 0; step < s.advances; ++step) {
    const Segment now = s.at(time);
    const SegmentPoint near = nearestOn(triangle, now);
    if (near.distance - s.radius > s.tolerance) {
      const double wait =
          step < kPlainAdvances ? waitOfPiece(s, now, near, 0.0, 1.0) : waitOfAxis(s, triangle, time, near.parameter);
      if (!(time + wait <= latest)) return reach;
      if (wait > 1e-15 && step + 1 < s.advances) {
        time += wait;
        continue;
      }
    }
    if (isBetter(s.best, time, triangle.index)) {
      const Vec3 apart = now.a + near.parameter * (now.b - now.a) - near.point;
      setTouch(time, near, touchNormal(*s.data, apart, near.distance, triangle.index, s.motionA + s.motionB), s.best);
    }
    return std::min(reach, s.radius + s.speed * (s.best.time - s.start) + s.tolerance);
  }
  return reach;
}

struct PickSearch {
  const MeshData* data;
  Vec3 span;
  Axis axis;
  SweepHit best;
};

double pickTriangle(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<PickSearch*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  SegmentCandidate c;
  if (crossesAxis(&triangle, &s.axis, &c) == 0 || !isBetter(s.best, c.parameter, triangle.index)) return reach;
  s.best.hit = true;
  s.best.time = c.parameter;
  s.best.point = vec(c.point);
  s.best.triangle = triangle.index;
  setFeature(c.feature, s.best);
  const Vec3 n = unitNormal(vec(triangle.corner[0]), vec(triangle.corner[1]), vec(triangle.corner[2]));
  s.best.normal = n.dot(s.span) > 0.0 ? Vec3(-n) : n;
  return reach;
}

}  // namespace

SweepHit kernel::sweepSphere(const MeshData& data, const Vec3& from, const Vec3& to, double radius,
                             Cache* cache) noexcept {
  SphereSweep s{&data, from, to - from, radius, (to - from).norm(), 0.0, {}};
  if (!from.allFinite() || !to.allFinite() || !(radius >= 0.0) || !std::isfinite(radius)) {
    s.best.status = radius < 0.0 ? Status::outOfRange : Status::notFinite;
    return s.best;
  }
  s.tolerance = 1e-15 * (s.data->size + radius + s.speed);
  const SurfacePoint start = closestPoint(data, from, cache, kNoLimit);
  if (start.triangle < 0 || start.distance > radius + s.speed) return s.best;
  if (start.distance <= radius) {
    setTouch(0.0, start, touchNormal(*s.data, from - start.point, start.distance, start.triangle, s.motion), s.best);
    return s.best;
  }
  // Piece by piece, each twice as long as the one before: the boxes of the first ones are small.
  for (double begin = 0.0, end = kFirstWindow; begin < 1.0; begin = end, end *= 2.0) {
    const Vec3 first = from + begin * s.motion, last = from + std::min(end, 1.0) * s.motion;
    loops().visit(s.data->view, first.data(), last.data(), radius, &sweepTriangle, &s);
    if (s.best.hit && s.best.time <= end) break;  // a large triangle near an early piece may be met later
  }
  return s.best;
}

SweepHit sweepSphere(const MeshModel& model, const Vec3& from, const Vec3& to, double radius,
                     ProximityCache* cache) noexcept {
  return kernel::sweepSphere(Inside::of(model), from, to, radius, Inside::of(cache));
}

SegmentPoint closestToSegment(const MeshModel& model, const Segment& segment, double limit, int hint,
                              double far) noexcept {
  SegmentPoint best;
  if (!segment.a.allFinite() || !segment.b.allFinite() || !(limit >= 0.0)) {
    best.status = limit < 0.0 ? Status::outOfRange : Status::notFinite;
    return best;
  }
  const MeshData& data = Inside::of(model);
  const Vec3 centre = vec(data.view.centre);
  // Far away the boxes are too inexact. Bound the distance by projecting to and fro between the segment and the mesh.
  double reach = limit;
  if (std::max((segment.a - centre).norm(), (segment.b - centre).norm()) > kFarSizes * data.size) {
    const Axis axis = axisOf(segment);
    const double rounding = 1e-14 * (data.size + segment.a.norm() + segment.b.norm());
    double t = footOn(axis, centre);
    for (int pass = 0; pass < kMostBounds; ++pass) {
      const SurfacePoint near = closestPoint(model, segment.a + t * (segment.b - segment.a), nullptr, reach);
      if (near.triangle < 0) break;
      reach = std::min(reach, near.distance * (1.0 + 1e-12) + rounding);
      t = footOn(axis, near.point);
    }
  }
  const bool isKnown = hint >= 0 && hint < static_cast<int>(data.slotOf.size()) && hasTriangle(data, hint);
  SegmentAnswer found;
  loops().closestToSegment(data.view, segment.a.data(), segment.b.data(), reach, far, isKnown ? data.slotOf[hint] : -1,
                           &found);
  best.distance = std::sqrt(found.squared);
  if (found.slot < 0) return best;
  best.triangle = data.triangles[found.slot].index;
  best.point = vec(found.point);
  best.parameter = found.parameter;
  setFeature(found.feature, best);
  return best;
}

SweepHit sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius) noexcept {
  return kernel::sweepCapsule(model, from, to, radius, kMostAdvances);
}

SweepHit kernel::sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius,
                              int advances) noexcept {
  CapsuleSweep s{&Inside::of(model), from, to.a - from.a, to.b - from.b, radius, 0.0, 0.0, 0.0, 0.0, advances, {}};
  if (!from.a.allFinite() || !from.b.allFinite() || !to.a.allFinite() || !to.b.allFinite() || !(radius >= 0.0) ||
      !std::isfinite(radius)) {
    s.best.status = radius < 0.0 ? Status::outOfRange : Status::notFinite;
    return s.best;
  }
  s.speed = std::max(s.motionA.norm(), s.motionB.norm());
  s.tolerance = 1e-15 * (s.data->size + radius + s.speed + (from.b - from.a).norm());
  const double shortest = std::max(s.speed, s.data->size) / kMostWindows;
  // Advance by the distance while it is large, then window by window. A window tests all triangles that can be reached.
  while (s.start <= 1.0) {
    const Segment now = s.at(s.start);
    const SegmentPoint near = closestToSegment(model, now, radius + s.speed * (1.0 - s.start) + s.tolerance);
    if (near.triangle < 0) return s.best;  // free to the end
    const double gap = near.distance - radius;
    if (gap <= s.tolerance) {
      const Vec3 apart = now.a + near.parameter * (now.b - now.a) - near.point;
      const Vec3 normal = touchNormal(*s.data, apart, near.distance, near.triangle, s.motionA + s.motionB);
      setTouch(s.start, near, normal, s.best);
      return s.best;
    }
    if (!(s.speed > 0.0)) return s.best;
    if (gap > shortest) {
      s.start += gap / s.speed;
      continue;
    }
    // Often the surface is met at once. A short first window then has few triangles; each further one doubles.
    for (double window = kFirstWindow * shortest; window <= shortest; window *= 2.0) {
      const Segment first = s.at(s.start);
      s.end = std::min(1.0, s.start + window / s.speed);
      const double reach = radius + s.speed * (s.end - s.start) + s.tolerance;
      loops().visitSegment(s.data->view, first.a.data(), first.b.data(), reach, &sweepTriangleByCapsule, &s);
      if (s.best.hit || s.end >= 1.0) return s.best;
      s.start = s.end;
    }
  }
  return s.best;
}

SweepHit pick(const MeshModel& model, const Segment& segment) noexcept {
  PickSearch s{&Inside::of(model), segment.b - segment.a, axisOf(segment), {}};
  if (!segment.a.allFinite() || !segment.b.allFinite()) {
    s.best.status = Status::notFinite;
    return s.best;
  }
  const double hair = 1e-12 * (s.data->size + s.span.norm());
  for (int piece = 0; piece < kPickPieces; ++piece) {  // small boxes, from the near end to the far one
    const double start = static_cast<double>(piece) / kPickPieces;
    if (s.best.hit && s.best.time < start) break;  // a large triangle near an early piece may be crossed later
    const Vec3 first = segment.a + s.span * start;
    const Vec3 last = segment.a + s.span * ((piece + 1.0) / kPickPieces);
    loops().visit(s.data->view, first.data(), last.data(), hair, &pickTriangle, &s);
  }
  return s.best;
}

}  // namespace enamel
