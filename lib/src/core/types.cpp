#include "enamel/core/types.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel {

Mat3 rotationFromEuler(const Vec3& eulerXyz) noexcept {
  const double ca = std::cos(eulerXyz.x()), sa = std::sin(eulerXyz.x());
  const double cb = std::cos(eulerXyz.y()), sb = std::sin(eulerXyz.y());
  const double cg = std::cos(eulerXyz.z()), sg = std::sin(eulerXyz.z());
  Mat3 rotation;
  rotation << cg * cb, cg * sb * sa - sg * ca, cg * sb * ca + sg * sa,  //
      sg * cb, sg * sb * sa + cg * ca, sg * sb * ca - cg * sa,          //
      -sb, cb * sa, cb * ca;
  return rotation;
}

Vec3 eulerFromRotation(const Mat3& rotation) noexcept {
  const double cosBeta = std::hypot(rotation(0, 0), rotation(1, 0));
  const double beta = std::atan2(-rotation(2, 0), cosBeta);
  if (cosBeta < 1e-12) return {0.0, beta, std::atan2(-rotation(0, 1), rotation(1, 1))};
  return {std::atan2(rotation(2, 1), rotation(2, 2)), beta, std::atan2(rotation(1, 0), rotation(0, 0))};
}

bool isRotation(const Mat3& r) noexcept {
  const auto isUnit = [&r](int i) { return std::abs(r.row(i).squaredNorm() - 1.0) <= 1e-6; };
  const auto areAcross = [&r](int i, int j) { return std::abs(r.row(i).dot(r.row(j))) <= 1e-6; };
  return isUnit(0) && isUnit(1) && isUnit(2) && areAcross(0, 1) && areAcross(1, 2) && areAcross(2, 0) &&
         r.row(0).cross(r.row(1)).dot(r.row(2)) > 0.0;
}

double angleBetween(const Mat3& a, const Mat3& b) noexcept {
  const Mat3 r = a.transpose() * b;
  const double sine = 0.5 * Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)).norm();
  return std::atan2(sine, 0.5 * (r.trace() - 1.0));
}

Mat3 rotationFromVector(const Vec3& vector) noexcept {
  const double angle = vector.norm();
  if (angle == 0.0) return Mat3::Identity();
  return Eigen::AngleAxis<double>(angle, vector / angle).toRotationMatrix();
}

Vec3 rotationVector(const Mat3& r) noexcept {
  const Vec3 axis(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double sine = 0.5 * axis.norm();
  if (sine < 1e-9) return 0.5 * axis;
  return axis * (0.5 * std::atan2(sine, 0.5 * (r.trace() - 1.0)) / sine);
}

}  // namespace enamel
