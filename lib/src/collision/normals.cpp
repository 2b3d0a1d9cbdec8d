#include "normals.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel::kernel {
namespace {

constexpr double kFlat = 1e-12;  // height over longest edge of a triangle that counts as without area

}  // namespace

Vec3 unitNormal(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  const Vec3 ab = b - a, bc = c - b, ca = a - c;
  const double longest = std::max({ab.squaredNorm(), bc.squaredNorm(), ca.squaredNorm()});
  // At the corner where the two shorter edges meet, the product loses least.
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

void sumNormals(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal) {
  const TriangleMesh& mesh = data.mesh;
  data.cornerNormal.assign(data.firstCorner.size(), Vec3::Zero());
  data.edgeNormals.assign(data.triangles.size(), EdgeNormals{});
  std::vector<char> isTainted(data.firstCorner.size(), 0);  // by place
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    for (int i = 0; i < 3; ++i) {
      if (normal[t].isZero(0.0)) isTainted[data.place[v[i]]] = 1;
      data.cornerNormal[data.place[v[i]]] +=
          normal[t] * cornerAngle(mesh.vertices[v[i]], mesh.vertices[v[(i + 1) % 3]], mesh.vertices[v[(i + 2) % 3]]);
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int i = 0; i < 3; ++i)
      if (isTainted[data.place[mesh.triangles[t][i]]] != 0)
        data.edgeNormals[data.slotOf[t]].tainted |= 1u << (kCorner0 + i);
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) {
    Vec3 sum = Vec3::Zero();
    bool tainted = false;
    for (const EdgeUse* use = first; use != last; ++use) {
      sum += normal[use->triangle];
      tainted = tainted || normal[use->triangle].isZero(0.0);
    }
    for (const EdgeUse* use = first; use != last; ++use) {
      EdgeNormals& at = data.edgeNormals[data.slotOf[use->triangle]];
      for (int k = 0; k < 3; ++k) at.edge[use->edge][k] = static_cast<float>(sum[k]);
      if (tainted) at.tainted |= 1u << (kEdge01 + use->edge);
    }
  });
}

}  // namespace enamel::kernel
