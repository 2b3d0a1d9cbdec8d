#include "normals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel::kernel {
namespace {

constexpr double kFlat = 1e-12;  // height over longest edge: a flatter triangle has no normal

}  // namespace

Vec3 unitNormal(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 ab = b - a, bc = c - b, ca = a - c;
  const double longest = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  // The product at the corner of the two shorter edges loses least.
  Vec3 n = longest == bc.squaredNorm() ? ca.cross(ab) : longest == ca.squaredNorm() ? ab.cross(bc) : bc.cross(ca);
  const double length = n.norm();
  if (!(length > kFlat * longest)) return Vec3::Zero();
  return n / length;
}

double cornerAngle(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 u = b - a, v = c - a;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

std::vector<Vec3> unitNormals(const TriangleMesh& mesh) {
  std::vector<Vec3> normal;
  normal.reserve(mesh.triangles.size());
  for (const auto& v : mesh.triangles)
    normal.push_back(unitNormal(mesh.vertices[v[0]], mesh.vertices[v[1]], mesh.vertices[v[2]]));
  return normal;
}

void markWithoutNormal(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal) {
  const TriangleMesh& mesh = data.mesh;
  data.tainted.assign(data.triangles.size(), 0);
  const auto taint = [&data](std::int32_t triangle, int feature) {
    std::uint8_t& bits = data.tainted[data.slotOf[triangle]];
    bits = static_cast<std::uint8_t>(bits | 1u << feature);
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!normal[t].isZero(0.0)) continue;
    for (const int v : mesh.triangles[t])
      for (std::int32_t c = data.firstCorner[data.place[v]]; c >= 0; c = data.nextCorner[c])
        taint(c / 3, kCorner0 + c % 3);
  }
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) {
    if (std::any_of(first, last, [&](const EdgeUse& use) { return normal[use.triangle].isZero(0.0); }))
      for (const EdgeUse* use = first; use != last; ++use) taint(use->triangle, kEdge01 + use->edge);
  });
}

Vec3 normalAround(const MeshData& data, std::int32_t triangle, std::int32_t feature) noexcept {
  const auto& all = data.mesh.triangles;
  const auto vertexOf = [&](std::int32_t t, int i) -> const Vec3& { return data.mesh.vertices[all[t][i % 3]]; };
  const auto placeOf = [&](std::int32_t t, int i) { return data.place[all[t][i % 3]]; };
  const auto normalOf = [&](std::int32_t t) { return unitNormal(vertexOf(t, 0), vertexOf(t, 1), vertexOf(t, 2)); };
  const bool isEdge = feature >= kEdge01;
  const int corner = isEdge ? feature - kEdge01 : feature, other = placeOf(triangle, corner + 1);
  if (isEdge && data.neighbour[triangle][corner] >= 0)
    return normalOf(triangle) + normalOf(data.neighbour[triangle][corner]);
  Vec3 sum = Vec3::Zero();
  for (std::int32_t c = data.firstCorner[placeOf(triangle, corner)]; c >= 0; c = data.nextCorner[c]) {
    const std::int32_t t = c / 3;
    const int i = c % 3;
    if (!isEdge) {
      sum += normalOf(t) * cornerAngle(vertexOf(t, i), vertexOf(t, i + 1), vertexOf(t, i + 2));
    } else if (placeOf(t, i + 1) == other || placeOf(t, i + 2) == other) {
      sum += normalOf(t);
    }
  }
  return sum;
}

}  // namespace enamel::kernel
