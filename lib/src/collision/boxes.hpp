// Boxes of the hierarchy in local coordinates.
#pragma once

#include <vector>

#include "mesh_data.hpp"

namespace enamel::kernel {

inline constexpr float kEmptyBox = 3e38f;  ///< its square is infinite

/// Box along the axes of the mesh.
struct FloatBox {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(kEmptyBox), high = Eigen::Vector3f::Constant(-kEmptyBox);
  void add(const FloatBox& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  float halfArea() const {
    if (low.x() > high.x()) return 0.0f;
    const Eigen::Vector3f d = high - low;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
  }
};

/// Bounds of a box in double, rounded outwards once at the end.
struct Extent {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& q) {
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  FloatBox box() const;
};

/// Box along axes of its own: |axes q + offset| <= half.
struct Oriented {
  Mat3 axes = Mat3::Zero();
  Vec3 offset = Vec3::Constant(static_cast<double>(kFarAway)), half = Vec3::Zero();
  double halfArea() const { return half.x() * half.y() + half.y() * half.z() + half.z() * half.x(); }
};

/// Return the local coordinates of p.
inline Vec3 local(const Mesh& view, const Vec3& p) {
  return (p - Vec3(view.centre[0], view.centre[1], view.centre[2])) * view.scale;
}

/// Write the box of a child of a node.
void writeBox(MeshData& data, Parent at, const FloatBox& box);

/// Return the box around all children of a node.
FloatBox boxOfNode(const AlignedBoxes& boxes);

Oriented readOriented(const MeshData& data, Parent at);
void writeOriented(MeshData& data, Parent at, const Oriented& box);

/// Append the corners of these triangles in local coordinates.
void gatherCorners(const MeshData& data, const std::int32_t* triangles, int count, std::vector<Vec3>& corners);

/// Return the box of these points along these axes.
Oriented boxAlong(const Mat3& axes, const std::vector<Vec3>& points);

/// Return the box of triangles with these corners. Its axes follow the surface or the mesh, whichever box is smaller.
Oriented orientedBox(const std::vector<Vec3>& corners);

}  // namespace enamel::kernel
