// Moving tools against meshes: when does a sphere or capsule first touch, and what does a segment hit. Coordinates are
// those of the mesh's own frame, m.
#pragma once

#include "enamel/collision/proximity.hpp"

namespace enamel {

/// First touch of a motion between time 0 and time 1.
struct SweepHit {
  Status status = Status::ok;   ///< notFinite: an input is not finite; outOfRange: the radius is negative
  bool hit = false;             ///< false: free to the end; the rest is then without meaning
  double time = 1.0;            ///< of the first touch; 0 where the tool touches from the start
  Vec3 point = Vec3::Zero();    ///< of the mesh that is touched, m
  Vec3 normal = Vec3::UnitZ();  ///< unit, from the touched point to the tool's axis
  int triangle = -1;
  Feature feature = Feature::face;  ///< that the point lies on
  int featureIndex = -1;            ///< as Feature tells
};

/// Sphere of `radius` whose centre goes from `from` to `to`. The distance from a triangle is a convex function of time,
/// so that Newton's steps from the left never pass its first root: no touch is missed, however thin the wall and fast
/// the tool. The time is exact to 1e-12 of the path where the surface is met at an angle, to 1e-6 where it is grazed.
/// `cache` may be null; the answer is the same. Realtime: yes (no allocation; at most 64 steps for each triangle whose
/// box meets the box of the path).
SweepHit sweepSphere(const MeshModel& model, const Vec3& from, const Vec3& to, double radius,
                     ProximityCache* cache = nullptr) noexcept;

/// Ends of a segment.
struct Segment {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
};

/// Capsule of `radius` about a segment whose ends go straight from `from` to `to`. Each triangle within reach is
/// approached by steps that its separating plane from the segment allows (conservative advancement, Mirtich 1996), so
/// that no touch is passed. The gap at the answered time is below 1e-15 of mesh, path and tool together, or what
/// their coordinates round to. The time is then exact to that gap over the closing speed: 1e-12 of the path where the
/// surface is met at an angle; where it is grazed the gap has a double root, which any error e moves by sqrt(e), about
/// 1e-7 of the path. A triangle that is not decided after 256 steps counts as touched. Realtime: yes, as sweepSphere().
SweepHit sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius) noexcept;

/// Nearest points of a mesh and a segment.
struct SegmentPoint {
  Status status = Status::ok;  ///< notFinite: an input is not finite; outOfRange: the limit is negative
  int triangle = -1;           ///< -1: none within the limit
  Feature feature = Feature::face;
  int featureIndex = -1;      ///< as Feature tells
  Vec3 point = Vec3::Zero();  ///< on the mesh, m
  double parameter = 0.0;     ///< of the segment's point a + parameter (b - a)
  double distance = 0.0;      ///< m; 0 where they cross; where none was found, nothing is nearer
};

/// Nearest points of a mesh and a segment, double precision. `hint`: a triangle that is likely to be nearest,
/// of an earlier tick; the answer is the same. `far`, m: where nothing lies within the limit, how far away it is worth
/// to know that nothing does. Realtime: yes, as closestPoint().
SegmentPoint closestToSegment(const MeshModel& model, const Segment& segment, double limit = kNoLimit, int hint = -1,
                              double far = 0.0) noexcept;

/// First triangle that the segment from a to b crosses, borders included, from either side; `time` is the parameter,
/// `normal` the triangle's, turned against the segment. Realtime: yes; long segments visit many triangles.
SweepHit pick(const MeshModel& model, const Segment& segment) noexcept;

}  // namespace enamel
