// Continuous collision detection against meshes: the first touch of a moving sphere or capsule, and ray picking.
// Coordinates are those of the mesh's own frame, m.
#pragma once

#include "enamel/collision/proximity.hpp"

namespace enamel {

/// First touch of a motion from time 0 to time 1.
struct SweepHit {
  Status status = Status::ok;   ///< notFinite: an input; outOfRange: negative radius
  bool hit = false;             ///< false: no touch; time, point and normal are then undefined
  double time = 1.0;            ///< time of the first touch; 0: the tool touches from the start
  Vec3 point = Vec3::Zero();    ///< touched point of the mesh, m
  Vec3 normal = Vec3::UnitZ();  ///< unit vector from the touched point to the tool's axis
  int triangle = -1;
  Feature feature = Feature::face;  ///< feature at the point
  int featureIndex = -1;            ///< see Feature
};

/// Find the first touch of a sphere of `radius` (m) whose centre moves from `from` to `to`.
///
/// The distance from a triangle is a convex function of time. Newton's steps from the left therefore never pass its
/// first root. No touch is missed, for any wall thickness and any speed. The time is accurate to 1e-12 of the path if
/// the surface is met at an angle, and to 1e-6 if it is grazed.
///
/// `cache` may be null and does not change the result. Realtime: yes (no allocation; at most 64 steps for each triangle
/// whose box meets the box of the path).
SweepHit sweepSphere(const MeshModel& model, const Vec3& from, const Vec3& to, double radius,
                     ProximityCache* cache = nullptr) noexcept;

/// Ends of a segment, m.
struct Segment {
  Vec3 a = Vec3::Zero(), b = Vec3::Zero();
};

/// Find the first touch of a capsule of `radius` (m) whose axis ends move straight from `from` to `to`.
///
/// The axis approaches each triangle within reach in steps. A plane that separates axis and triangle limits each step
/// (conservative advancement, Mirtich 1996). No touch is missed. A triangle that is undecided after 256 steps counts as
/// touched.
///
/// The gap at the returned time is below 1e-15 of the sum of mesh, path and tool sizes, or below the rounding of their
/// coordinates. The error of the time is this gap over the closing speed. It is 1e-12 of the path if the surface is met
/// at an angle. If the surface is grazed, the gap has a double root, and an error e moves it by sqrt(e): about 1e-7 of
/// the path. Realtime: yes, as sweepSphere().
SweepHit sweepCapsule(const MeshModel& model, const Segment& from, const Segment& to, double radius) noexcept;

/// Nearest points of a mesh and a segment.
struct SegmentPoint {
  Status status = Status::ok;  ///< notFinite: an input; outOfRange: negative limit
  int triangle = -1;           ///< -1: no triangle within the limit
  Feature feature = Feature::face;
  int featureIndex = -1;      ///< see Feature
  Vec3 point = Vec3::Zero();  ///< on the mesh, m
  double parameter = 0.0;     ///< of the point a + parameter (b - a) of the segment
  double distance = 0.0;      ///< m; 0 if they cross; without a triangle, a lower bound
};

/// Return the nearest points of a mesh and a segment, in double precision. Realtime: yes, as closestPoint().
/// - `limit`, m: triangles farther away are not reported.
/// - `hint`: a triangle of an earlier tick that is probably nearest; it does not change the result.
/// - `far`, m: if no triangle is within the limit, `distance` is still a useful lower bound up to this value.
SegmentPoint closestToSegment(const MeshModel& model, const Segment& segment, double limit = kNoLimit, int hint = -1,
                              double far = 0.0) noexcept;

/// Find the first triangle that the segment from a to b crosses, borders included, from either side. `time` is the
/// parameter. `normal` is the triangle's normal, on the side of a. Realtime: yes; long segments visit many triangles.
SweepHit pick(const MeshModel& model, const Segment& segment) noexcept;

}  // namespace enamel
