#include "enamel/collision/shapes.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

ShapePoint aroundPoint(const Vec3& centre, double radius, const Vec3& p, const Vec3& fallback) {
  const Vec3 outwards = p - centre;
  const double length = outwards.norm();
  ShapePoint result;
  result.normal = length > 0.0 ? Vec3(outwards / length) : fallback;
  result.point = centre + radius * result.normal;
  result.distance = length - radius;
  return result;
}

// Feature of a box: a vector that leaves it has components along the axes of the sides from which it starts.
void setFeature(const Vec3& outwards, ShapePoint& result) {
  int sides = 0;
  result.featureIndex = 0;
  for (int k = 2; k >= 0; --k) {
    const int side = static_cast<int>(outwards[k] > 0.0) - static_cast<int>(outwards[k] < 0.0);
    result.featureIndex = 3 * result.featureIndex + 1 + side;
    sides += side * side;
  }
  result.feature = sides == 1 ? Feature::face : sides == 2 ? Feature::edge : Feature::vertex;
}

}  // namespace

ShapePoint signedDistance(const HalfSpace&, const Vec3& p) noexcept {
  ShapePoint result;
  result.point = {p.x(), p.y(), 0.0};
  result.distance = p.z();
  return result;
}

ShapePoint signedDistance(const Box& shape, const Vec3& p) noexcept {
  const Vec3 nearest = p.cwiseMax(-shape.half).cwiseMin(shape.half);
  const Vec3 outwards = p - nearest;
  const double distance = outwards.norm();
  ShapePoint result;
  if (distance > 0.0) {
    result.point = nearest;
    result.normal = outwards / distance;
    result.distance = distance;
    setFeature(outwards, result);
    return result;
  }
  int axis = 0;
  const double depth = (shape.half - p.cwiseAbs()).minCoeff(&axis);
  const double side = p[axis] < 0.0 ? -1.0 : 1.0;
  result.normal = side * Vec3::Unit(axis);
  result.point = p;
  result.point[axis] = side * shape.half[axis];
  result.distance = -depth;
  setFeature(result.normal, result);
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
