// A binary tree by the surface area heuristic (Goldsmith & Salmon 1987; binned as in Wald 2007). Its leaves are as full
// as possible. It is then folded into nodes of up to 16 children.
#include "hierarchy.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "boxes.hpp"

namespace enamel::kernel {
namespace {

constexpr int kBins = 16;
constexpr int kDepthOfHalving = 14;     // deeper pieces are halved, so that the depth stays bounded
constexpr double kThin = 1e-3;          // height over longest edge: smaller triangles need the careful path
constexpr double kEdgesOnly = 0x1p-20;  // local height: float bounds of smaller triangles use the edges alone

FloatBox boxOf(const MeshData& data, std::int32_t triangle) {
  Extent extent;
  for (const int v : data.mesh.triangles[triangle]) extent.add(local(data.view, data.mesh.vertices[v]));
  return extent.box();
}

// A binary tree over ranges of `order`.
struct Binary {
  FloatBox box;
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
    // Allocate exactly: leaves and triangles take most of the memory.
    const auto leaves = std::count_if(tree_.begin(), tree_.end(), [](const Binary& part) { return part.left < 0; });
    data_.leaves.reserve(leaves);
    data_.leafParent.reserve(leaves);
    data_.triangles.reserve(leaves * kWidth);
    data_.view.root = fold(root, {});
    data_.nodes.shrink_to_fit();
    data_.boxes.shrink_to_fit();
    data_.nodeParent.shrink_to_fit();
  }

 private:
  float centre(int triangle, int axis) const {
    return 0.5f * (boxes_[triangle].low[axis] + boxes_[triangle].high[axis]);
  }

  int split(int first, int count, int depth) {
    const int self = static_cast<int>(tree_.size());
    tree_.emplace_back();
    FloatBox box, centres;
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

  static float leavesFor(int triangles) {
    const int number = (triangles + kWidth - 1) / kWidth;
    return static_cast<float>(number);
  }

  // Choose the axis and the number of triangles on the left with the least cost: sum of area times number of leaves.
  void chooseCut(int first, int count, const FloatBox& centres, int& axis, int& cut) const {
    float least = kEmptyBox;
    for (int k = 0; k < 3; ++k) {
      const float extent = centres.high[k] - centres.low[k];
      if (!(extent > 0.0f)) continue;
      const float toBin = static_cast<float>(kBins) * 0.9999f / extent;
      std::array<FloatBox, kBins> boxes;
      std::array<int, kBins> counts{};
      for (int i = first; i < first + count; ++i) {
        const int bin = static_cast<int>((centre(order_[i], k) - centres.low[k]) * toBin);
        const int safe = std::min(std::max(bin, 0), kBins - 1);
        boxes[safe].add(boxes_[order_[i]]);
        ++counts[safe];
      }
      std::array<float, kBins> rightCost{};
      FloatBox sum;
      int number = 0;
      for (int b = kBins - 1; b > 0; --b) {
        sum.add(boxes[b]);
        number += counts[b];
        rightCost[b] = sum.halfArea() * leavesFor(number);
      }
      sum = FloatBox();
      number = 0;
      for (int b = 0; b + 1 < kBins; ++b) {
        sum.add(boxes[b]);
        number += counts[b];
        if (number == 0 || number == count) continue;
        const float cost = sum.halfArea() * leavesFor(number) + rightCost[b + 1];
        if (cost < least) {
          least = cost;
          axis = k;
          cut = number;
        }
      }
    }
  }

  // Choose the parts of the binary tree that become nodes, with the least total area. Dynamic programming from the
  // leaves up (Ylitie, Karras & Laine 2017).
  void weighFolds() {
    areas_.resize(tree_.size());
    for (int i = static_cast<int>(tree_.size()) - 1; i >= 0; --i) {  // parts come after their parent
      if (tree_[i].left < 0) continue;
      const float asNode = tree_[i].box.halfArea() + areaOf(i, kWidth);
      areas_[i][0] = asNode;
      for (int places = 2; places <= kWidth; ++places) areas_[i][places - 1] = std::min(asNode, areaOf(i, places));
    }
  }

  // Total area of all nodes below a part that takes up to `places` children of a node and is not a node itself. areas_
  // has the smaller of this and its area as a node.
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
    if (top.left < 0) {  // the root is always a node, even above a single leaf
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
      writeBox(data_, {self, lane}, used ? tree_[child[lane]].box : FloatBox());
      corners_.clear();
      if (used) gatherCorners(data_, &order_[tree_[child[lane]].first], tree_[child[lane]].count, corners_);
      writeOriented(data_, {self, lane}, orientedBox(corners_));
    }
    return self;
  }

  MeshData& data_;
  std::vector<FloatBox> boxes_;
  std::vector<int> order_;
  std::vector<Binary> tree_;
  std::vector<Vec3> corners_;                     // of the triangles of a child
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
  // Frame: the longest edge runs from a to b, and the third corner c is on the side of v.
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
  axes.row(1) = height > 1e-10 * longest ? Vec3(up / height) : Vec3(u.unitOrthogonal());  // otherwise rounding
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

void countFree(MeshData& data, std::int32_t leaf, int change) noexcept {
  data.freeInLeaf[leaf] += change;
  for (std::int32_t node = data.leafParent[leaf].node; node >= 0; node = data.nodeParent[node].node)
    data.freeInNode[node] += change;
}

void buildHierarchy(MeshData& data, int spare) {
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
  data.low = low;
  data.high = high;

  data.nodes.clear();
  data.leaves.clear();
  data.boxes.clear();
  data.triangles.clear();
  data.nodeParent.clear();
  data.leafParent.clear();
  // Reserve slots: copies of triangles hold the places of future ones.
  std::vector<std::array<int, 3>>& all = data.mesh.triangles;
  const std::size_t count = all.size(), most = count + static_cast<std::size_t>(spare);
  all.reserve(most);
  for (std::size_t i = 0; count + i < most; ++i) all.push_back(all[i * count / (most - count)]);
  data.slotOf.assign(most, -1);
  Builder(data).run();
  for (std::size_t t = count; t < most; ++t) clearSlot(data, data.slotOf[t]);
  all.resize(count);
  data.freeInLeaf.assign(data.leaves.size(), 0);
  data.freeInNode.assign(data.nodes.size(), 0);
  for (std::int32_t slot = 0; slot < static_cast<std::int32_t>(data.triangles.size()); ++slot)
    if (data.triangles[slot].index < 0) countFree(data, slot / kWidth, 1);
  if (std::any_of(data.freeInLeaf.begin(), data.freeInLeaf.end(), [](std::int32_t free) { return free == kWidth; }))
    data.view.tight = 0;
  data.view.nodes = data.nodes.data();
  data.view.leaves = data.leaves.data();
  data.view.boxes = data.boxes.data();
  data.view.triangles = data.triangles.data();
  data.view.revision = nextRevision();
}

}  // namespace enamel::kernel
