// Analytic shapes: a wall is a plane, not a mesh. Each shape is in its own frame, m.
#pragma once

#include "enamel/collision/feature.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// The half space below the plane z = 0, with outward normal +z.
struct HalfSpace {};

/// A solid box about the origin.
struct Box {
  Vec3 half = Vec3::Ones();  ///< half edge lengths, m, positive
};

/// A solid ball about the origin.
struct Sphere {
  double radius = 1.0;  ///< m
};

/// All points within `radius` of the segment between (0, 0, -halfLength) and (0, 0, halfLength).
struct Capsule {
  double radius = 1.0;      ///< m
  double halfLength = 1.0;  ///< m
};

/// Nearest surface point of a shape.
struct ShapePoint {
  Vec3 point = Vec3::Zero();    ///< on the surface, m
  Vec3 normal = Vec3::UnitZ();  ///< outward unit normal at the point
  double distance = 0.0;        ///< signed, m; negative inside; p = point + distance * normal
  Feature feature = Feature::face;
  int featureIndex = -1;  ///< see Feature
};

/// Return the nearest surface point and the signed distance of p, exact everywhere. If several surface points are
/// equally near (centre of a box or sphere), the result is always the same one. The distance is a convex function of p.
/// Realtime: yes.
ShapePoint signedDistance(const HalfSpace& shape, const Vec3& p) noexcept;
ShapePoint signedDistance(const Box& shape, const Vec3& p) noexcept;
ShapePoint signedDistance(const Sphere& shape, const Vec3& p) noexcept;
ShapePoint signedDistance(const Capsule& shape, const Vec3& p) noexcept;

}  // namespace enamel
