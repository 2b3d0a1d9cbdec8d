#include "boxes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace enamel::kernel {
namespace {

constexpr double kMuchSmaller = 0.8;  // of the area: if smaller, the box along the mesh's axes is used, without a cone

float below(double x) { return std::nextafterf(std::nextafterf(static_cast<float>(x), -kEmptyBox), -kEmptyBox); }
float above(double x) { return std::nextafterf(std::nextafterf(static_cast<float>(x), kEmptyBox), kEmptyBox); }

// The mean normal, and the direction across it in which the corners spread most.
Mat3 axesAlong(const std::vector<Vec3>& corners, const Vec3& mean, const Vec3& normal) {
  Mat3 axes;
  axes.row(2) = normal.norm() > 0.0 ? Vec3(normal.normalized()) : Vec3(Vec3::UnitZ());
  const Vec3 n = axes.row(2);
  const Vec3 s = n.unitOrthogonal(), t = n.cross(s);
  double ss = 0.0, st = 0.0, tt = 0.0;
  for (const Vec3& c : corners) {
    const double a = s.dot(c - mean), b = t.dot(c - mean);
    ss += a * a;
    st += a * b;
    tt += b * b;
  }
  const double angle = 0.5 * std::atan2(2.0 * st, ss - tt);
  axes.row(0) = std::cos(angle) * s + std::sin(angle) * t;
  axes.row(1) = n.cross(Vec3(axes.row(0)));
  return axes;
}

}  // namespace

FloatBox Extent::box() const {
  FloatBox box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = below(low[k]);
    box.high[k] = above(high[k]);
  }
  return box;
}

void writeBox(MeshData& data, Parent at, const FloatBox& box) {
  AlignedBoxes& boxes = data.boxes[at.node];
  for (int k = 0; k < 3; ++k) {
    boxes.low[k][at.lane] = box.low[k];
    boxes.high[k][at.lane] = box.high[k];
  }
}

FloatBox boxOfNode(const AlignedBoxes& boxes) {
  FloatBox box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = *std::min_element(boxes.low[k], boxes.low[k] + kWidth);
    box.high[k] = *std::max_element(boxes.high[k], boxes.high[k] + kWidth);
  }
  return box;
}

Oriented readOriented(const MeshData& data, Parent at) {
  const Node& node = data.nodes[at.node];
  Oriented box;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) box.axes(i, k) = static_cast<double>(node.row[3 * i + k][at.lane]);
    box.offset[i] = static_cast<double>(node.row[9 + i][at.lane]);
    box.half[i] = static_cast<double>(node.row[12 + i][at.lane]);
  }
  return box;
}

void writeOriented(MeshData& data, Parent at, const Oriented& box) {
  Node& node = data.nodes[at.node];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) node.row[3 * i + k][at.lane] = static_cast<float>(box.axes(i, k));
    node.row[9 + i][at.lane] = static_cast<float>(box.offset[i]);
    node.row[12 + i][at.lane] = above(box.half[i]);
  }
}

void gatherCorners(const MeshData& data, const std::int32_t* triangles, int count, std::vector<Vec3>& corners) {
  for (int i = 0; i < count; ++i)
    for (const int v : data.mesh.triangles[triangles[i]]) corners.push_back(local(data.view, data.mesh.vertices[v]));
}

Oriented boxAlong(const Mat3& axes, const std::vector<Vec3>& corners) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& c : corners) {
    const Vec3 f = axes * c;
    low = low.cwiseMin(f);
    high = high.cwiseMax(f);
  }
  return {axes, -0.5 * (low + high), 0.5 * (high - low)};
}

Oriented orientedBox(const std::vector<Vec3>& corners) {
  if (corners.empty()) return {};
  Vec3 mean = Vec3::Zero(), normal = Vec3::Zero();
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    mean += corners[i] + corners[i + 1] + corners[i + 2];
    normal += (corners[i + 1] - corners[i]).cross(corners[i + 2] - corners[i]);
  }
  const Oriented turned = boxAlong(axesAlong(corners, mean / static_cast<double>(corners.size()), normal), corners);
  const Oriented straight = boxAlong(Mat3::Identity(), corners);
  return straight.halfArea() < kMuchSmaller * turned.halfArea() ? straight : turned;
}

}  // namespace enamel::kernel
