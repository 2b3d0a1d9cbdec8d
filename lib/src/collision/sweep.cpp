#include "enamel/collision/sweep.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mesh_data.hpp"

namespace enamel {
namespace {

using namespace kernel;

#include "exact.inl"

constexpr int kMostNewtonSteps = 64;
constexpr int kMostAdvances = 1024;
constexpr int kPickPieces = 32;
constexpr int kMostBounds = 8;
constexpr double kFarSizes = 8.0;

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

struct Nearest {
  Vec3 point;
  double distance;
};

Nearest nearestOn(const Triangle& triangle, const Vec3& p) {
  Candidate c;
  closestOnTriangle(&triangle, p.data(), &c);
  return {vec(c.point), std::sqrt(c.squared)};
}

struct SphereSweep {
  const MeshData* data;
  Vec3 from, way;
  double radius, speed, tolerance;
  SweepHit best;
};

// Earlier wins; at the same time the smaller triangle number.
bool isBetter(const SweepHit& best, double time, int triangle) {
  if (!best.hit || time < best.time) return true;
  return time == best.time && triangle < best.triangle;
}

// From the touched point to the tool; where they coincide, the triangle's normal against the motion.
Vec3 touchNormal(const MeshData& data, const Vec3& apart, double distance, int triangle, const Vec3& way) {
  if (distance > 1e-9 * data.size) return apart / distance;
  const Triangle& t = data.triangles[data.slotOf[triangle]];
  const Vec3 n = unitNormal(vec(t.corner[0]), vec(t.corner[1]), vec(t.corner[2]));
  if (!n.isZero(0.0)) return n.dot(way) > 0.0 ? Vec3(-n) : n;
  const double length = way.norm();
  return length > 0.0 ? Vec3(-way / length) : Vec3(Vec3::UnitZ());
}

double sweepTriangle(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<SphereSweep*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  const double latest = s.best.hit ? s.best.time : 1.0;
  double time = 0.0;
  for (int step = 0; step < kMostNewtonSteps; ++step) {
    const Vec3 p = s.from + time * s.way;
    const Nearest near = nearestOn(triangle, p);
    const double gap = near.distance - s.radius;
    const Vec3 apart = p - near.point;
    const double closing = near.distance > 0.0 ? -apart.dot(s.way) / near.distance : s.speed;
    const bool touches = gap <= s.tolerance;
    if (!touches) {
      if (!(closing > 0.0)) return reach;  // convex: it only grows from here
      const double next = time + gap / closing;
      if (!(next <= latest)) return reach;
      if (next > time + 1e-15 && step + 1 < kMostNewtonSteps) {
        time = next;
        continue;
      }
    }
    if (isBetter(s.best, time, triangle.index)) {
      s.best.hit = true;
      s.best.time = time;
      s.best.point = near.point;
      s.best.normal = touchNormal(*s.data, apart, near.distance, triangle.index, s.way);
      s.best.triangle = triangle.index;
    }
    return reach;
  }
  return reach;
}

// Nearest points of two segments: each end against the other segment, and the inner minimum where the lines are not
// parallel (Lumelsky 1985). All candidates are points of both, so the smallest distance is right to rounding.
// `best.distance` is squared here.
void trySegments(const Segment& s, const Vec3& c, const Vec3& d, SegmentPoint& best) {
  const Vec3 u = s.b - s.a, v = d - c, w = s.a - c;
  const auto consider = [&](double t, double r) {
    const Vec3 x = c + r * v;
    const double squared = (s.a + t * u - x).squaredNorm();
    if (squared < best.distance) {
      best.distance = squared;
      best.parameter = t;
      best.point = x;
    }
  };
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  const double det = uu * vv - uv * uv;
  const auto along = [](double numerator, double denominator) {
    return denominator > 0.0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
  };
  if (det > 0.0) {
    double t = std::clamp((uv * v.dot(w) - vv * u.dot(w)) / det, 0.0, 1.0);
    for (int pass = 0; pass < 3; ++pass) {  // alternate: repairs what a small determinant has lost
      const double r = along(v.dot(s.a + t * u - c), vv);
      t = along(u.dot(c + r * v - s.a), uu);
      consider(t, r);
    }
  }
  for (const double t : {0.0, 1.0}) consider(t, along(v.dot(s.a + t * u - c), vv));
  consider(along(u.dot(c - s.a), uu), 0.0);
  consider(along(u.dot(d - s.a), uu), 1.0);
}

// Parameter of the crossing of a segment and a triangle (Moeller & Trumbore 1997, borders included); -1: none.
double crossing(const Segment& s, const Triangle& triangle) {
  const Vec3 a = vec(triangle.corner[0]), e1 = vec(triangle.corner[1]) - a, e2 = vec(triangle.corner[2]) - a;
  const Vec3 way = s.b - s.a, h = way.cross(e2);
  const double det = e1.dot(h);
  if (det == 0.0 || !std::isfinite(det)) return -1.0;
  const Vec3 o = s.a - a, q = o.cross(e1);
  const double border = 1e-12 * std::abs(det), side = det > 0.0 ? 1.0 : -1.0;
  const double u = side * o.dot(h), v = side * way.dot(q);
  if (u < -border || v < -border || u + v > side * det + border) return -1.0;
  const double t = e2.dot(q) / det;
  return t >= 0.0 && t <= 1.0 ? t : -1.0;
}

struct SegmentSearch {
  const MeshData* data;
  Segment segment;
  Vec3 way;
  double length, rounding;
  SegmentPoint best;
};

// Parameter of the point of the segment nearest to p.
double footOf(const SegmentSearch& s, const Vec3& p) {
  return s.length > 0.0 ? std::clamp((p - s.segment.a).dot(s.way) / (s.length * s.length), 0.0, 1.0) : 0.0;
}

// The nearest place of the segment lies between the feet of the corners. The distance is convex along the segment, so
// it stays above its tangent in the middle there (where the nearest point is known to sqrt(2 rounding distance)).
double lowerBound(const SegmentSearch& s, const Triangle& triangle) {
  double first = 1.0, last = 0.0;
  for (const auto& corner : triangle.corner) {
    const double t = footOf(s, vec(corner));
    first = std::min(first, t);
    last = std::max(last, t);
  }
  const Vec3 middle = s.segment.a + 0.5 * (first + last) * s.way;
  const Nearest near = nearestOn(triangle, middle);
  if (!(near.distance > 64.0 * s.rounding)) return 0.0;
  const double slope = std::abs((middle - near.point).dot(s.way)) / (s.length * near.distance) +
                       2.0 * std::sqrt(s.rounding / near.distance);
  const double halfWay = s.length > 0.0 ? 0.5 * (last - first) * s.length * std::min(1.0, slope) : 0.0;
  return near.distance - halfWay - s.rounding;
}

double trySegmentTriangle(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<SegmentSearch*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  if (lowerBound(s, triangle) > reach) return reach;
  SegmentPoint here;
  here.triangle = triangle.index;
  here.distance = kNoLimit;
  const double t = crossing(s.segment, triangle);
  if (t >= 0.0) {
    here.parameter = t;
    here.point = s.segment.a + t * s.way;
    here.distance = 0.0;
  } else {
    for (const double end : {0.0, 1.0}) {
      Candidate c;
      closestOnTriangle(&triangle, (end == 0.0 ? s.segment.a : s.segment.b).data(), &c);
      if (c.squared < here.distance) {
        here.distance = c.squared;
        here.parameter = end;
        here.point = vec(c.point);
      }
    }
    for (int i = 0; i < 3; ++i)
      trySegments(s.segment, vec(triangle.corner[i]), vec(triangle.corner[(i + 1) % 3]), here);
    here.distance = std::sqrt(here.distance);
  }
  if (here.distance > reach) return reach;
  if (s.best.triangle < 0 || here.distance < s.best.distance ||
      (here.distance == s.best.distance && here.triangle < s.best.triangle))
    s.best = here;
  return std::min(reach, s.best.distance);
}

struct PickSearch {
  const MeshData* data;
  Segment segment;
  SweepHit best;
};

double pickTriangle(void* context, std::int32_t slot, double reach) {
  auto& s = *static_cast<PickSearch*>(context);
  const Triangle& triangle = s.data->triangles[slot];
  const double t = crossing(s.segment, triangle);
  if (t < 0.0 || !isBetter(s.best, t, triangle.index)) return reach;
  s.best.hit = true;
  s.best.time = t;
  s.best.point = s.segment.a + t * (s.segment.b - s.segment.a);
  s.best.triangle = triangle.index;
  const Vec3 n = unitNormal(vec(triangle.corner[0]), vec(triangle.corner[1]), vec(triangle.corner[2]));
  s.best.normal = n.dot(s.segment.b - s.segment.a) > 0.0 ? Vec3(-n) : n;
  return reach;
}

}  // namespace

SweepHit sweepSphere(const MeshModel& model, const Vec3& from, const Vec3& to, double radius,
                     ProximityCache* cache) noexcept {
  SphereSweep s{&model.data(), from, to - from, radius, (to - from).norm(), 0.0, {}};
  if (!from.allFinite() || !to.allFinite() || !(radius >= 0.0) || !std::isfinite(radius)) {
    s.best.status = Status::notFinite;
    return s.best;
  }
  s.tolerance = 1e-15 * (s.data->size + radius + s.speed);
  const SurfacePoint start = closestPoint(model, from, cache);
  if (start.triangle < 0 || start.distance > radius + s.speed) return s.best;
  if (start.distance <= radius) {
    s.best.hit = true;
    s.best.time = 0.0;
    s.best.point = start.point;
    s.best.triangle = start.triangle;
    s.best.normal = touchNormal(*s.data, from - start.point, start.distance, start.triangle, s.way);
    return s.best;
  }
  kernel::loops().visit(s.data->view, from.data(), to.data(), radius, &sweepTriangle, &s);
  return s.best;
}

SegmentPoint closestToSegment(const MeshModel& model, const Segment& segment, double limit, int hint) noexcept {
  SegmentSearch s{&model.data(), segment, segment.b - segment.a, (segment.b - segment.a).norm(), 0.0, {}};
  if (!segment.a.allFinite() || !segment.b.allFinite() || !(limit >= 0.0)) {
    s.best.status = Status::notFinite;
    return s.best;
  }
  const Vec3 centre(s.data->view.centre[0], s.data->view.centre[1], s.data->view.centre[2]);
  s.rounding = 1e-14 * (s.data->size + segment.a.norm() + segment.b.norm());
  // Far away the boxes say little: points of the segment bound the distance, to and fro between it and the mesh.
  double reach = limit;
  if (hint >= 0 && hint < static_cast<int>(s.data->slotOf.size()) && hasTriangle(*s.data, hint))
    reach = trySegmentTriangle(&s, s.data->slotOf[hint], reach);
  if (std::max((segment.a - centre).norm(), (segment.b - centre).norm()) > kFarSizes * s.data->size) {
    double t = footOf(s, centre);
    for (int pass = 0; pass < kMostBounds; ++pass) {
      const SurfacePoint near = closestPoint(model, segment.a + t * s.way, nullptr, reach);
      if (near.triangle < 0) break;
      reach = std::min(reach, near.distance * (1.0 + 1e-12) + s.rounding);
      t = footOf(s, near.point);
    }
  }
  kernel::loops().visitSegment(s.data->view, segment.a.data(), segment.b.data(), reach, &trySegmentTriangle, &s);
  return s.best;
}

SweepHit sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius) noexcept {
  SweepHit result;
  const Vec3 wayA = to.a - from.a, wayB = to.b - from.b;
  if (!from.a.allFinite() || !from.b.allFinite() || !to.a.allFinite() || !to.b.allFinite() || !(radius >= 0.0) ||
      !std::isfinite(radius)) {
    result.status = Status::notFinite;
    return result;
  }
  const double speed = std::max(wayA.norm(), wayB.norm());
  const double close = 1e-10 * std::max(speed, model.data().size);
  double time = 0.0;
  for (int step = 0; step < kMostAdvances; ++step) {
    const Segment now{from.a + time * wayA, from.b + time * wayB};
    const double reach = radius + speed * (1.0 - time);
    const SegmentPoint near = closestToSegment(model, now, reach + close);
    if (near.triangle < 0) return result;  // free to the end
    const double gap = near.distance - radius;
    if (gap <= close || step + 1 == kMostAdvances) {
      const Vec3 apart = now.a + near.parameter * (now.b - now.a) - near.point;
      result.hit = true;
      result.time = time;
      result.point = near.point;
      result.triangle = near.triangle;
      result.normal = touchNormal(model.data(), apart, near.distance, near.triangle, wayA + wayB);
      return result;
    }
    if (!(speed > 0.0)) return result;
    time += gap / speed;
    if (time > 1.0) return result;
  }
  return result;
}

SweepHit pick(const MeshModel& model, const Segment& segment) noexcept {
  PickSearch s{&model.data(), segment, {}};
  if (!segment.a.allFinite() || !segment.b.allFinite()) {
    s.best.status = Status::notFinite;
    return s.best;
  }
  const Vec3 way = segment.b - segment.a;
  const double hair = 1e-12 * (s.data->size + way.norm());
  for (int piece = 0; piece < kPickPieces && !s.best.hit; ++piece) {  // small boxes, from the near end to the far one
    const Vec3 first = segment.a + way * (static_cast<double>(piece) / kPickPieces);
    const Vec3 last = segment.a + way * ((piece + 1.0) / kPickPieces);
    kernel::loops().visit(s.data->view, first.data(), last.data(), hair, &pickTriangle, &s);
  }
  return s.best;
}

}  // namespace enamel
