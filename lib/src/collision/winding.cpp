#include "winding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "boxes.hpp"

namespace enamel::kernel {
namespace {

// Moments of some triangles in local coordinates, with area vectors a n and centroids x. They are the sum of a n and,
// about the centre, the sum of a n (x - centre)^T, made symmetric.
struct Moment {
  Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();
  double radius = 0.0, area = 0.0;
  Mat3 spread = Mat3::Zero();

  void add(const Vec3& centreOf, const Vec3& normalOf, double areaOf) {
    const Mat3 product = normalOf * (centreOf - centre).transpose();
    normal += normalOf;
    area += areaOf;
    spread += 0.5 * (product + product.transpose());
  }
};

Moment read(const MomentRows& rows, int lane) {
  const auto at = [&](int row) { return static_cast<double>(rows.row[row][lane]); };
  Moment m;
  m.centre = {at(kCentre), at(kCentre + 1), at(kCentre + 2)};
  m.radius = at(kRadius);
  m.area = at(kArea);
  m.normal = {at(kNormal), at(kNormal + 1), at(kNormal + 2)};
  m.spread << at(kSpread), at(kSpread + 3), at(kSpread + 4), at(kSpread + 3), at(kSpread + 1), at(kSpread + 5),
      at(kSpread + 4), at(kSpread + 5), at(kSpread + 2);
  return m;
}

void write(MeshData& data, Parent at, const Moment& m) {
  const auto set = [&](int row, double value) { data.moments[at.node].row[row][at.lane] = static_cast<float>(value); };
  for (int k = 0; k < 3; ++k) {
    set(kCentre + k, m.centre[k]);
    set(kNormal + k, m.normal[k]);
    set(kSpread + k, m.spread(k, k));
  }
  set(kRadius, m.radius * (1.0 + 1e-6));
  set(kArea, m.area);
  set(kSpread + 3, m.spread(0, 1));
  set(kSpread + 4, m.spread(0, 2));
  set(kSpread + 5, m.spread(1, 2));
}

// As stored: the moments are about the rounded place.
Vec3 rounded(const Vec3& v) { return v.cast<float>().cast<double>(); }

Moment ofLeaf(const MeshData& data, std::int32_t leaf) {
  struct Part {
    Vec3 centre, normal;
    double area;
  };
  std::array<Part, kWidth> parts;
  std::array<Vec3, 3 * kWidth> corners;
  int count = 0;
  Moment m;
  double area = 0.0;
  for (std::int32_t slot = leaf * kWidth; slot < (leaf + 1) * kWidth; ++slot) {
    const Triangle& t = data.triangles[slot];
    if (t.index < 0) continue;
    Vec3* const v = &corners[3 * count];
    for (int i = 0; i < 3; ++i) v[i] = local(data.view, Vec3(t.corner[i][0], t.corner[i][1], t.corner[i][2]));
    Part& part = parts[count++];
    part.centre = (v[0] + v[1] + v[2]) / 3.0;
    part.normal = 0.5 * (v[1] - v[0]).cross(v[2] - v[0]);
    part.area = part.normal.norm();
    m.centre += part.area * part.centre;
    area += part.area;
  }
  if (count == 0) return m;
  m.centre = rounded(area > 0.0 ? Vec3(m.centre / area) : parts[0].centre);
  for (int i = 0; i < count; ++i) m.add(parts[i].centre, parts[i].normal, parts[i].area);
  for (int i = 0; i < 3 * count; ++i) m.radius = std::max(m.radius, (corners[i] - m.centre).norm());
  return m;
}

double farthestCorner(const AlignedBoxes& boxes, int lane, const Vec3& p) {
  Vec3 far;
  for (int k = 0; k < 3; ++k)
    far[k] = std::max(p[k] - static_cast<double>(boxes.low[k][lane]), static_cast<double>(boxes.high[k][lane]) - p[k]);
  return far.norm();
}

// Moment of a node whose own lanes are valid. `at` is its parent.
Moment ofNode(const MeshData& data, std::int32_t node, Parent at) {
  const unsigned lanes = data.nodes[node].lanes;
  std::array<Moment, kWidth> parts;
  int count = 0;
  Moment m;
  double area = 0.0;
  for (int lane = 0; lane < kWidth; ++lane) {
    if ((lanes >> lane & 1u) == 0) continue;
    const Moment& part = parts[count++] = read(data.moments[node], lane);
    m.centre += part.area * part.centre;
    area += part.area;
  }
  m.centre = rounded(area > 0.0 ? Vec3(m.centre / area) : parts[0].centre);
  for (int i = 0; i < count; ++i) {
    m.add(parts[i].centre, parts[i].normal, parts[i].area);
    m.spread += parts[i].spread;
    m.radius = std::max(m.radius, (parts[i].centre - m.centre).norm() + parts[i].radius);
  }
  m.radius = std::min(m.radius, farthestCorner(data.boxes[at.node], at.lane, m.centre));
  return m;
}

// The sum of the arguments of complex numbers is the argument of their product, with its turns counted.
struct SumOfArguments {
  double re = 1.0, im = 0.0;
  int turns = 0;

  void add(double u, double v) {
    const double next = re * v + im * u;
    turns +=
        static_cast<int>(im >= 0.0 && v >= 0.0 && next < 0.0) - static_cast<int>(im < 0.0 && v < 0.0 && next >= 0.0);
    re = re * u - im * v;
    im = next;
  }
  void scale() {
    const double size = std::abs(re) + std::abs(im);
    re /= size;
    im /= size;
  }
  double sum() const { return std::atan2(im, re) + 2.0 * M_PI * turns; }
};

void addTriangles(const MeshData& data, std::int32_t leaf, const Vec3& p, SumOfArguments& angles) {
  double re[kWidth], im[kWidth];
  loops().solidAngles(data.triangles.data() + leaf * kWidth, p.data(), re, im);
  for (int i = 0; i < kWidth; ++i) angles.add(re[i], im[i]);
  angles.scale();
}

}  // namespace

void buildWinding(MeshData& data) {
  data.moments.assign(data.nodes.size(), MomentRows{});
  for (auto node = static_cast<std::int32_t>(data.nodes.size()); node-- > 0;)  // children come after their parents
    for (int lane = 0; lane < kWidth; ++lane) {
      if ((data.nodes[node].lanes >> lane & 1u) == 0) continue;
      const std::int32_t child = data.nodes[node].child[lane];
      write(data, {node, lane}, child < 0 ? ofLeaf(data, ~child) : ofNode(data, child, {node, lane}));
    }
  data.staleLeaves.reserve(data.leaves.size());
  data.staleNodes.reserve(data.nodes.size());
  data.isStaleLeaf.assign(data.leaves.size(), 0);
  data.isStaleNode.assign(data.nodes.size(), 0);
}

void markStale(MeshData& data, std::int32_t leaf) noexcept {
  if (data.isStaleLeaf[leaf] != 0) return;
  data.isStaleLeaf[leaf] = 1;
  data.staleLeaves.push_back(leaf);
}

void refitWinding(MeshData& data) noexcept {
  std::vector<std::int32_t>& nodes = data.staleNodes;  // a heap: children before their parents
  const auto mark = [&](std::int32_t node) {
    if (data.isStaleNode[node] != 0) return;
    data.isStaleNode[node] = 1;
    nodes.push_back(node);
    std::push_heap(nodes.begin(), nodes.end());
  };
  for (const std::int32_t leaf : data.staleLeaves) {
    data.isStaleLeaf[leaf] = 0;
    write(data, data.leafParent[leaf], ofLeaf(data, leaf));
    mark(data.leafParent[leaf].node);
  }
  data.staleLeaves.clear();
  while (!nodes.empty()) {
    std::pop_heap(nodes.begin(), nodes.end());
    const std::int32_t node = nodes.back();
    nodes.pop_back();
    data.isStaleNode[node] = 0;
    const Parent above = data.nodeParent[node];
    if (above.node < 0) continue;
    write(data, above, ofNode(data, node, above));
    mark(above.node);
  }
}

double windingNumber(const MeshData& data, const Vec3& p, double accept) noexcept {
  std::array<std::int32_t, kStackSize> stack;
  const Vec3 q = local(data.view, p);
  double far = 0.0;
  SumOfArguments near;  // half the solid angles
  int top = 0;
  stack[top++] = data.view.root;
  while (top > 0) {
    const std::int32_t current = stack[--top];
    if (current < 0) {
      addTriangles(data, ~current, p, near);
      continue;
    }
    const Node& node = data.nodes[current];
    float angles[kWidth];
    const unsigned isFar =
        loops().clusterAngles(data.moments[current], q.data(), static_cast<float>(accept), angles) & node.lanes;
    for (unsigned lanes = isFar; lanes != 0; lanes &= lanes - 1)
      far += static_cast<double>(angles[__builtin_ctz(lanes)]);
    for (unsigned lanes = node.lanes & ~isFar; lanes != 0; lanes &= lanes - 1)
      stack[top++] = node.child[__builtin_ctz(lanes)];
  }
  return (far + 2.0 * near.sum()) / (4.0 * M_PI);
}

}  // namespace enamel::kernel
