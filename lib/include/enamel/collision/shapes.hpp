// Shapes that stay analytic: a wall is a plane and never a mesh. Each lies in a frame of its own, m.
#pragma once

#include "enamel/collision/feature.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// Solid below the plane z = 0; outward normal +z.
struct HalfSpace {};

/// Solid box about the origin.
struct Box {
  Vec3 half = Vec3::Ones();  ///< half edge lengths, m, positive
};

/// Solid ball about the origin.
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
  Vec3 normal = Vec3::UnitZ();  ///< outward unit normal there
  double distance = 0.0;        ///< signed, m; negative inside. p = point + distance * normal
  Feature feature = Feature::face;
  int featureIndex = -1;  ///< as Feature tells
};

/// Signed distance of p: exact everywhere; where several surface points are equally near (the middle of a box, the
/// centre of a sphere) always the same one. Each is a convex function of p. Realtime: yes.
ShapePoint signedDistance(const HalfSpace& shape, const Vec3& p) noexcept;
ShapePoint signedDistance(const Box& shape, const Vec3& p) noexcept;
ShapePoint signedDistance(const Sphere& shape, const Vec3& p) noexcept;
ShapePoint signedDistance(const Capsule& shape, const Vec3& p) noexcept;

}  // namespace enamel
