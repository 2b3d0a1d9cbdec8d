#include "enamel/collision/shapes.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

ShapePoint aroundPoint(const Vec3& centre, double radius, const Vec3& p, const Vec3& fallback) {
  const Vec3 way = p - centre;
  const double length = way.norm();
  ShapePoint result;
  result.normal = length > 0.0 ? Vec3(way / length) : fallback;
  result.point = centre + radius * result.normal;
  result.distance = length - radius;
  return result;
}

}  // namespace

ShapePoint signedDistance(const HalfSpace&, const Vec3& p) noexcept {
  return {{p.x(), p.y(), 0.0}, Vec3::UnitZ(), p.z()};
}

ShapePoint signedDistance(const Box& shape, const Vec3& p) noexcept {
  const Vec3 nearest = p.cwiseMax(-shape.half).cwiseMin(shape.half);
  const Vec3 way = p - nearest;
  const double distance = way.norm();
  if (distance > 0.0) return {nearest, way / distance, distance};
  int axis = 0;
  const double depth = (shape.half - p.cwiseAbs()).minCoeff(&axis);
  ShapePoint result;
  const double side = p[axis] < 0.0 ? -1.0 : 1.0;
  result.normal = side * Vec3::Unit(axis);
  result.point = p;
  result.point[axis] = side * shape.half[axis];
  result.distance = -depth;
  return result;
}

ShapePoint signedDistance(const Sphere& shape, const Vec3& p) noexcept {
  return aroundPoint(Vec3::Zero(), shape.radius, p, Vec3::UnitZ());
}

ShapePoint signedDistance(const Capsule& shape, const Vec3& p) noexcept {
  const Vec3 centre(0.0, 0.0, std::clamp(p.z(), -shape.halfLength, shape.halfLength));
  return aroundPoint(centre, shape.radius, p, Vec3::UnitX());
}

}  // namespace enamel
