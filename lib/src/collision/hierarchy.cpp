// Builds and repairs the hierarchy of a mesh: a binary tree by the surface area heuristic (Goldsmith & Salmon 1987;
// binned as by Wald 2007) whose leaves are full wherever possible, folded into nodes of up to 16 children.
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "mesh_data.hpp"

namespace enamel::kernel {
namespace {

constexpr int kBins = 16;
constexpr int kDepthOfHalving = 14;     // from here on pieces are halved, so that the depth stays bounded
constexpr float kEmptyBox = 3e38f;      // its square is infinite
constexpr double kThin = 1e-3;          // height over longest edge, below which the careful path is taken
constexpr double kEdgesOnly = 0x1p-20;  // local height below which the float bound uses the edges alone
constexpr double kMuchSmaller = 0.8;    // of the area: a box along the mesh's axes gives up the cone of normals

struct Box {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(kEmptyBox), high = Eigen::Vector3f::Constant(-kEmptyBox);
  void add(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  float halfArea() const {
    if (low.x() > high.x()) return 0.0f;
    const Eigen::Vector3f d = high - low;
    return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
  }
};

float below(double x) { return std::nextafterf(std::nextafterf(static_cast<float>(x), -kEmptyBox), -kEmptyBox); }
float above(double x) { return std::nextafterf(std::nextafterf(static_cast<float>(x), kEmptyBox), kEmptyBox); }

Vec3 local(const Mesh& view, const Vec3& p) {
  return (p - Vec3(view.centre[0], view.centre[1], view.centre[2])) * view.scale;
}

// Corners of a box in double, rounded outwards once at the end.
struct Extent {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  void add(const Vec3& q) {
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  Box box() const {
    Box box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = below(low[k]);
      box.high[k] = above(high[k]);
    }
    return box;
  }
};

Box boxOf(const MeshData& data, std::int32_t triangle) {
  Extent extent;
  for (const int v : data.mesh.triangles[triangle]) extent.add(local(data.view, data.mesh.vertices[v]));
  return extent.box();
}

void writeBox(MeshData& data, Parent at, const Box& box) {
  AlignedBoxes& boxes = data.boxes[at.node];
  for (int k = 0; k < 3; ++k) {
    boxes.low[k][at.lane] = box.low[k];
    boxes.high[k][at.lane] = box.high[k];
  }
}

Box boxOfNode(const AlignedBoxes& boxes) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.low[k] = *std::min_element(boxes.low[k], boxes.low[k] + kWidth);
    box.high[k] = *std::max_element(boxes.high[k], boxes.high[k] + kWidth);
  }
  return box;
}

// The mean normal, and the direction in which the corners spread most across it.
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

double angleBetween(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }
double angleOfCone(float cone) { return std::acos(std::sqrt(static_cast<double>(cone))); }
float coneOfCosine(double cosine) {  // a little wider
  const double least = 0.99999 * std::max(cosine, 0.0);
  return static_cast<float>(least * least);
}
float coneOfAngle(double angle) {
  const double cosine = angle + 1e-3 < 0.5 * M_PI ? std::cos(angle + 1e-3) : 0.0;
  return static_cast<float>(0.999 * cosine * cosine);
}

struct Oriented {
  Mat3 axes = Mat3::Zero();
  Vec3 offset = Vec3::Constant(static_cast<double>(kFarAway)), half = Vec3::Zero();  // |axes q + offset| <= half
  double halfArea() const { return half.x() * half.y() + half.y() * half.z() + half.z() * half.x(); }
};

Oriented boxAlong(const Mat3& axes, const std::vector<Vec3>& corners) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  for (const Vec3& c : corners) {
    const Vec3 f = axes * c;
    low = low.cwiseMin(f);
    high = high.cwiseMax(f);
  }
  return {axes, -0.5 * (low + high), 0.5 * (high - low)};
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

// The corners of these triangles, to data.scratch.
void gatherCorners(MeshData& data, const std::int32_t* triangles, int count) {
  data.scratch.clear();
  for (int i = 0; i < count; ++i)
    for (const int v : data.mesh.triangles[triangles[i]])
      data.scratch.push_back(local(data.view, data.mesh.vertices[v]));
}

// Of what was gathered. The axes follow the surface, or are those of the mesh where that is smaller.
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

int trianglesOf(const MeshData& data, std::int32_t leaf, std::array<std::int32_t, kWidth>& triangles) {
  int count = 0;
  for (std::int32_t slot = leaf * kWidth; slot < (leaf + 1) * kWidth; ++slot)
    if (data.triangles[slot].index >= 0) triangles[count++] = data.triangles[slot].index;
  return count;
}

// The cone of a leaf, about the third axis of its box, holds those of its triangles.
void writeLeafCone(MeshData& data, std::int32_t leaf, const std::vector<Vec3>& normal) {
  const Parent at = data.leafParent[leaf];
  const Vec3 axis = readOriented(data, at).axes.row(2);
  double widest = 0.0;
  const Leaf& cones = data.leaves[leaf];
  for (int lane = 0; lane < kWidth; ++lane) {
    const std::int32_t number = data.triangles[leaf * kWidth + lane].index;
    if (number < 0) continue;
    const float cone = std::min(cones.front[lane], cones.back[lane]);
    widest = std::max(widest, angleBetween(axis, normal[number]) + angleOfCone(cone));
  }
  data.nodes[at.node].cone[at.lane] = coneOfAngle(widest);
}

// That of a node holds those of its children.
void writeNodeCone(MeshData& data, std::int32_t number) {
  const Parent at = data.nodeParent[number];
  if (at.node < 0) return;
  const Node& node = data.nodes[number];
  const Vec3 axis = readOriented(data, at).axes.row(2);
  double widest = 0.0;
  for (int lane = 0; lane < kWidth; ++lane)
    if ((node.lanes >> lane & 1u) != 0)
      widest = std::max(
          widest, angleBetween(axis, readOriented(data, {number, lane}).axes.row(2)) + angleOfCone(node.cone[lane]));
  data.nodes[at.node].cone[at.lane] = coneOfAngle(widest);
}

// A binary tree over ranges of `order`.
struct Binary {
  Box box;
  int left = -1, right = -1;  // -1: a leaf
  int first = 0, count = 0;
};

class Builder {
 public:
  explicit Builder(MeshData& data) : data_(data) {
    const std::size_t count = data.mesh.triangles.size();
    boxes_.reserve(count);
    for (std::size_t t = 0; t < count; ++t) boxes_.push_back(boxOf(data, static_cast<std::int32_t>(t)));
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0);
  }

  void run() {
    const int root = split(0, static_cast<int>(order_.size()), 0);
    weighFolds();
    data_.view.root = fold(root, {});
  }

 private:
  float centre(int triangle, int axis) const {
    return 0.5f * (boxes_[triangle].low[axis] + boxes_[triangle].high[axis]);
  }

  int split(int first, int count, int depth) {
    const int self = static_cast<int>(tree_.size());
    tree_.emplace_back();
    Box box, centres;
    for (int i = first; i < first + count; ++i) {
      box.add(boxes_[order_[i]]);
      for (int k = 0; k < 3; ++k) {
        const float c = centre(order_[i], k);
        centres.low[k] = std::min(centres.low[k], c);
        centres.high[k] = std::max(centres.high[k], c);
      }
    }
    tree_[self].box = box;
    tree_[self].first = first;
    tree_[self].count = count;
    if (count <= kWidth) return self;

    int axis = 0, cut = count / 2;
    (centres.high - centres.low).maxCoeff(&axis);
    if (depth < kDepthOfHalving) chooseCut(first, count, centres, axis, cut);
    cut = (cut + kWidth / 2) / kWidth * kWidth;  // full leaves
    if (cut == 0) cut = kWidth;
    if (cut >= count) cut = (count - 1) / kWidth * kWidth;
    std::nth_element(order_.begin() + first, order_.begin() + first + cut, order_.begin() + first + count,
                     [&](int a, int b) {
                       const float ca = centre(a, axis), cb = centre(b, axis);
                       return ca != cb ? ca < cb : a < b;
                     });
    const int left = split(first, cut, depth + 1);
    const int right = split(first + cut, count - cut, depth + 1);
    tree_[self].left = left;
    tree_[self].right = right;
    return self;
  }

  // The axis and number of triangles on the left that cost least: area times number of leaves, summed.
  void chooseCut(int first, int count, const Box& centres, int& axis, int& cut) const {
    float least = kEmptyBox;
    for (int k = 0; k < 3; ++k) {
      const float extent = centres.high[k] - centres.low[k];
      if (!(extent > 0.0f)) continue;
      const float toBin = static_cast<float>(kBins) * 0.9999f / extent;
      std::array<Box, kBins> boxes;
      std::array<int, kBins> counts{};
      for (int i = first; i < first + count; ++i) {
        const int bin = static_cast<int>((centre(order_[i], k) - centres.low[k]) * toBin);
        const int safe = std::min(std::max(bin, 0), kBins - 1);
        boxes[safe].add(boxes_[order_[i]]);
        ++counts[safe];
      }
      std::array<float, kBins> rightCost{};
      Box sum;
      int number = 0;
      for (int b = kBins - 1; b > 0; --b) {
        sum.add(boxes[b]);
        number += counts[b];
        rightCost[b] = sum.halfArea() * static_cast<float>((number + kWidth - 1) / kWidth);
      }
      sum = Box();
      number = 0;
      for (int b = 0; b + 1 < kBins; ++b) {
        sum.add(boxes[b]);
        number += counts[b];
        if (number == 0 || number == count) continue;
        const float cost = sum.halfArea() * static_cast<float>((number + kWidth - 1) / kWidth) + rightCost[b + 1];
        if (cost < least) {
          least = cost;
          axis = k;
          cut = number;
        }
      }
    }
  }

  // Which parts of the binary tree become nodes: those that have the least area in all, by dynamic programming from the
  // leaves up (Ylitie, Karras & Laine 2017).
  void weighFolds() {
    areas_.resize(tree_.size());
    for (int i = static_cast<int>(tree_.size()) - 1; i >= 0; --i) {  // the parts of a part come after it
      if (tree_[i].left < 0) continue;
      const float asNode = tree_[i].box.halfArea() + areaOf(i, kWidth);
      areas_[i][0] = asNode;
      for (int places = 2; places <= kWidth; ++places) areas_[i][places - 1] = std::min(asNode, areaOf(i, places));
    }
  }

  // Of all nodes below a part that takes up to `places` of a node's children, and is none itself; areas_ knows the
  // least where it may be one.
  float areaOf(int binary, int places) const {
    const int ofLeft = placesOfLeft(binary, places);
    return areas_[tree_[binary].left][ofLeft - 1] + areas_[tree_[binary].right][places - ofLeft - 1];
  }

  int placesOfLeft(int binary, int places) const {
    const auto &left = areas_[tree_[binary].left], &right = areas_[tree_[binary].right];
    int best = 1;
    for (int ofLeft = 2; ofLeft < places; ++ofLeft)
      if (left[ofLeft - 1] + right[places - ofLeft - 1] < left[best - 1] + right[places - best - 1]) best = ofLeft;
    return best;
  }

  void collect(int binary, int places, std::array<int, kWidth>& child, int& count) const {
    const Binary& top = tree_[binary];
    if (top.left < 0 || places == 1 || areas_[binary][0] <= areaOf(binary, places)) {
      child[count++] = binary;
      return;
    }
    const int ofLeft = placesOfLeft(binary, places);
    collect(top.left, ofLeft, child, count);
    collect(top.right, places - ofLeft, child, count);
  }

  std::int32_t fold(int binary, Parent parent) {
    const Binary& top = tree_[binary];
    if (top.left < 0 && parent.node >= 0) {
      const auto leaf = static_cast<std::int32_t>(data_.leaves.size());
      data_.leaves.emplace_back();
      data_.leafParent.push_back(parent);
      data_.triangles.resize(data_.triangles.size() + kWidth);
      for (int lane = 0; lane < kWidth; ++lane) {
        const std::int32_t slot = leaf * kWidth + lane;
        if (lane < top.count) {
          writeSlot(data_, slot, order_[top.first + lane]);
        } else {
          clearSlot(data_, slot);
        }
      }
      return ~leaf;
    }
    std::array<int, kWidth> child;
    int count = 0;
    if (top.left < 0) {  // the root is a node also above a single leaf
      child[count++] = binary;
    } else {
      const int ofLeft = placesOfLeft(binary, kWidth);
      collect(top.left, ofLeft, child, count);
      collect(top.right, kWidth - ofLeft, child, count);
    }
    const auto self = static_cast<std::int32_t>(data_.nodes.size());
    data_.nodes.emplace_back();
    data_.boxes.emplace_back();
    data_.nodeParent.push_back(parent);
    for (int lane = 0; lane < kWidth; ++lane) {
      const bool used = lane < count;
      const std::int32_t number = used ? fold(child[lane], {self, lane}) : 0;
      Node& node = data_.nodes[self];
      node.child[lane] = number;
      if (used) node.lanes |= 1u << lane;
      if (used && number < 0) node.leaves |= 1u << lane;
      writeBox(data_, {self, lane}, used ? tree_[child[lane]].box : Box());
      data_.scratch.clear();
      if (used) gatherCorners(data_, &order_[tree_[child[lane]].first], tree_[child[lane]].count);
      writeOriented(data_, {self, lane}, orientedBox(data_.scratch));
    }
    return self;
  }

  MeshData& data_;
  std::vector<Box> boxes_;
  std::vector<int> order_;
  std::vector<Binary> tree_;
  std::vector<std::array<float, kWidth>> areas_;  // by part and number of places
};

}  // namespace

std::uint64_t nextRevision() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

void writeSlot(MeshData& data, std::int32_t slot, std::int32_t number) {
  Triangle& triangle = data.triangles[slot];
  Leaf& leaf = data.leaves[slot / kWidth];
  const int lane = slot % kWidth;
  const auto& t = data.mesh.triangles[number];
  std::array<Vec3, 3> v, q;
  for (int i = 0; i < 3; ++i) {
    v[i] = data.mesh.vertices[t[i]];
    q[i] = local(data.view, v[i]);
    for (int k = 0; k < 3; ++k) triangle.corner[i][k] = v[i][k];
  }
  // Frame: the longest edge from a to b, the third corner c on the side of v.
  int first = 0;
  double longest = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double length = (q[(i + 1) % 3] - q[i]).norm();
    if (length > longest) {
      longest = length;
      first = i;
    }
  }
  const Vec3 &a = q[first], &b = q[(first + 1) % 3], &c = q[(first + 2) % 3];
  Mat3 axes;
  axes.row(0) = longest > 0.0 ? Vec3((b - a) / longest) : Vec3(Vec3::UnitX());
  const Vec3 u = axes.row(0);
  const Vec3 up = (c - a) - u * u.dot(c - a);
  const double height = up.norm();
  axes.row(1) = height > 1e-10 * longest ? Vec3(up / height) : Vec3(u.unitOrthogonal());  // else only rounding
  axes.row(1) = (Vec3(axes.row(1)) - u * u.dot(Vec3(axes.row(1)))).normalized();
  axes.row(2) = u.cross(Vec3(axes.row(1)));
  const Vec3 toB = axes * (b - a), toC = axes * (c - a);
  const auto setEdge = [&](int edge, double du, double dv) {
    const double length = std::sqrt(du * du + dv * dv);
    leaf.row[kLength + edge][lane] = static_cast<float>(length);
    leaf.row[kCosine + edge - 1][lane] = static_cast<float>(length > 0.0 ? du / length : 1.0);
    leaf.row[kSine + edge - 1][lane] = static_cast<float>(length > 0.0 ? dv / length : 0.0);
  };
  leaf.row[kLength][lane] = static_cast<float>(toB.x());
  setEdge(1, toC.x() - toB.x(), toC.y());
  setEdge(2, toC.x(), toC.y());
  const Vec3 offset = axes * a;
  for (int i = 0; i < 3; ++i) {
    leaf.row[kOffset + i][lane] = static_cast<float>(-offset[i]);
    for (int k = 0; k < 3; ++k) leaf.row[kAxis + 3 * i + k][lane] = static_cast<float>(axes(i, k));
  }
  leaf.row[kInside][lane] = height > kEdgesOnly ? 0.0f : -1e30f;
  triangle.index = number;
  triangle.cone = height > kThin * longest ? 0.0f : -1.0f;
  data.slotOf[number] = slot;
}

void clearSlot(MeshData& data, std::int32_t slot) {
  Triangle& triangle = data.triangles[slot];
  Leaf& leaf = data.leaves[slot / kWidth];
  const int lane = slot % kWidth;
  triangle = Triangle{};
  triangle.index = -1;
  for (int row = 0; row < kFrameRows; ++row) leaf.row[row][lane] = unusedRow(row);
}

void refitLeaf(MeshData& data, std::int32_t leaf) {
  Parent at = data.leafParent[leaf];
  std::array<std::int32_t, kWidth> triangles{};
  gatherCorners(data, triangles.data(), trianglesOf(data, leaf, triangles));
  // The axes stay, and with them the cone; the oriented boxes above only grow.
  const Oriented oriented = boxAlong(readOriented(data, at).axes, data.scratch);
  writeOriented(data, at, oriented);
  const Vec3 middle = -(oriented.axes.transpose() * oriented.offset);
  Extent extent;
  for (const Vec3& q : data.scratch) extent.add(q);
  Box box = extent.box();
  for (;;) {
    writeBox(data, at, box);
    box = boxOfNode(data.boxes[at.node]);
    at = data.nodeParent[at.node];
    if (at.node < 0) return;
    Oriented parent = readOriented(data, at);
    const Vec3 far = (parent.axes * middle + parent.offset).cwiseAbs() +
                     (parent.axes * oriented.axes.transpose()).cwiseAbs() * oriented.half;
    if ((far.array() <= parent.half.array()).all()) continue;
    parent.half = parent.half.cwiseMax(far);
    writeOriented(data, at, parent);
  }
}

void openCones(MeshData& data, Parent at) {
  for (; at.node >= 0 && data.nodes[at.node].cone[at.lane] > 0.0f; at = data.nodeParent[at.node])
    data.nodes[at.node].cone[at.lane] = 0.0f;
}

void buildHierarchy(MeshData& data) {
  Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
  for (const auto& t : data.mesh.triangles)
    for (const int v : t) {
      low = low.cwiseMin(data.mesh.vertices[v]);
      high = high.cwiseMax(data.mesh.vertices[v]);
    }
  const Vec3 centre = 0.5 * (low + high);
  for (int k = 0; k < 3; ++k) data.view.centre[k] = centre[k];
  const double half = 0.5 * (high - low).maxCoeff();
  int exponent = 0;
  std::frexp(half, &exponent);
  data.view.scale = half > 0.0 ? std::ldexp(1.0, -exponent) : 1.0;
  data.view.extent = 1.0;
  data.view.tight = 1;
  data.size = (high - low).norm();

  data.nodes.clear();
  data.leaves.clear();
  data.boxes.clear();
  data.triangles.clear();
  data.nodeParent.clear();
  data.leafParent.clear();
  data.slotOf.assign(data.mesh.triangles.size(), -1);
  Builder(data).run();
  data.view.nodes = data.nodes.data();
  data.view.leaves = data.leaves.data();
  data.view.boxes = data.boxes.data();
  data.view.triangles = data.triangles.data();
  data.view.revision = nextRevision();
  data.scratch = std::vector<Vec3>();
  data.scratch.reserve(3 * kWidth);
  data.dirtyLeaves.reserve(data.leaves.size());
  data.isDirty.assign(data.leaves.size(), 0);
  data.isRewritten.assign(data.triangles.size(), 0);
}

namespace {

// Cosines of the widest angles between a triangle's normal and the ways from its edges and corners to the points that
// they are nearest to, in front of it and behind it.
struct Widest {
  double front = 1.0, back = 1.0;
  void add(double cosine, bool isBehind) { (isBehind ? back : front) = std::min(isBehind ? back : front, cosine); }
};

// The ways to the points that a corner is nearest to, among all that is near it: none of its edges comes nearer. They
// are a cone; `ways` are the directions at its edges, none at a saddle. False: it has too many edges.
bool findWays(const MeshData& data, int place, std::vector<Vec3>& ways) {
  constexpr std::size_t kMostEdges = 12;
  constexpr double kRounding = 1e-3;  // rad
  std::array<Vec3, kMostEdges> edge;
  std::size_t count = 0;
  for (std::int32_t c = data.firstCorner[place]; c >= 0; c = data.nextCorner[c]) {  // each leaves in one triangle
    if (count == kMostEdges) return false;
    const auto& t = data.mesh.triangles[c / 3];
    edge[count++] = (data.mesh.vertices[t[(c + 1) % 3]] - data.mesh.vertices[t[c % 3]]).normalized();
  }
  ways.clear();
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Vec3 across = edge[i].cross(edge[k]);
      const double length = across.norm();
      if (!(length > kRounding)) continue;
      for (const Vec3& way : {Vec3(across / length), Vec3(across / -length)})
        if (std::all_of(edge.begin(), edge.begin() + count, [&](const Vec3& e) { return e.dot(way) <= kRounding; }))
          ways.push_back(way);
    }
  return true;
}

// Whether one walk round a corner meets all triangles there.
bool isOneFan(const MeshData& data, int place) {
  const std::int32_t first = data.firstCorner[place];
  int count = 0, met = 0;
  for (std::int32_t c = first; c >= 0; c = data.nextCorner[c]) ++count;
  std::int32_t t = first / 3;
  do {
    int corner = 0;
    while (corner < 2 && data.place[data.mesh.triangles[t][corner]] != place) ++corner;
    t = data.neighbour[t][(corner + 2) % 3];
    ++met;
  } while (t >= 0 && t != first / 3 && met < count);
  return t == first / 3 && met == count;
}

// At a local minimum of the distance the way to the point is a sum of the normals around it, with weights that are not
// negative, and no edge there comes nearer. 0, no restriction, where the surface is open.
void writeCones(MeshData& data, const std::vector<Vec3>& normal, const std::vector<char>& isOpen) {
  const TriangleMesh& mesh = data.mesh;
  std::vector<Widest> widest(mesh.triangles.size());
  std::vector<double> around(mesh.triangles.size(), 1.0);  // of all normals
  std::vector<Vec3> ways;
  for (std::size_t place = 0; place < isOpen.size(); ++place) {
    const std::int32_t first = data.firstCorner[place];
    if (first < 0) continue;
    const bool isKnown = isOpen[place] == 0 && isOneFan(data, static_cast<int>(place));
    const bool hasWays = isKnown && findWays(data, static_cast<int>(place), ways);
    for (std::int32_t c = first; c >= 0; c = data.nextCorner[c]) {
      const std::size_t t = static_cast<std::size_t>(c / 3);
      double least = isKnown ? 1.0 : 0.0;
      for (std::int32_t other = first; other >= 0 && least > 0.0; other = data.nextCorner[other])
        least = std::min(least, normal[t].dot(normal[static_cast<std::size_t>(other / 3)]));
      around[t] = std::min(around[t], least);
      if (!hasWays) {
        widest[t].add(least, false);
        widest[t].add(least, true);
        continue;
      }
      double most = -1.0, smallest = 1.0;
      for (const Vec3& way : ways) {
        most = std::max(most, normal[t].dot(way));
        smallest = std::min(smallest, normal[t].dot(way));
      }
      if (most > 0.0) widest[t].add(std::max(smallest, least), false);
      if (smallest < 0.0) widest[t].add(std::max(-most, least), true);
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const std::int32_t other = data.neighbour[t][i];
      if (other < 0) continue;
      const Vec3 &a = mesh.vertices[mesh.triangles[t][i]], &b = mesh.vertices[mesh.triangles[t][(i + 1) % 3]];
      // Of the other triangle's third corner: where it is in front, the edge is a ridge from behind.
      double height = 0.0;
      for (const int v : mesh.triangles[other]) height += normal[t].dot(mesh.vertices[v] - a);
      const double flat = 1e-9 * (b - a).norm(), cosine = normal[t].dot(normal[other]);
      if (height <= flat) widest[t].add(cosine, false);
      if (height >= -flat) widest[t].add(cosine, true);
    }
    const std::int32_t slot = data.slotOf[t];
    Leaf& leaf = data.leaves[slot / kWidth];
    leaf.front[slot % kWidth] = coneOfCosine(widest[t].front);
    leaf.back[slot % kWidth] = coneOfCosine(widest[t].back);
    if (data.triangles[slot].cone >= 0.0f) data.triangles[slot].cone = coneOfCosine(around[t]);
  }
}

}  // namespace

void buildNormals(MeshData& data) {
  const TriangleMesh& mesh = data.mesh;
  data.place = weld(mesh);
  const std::size_t places = *std::max_element(data.place.begin(), data.place.end()) + 1u;
  data.cornerNormal.assign(places, Vec3::Zero());
  data.edgeNormals.assign(data.triangles.size(), EdgeNormals{});
  std::vector<Vec3> normal(mesh.triangles.size());
  std::vector<char> taintedPlace(places, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    normal[t] = unitNormal(mesh.vertices[v[0]], mesh.vertices[v[1]], mesh.vertices[v[2]]);
    for (int i = 0; i < 3; ++i) {
      if (normal[t].isZero(0.0)) taintedPlace[data.place[v[i]]] = 1;
      data.cornerNormal[data.place[v[i]]] +=
          normal[t] * cornerAngle(mesh.vertices[v[i]], mesh.vertices[v[(i + 1) % 3]], mesh.vertices[v[(i + 2) % 3]]);
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int i = 0; i < 3; ++i)
      if (taintedPlace[data.place[mesh.triangles[t][i]]] != 0)
        data.edgeNormals[data.slotOf[t]].tainted |= 1u << (kCorner0 + i);
  const std::vector<EdgeUse> edges = sortedEdges(mesh, data.place);
  data.firstCorner.assign(places, -1);
  data.isTainted.assign(places, 0);
  data.taintedPlaces.reserve(places);
  data.nextCorner.assign(3 * mesh.triangles.size(), -1);
  for (std::size_t corner = data.nextCorner.size(); corner-- > 0;) {
    std::int32_t& first = data.firstCorner[data.place[mesh.triangles[corner / 3][corner % 3]]];
    data.nextCorner[corner] = first;
    first = static_cast<std::int32_t>(corner);
  }
  std::vector<char> isOpen(taintedPlace);
  data.closed = !edges.empty();
  data.neighbour.assign(mesh.triangles.size(), {-1, -1, -1});
  for (std::size_t first = 0, last; first < edges.size(); first = last) {
    Vec3 sum = Vec3::Zero();
    bool tainted = false;
    int balance = 0;
    for (last = first;
         last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high; ++last) {
      sum += normal[edges[last].triangle];
      balance += edges[last].forward ? 1 : -1;
      tainted = tainted || normal[edges[last].triangle].isZero(0.0);
    }
    data.closed = data.closed && balance == 0;
    if (last - first != 2 || balance != 0) isOpen[edges[first].low] = isOpen[edges[first].high] = 1;
    if (last - first == 2) {
      const EdgeUse &a = edges[first], &b = edges[first + 1];
      data.neighbour[a.triangle][a.edge] = b.triangle;
      data.neighbour[b.triangle][b.edge] = a.triangle;
    }
    for (std::size_t i = first; i < last; ++i) {
      EdgeNormals& at = data.edgeNormals[data.slotOf[edges[i].triangle]];
      for (int k = 0; k < 3; ++k) at.edge[edges[i].edge][k] = static_cast<float>(sum[k]);
      if (tainted) at.tainted |= 1u << (kEdge01 + edges[i].edge);
    }
  }

  writeCones(data, normal, isOpen);
  for (std::size_t leaf = 0; leaf < data.leaves.size(); ++leaf)
    writeLeafCone(data, static_cast<std::int32_t>(leaf), normal);
  for (std::size_t node = data.nodes.size(); node-- > 0;) writeNodeCone(data, static_cast<std::int32_t>(node));
}

}  // namespace enamel::kernel
