// Triangles keep their slots. Boxes must only contain their triangles, so removing one needs no work on them. The sums
// of normals around a change are not repaired but marked. Signs there are computed from the triangles themselves.
#include "enamel/collision/mesh_update.hpp"

#include <algorithm>
#include <cmath>

#include "boxes.hpp"
#include "cones.hpp"
#include "hierarchy.hpp"
#include "topology.hpp"
#include "winding.hpp"

namespace enamel {
namespace {

using namespace kernel;

constexpr double kLargestExtent = 8.0;  // local; the mesh as built reaches from -1 to 1

// Mark the places of these vertices. At the end all corners and edges there are tainted.
void taint(MeshData& data, const std::array<int, 3>& corners) {
  for (const int v : corners) {
    const int place = data.place[v];
    if (data.isTainted[place] != 0) continue;
    data.isTainted[place] = 1;
    data.taintedPlaces.push_back(place);
  }
}

void taintPlace(MeshData& data, int place) {
  for (std::int32_t c = data.firstCorner[place]; c >= 0; c = data.nextCorner[c]) {
    const int i = c % 3;
    const std::int32_t slot = data.slotOf[c / 3];
    Leaf& leaf = data.leaves[slot / kWidth];
    leaf.front[slot % kWidth] = leaf.back[slot % kWidth] = 0.0f;
    data.triangles[slot].cone = std::min(data.triangles[slot].cone, 0.0f);
    openCones(data, data.leafParent[slot / kWidth]);
    data.tainted[slot] |= 1u << (kCorner0 + i) | 1u << (kEdge01 + i) | 1u << (kEdge01 + (i + 2) % 3);
  }
  data.isTainted[place] = 0;
}

void rewrite(MeshData& data, std::int32_t triangle) {
  const std::int32_t slot = data.slotOf[triangle], leaf = slot / kWidth;
  data.edited = true;
  writeSlot(data, slot, triangle);
  markStale(data, leaf);
  if (data.isDirty[leaf] != 0) return;
  data.isDirty[leaf] = 1;
  data.dirtyLeaves.push_back(leaf);
}

int trianglesOf(const MeshData& data, std::int32_t leaf, std::array<std::int32_t, kWidth>& triangles) {
  int count = 0;
  for (std::int32_t slot = leaf * kWidth; slot < (leaf + 1) * kWidth; ++slot)
    if (data.triangles[slot].index >= 0) triangles[count++] = data.triangles[slot].index;
  return count;
}

// Refit the boxes of a leaf, and of all nodes above, to its content.
void refitLeaf(MeshData& data, std::int32_t leaf) {
  Parent at = data.leafParent[leaf];
  std::array<std::int32_t, kWidth> triangles{};
  data.scratch.clear();
  gatherCorners(data, triangles.data(), trianglesOf(data, leaf, triangles), data.scratch);
  if (data.scratch.empty()) return;
  // The axes and the cone stay. The oriented boxes above only grow.
  const Oriented oriented = boxAlong(readOriented(data, at).axes, data.scratch);
  writeOriented(data, at, oriented);
  const Vec3 middle = -(oriented.axes.transpose() * oriented.offset);
  Extent extent;
  for (const Vec3& q : data.scratch) extent.add(q);
  FloatBox box = extent.box();
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

void finish(MeshData& data) {
  for (const std::int32_t leaf : data.dirtyLeaves) {
    refitLeaf(data, leaf);
    data.isDirty[leaf] = 0;
    std::fill_n(data.isRewritten.begin() + leaf * kWidth, kWidth, '\0');
  }
  data.dirtyLeaves.clear();
  for (const int place : data.taintedPlaces) taintPlace(data, place);
  data.taintedPlaces.clear();
  refitWinding(data);
  data.view.revision = nextRevision();
}

bool areTriangles(const MeshData& data, const int* triangles, int count) {
  const int most = static_cast<int>(data.mesh.triangles.size());
  return count >= 0 && std::all_of(triangles, triangles + count, [most](int t) { return t >= 0 && t < most; });
}

double extentOf(const MeshData& data, const Vec3& p) { return local(data.view, p).cwiseAbs().maxCoeff(); }

// Extend the bounds of the mesh to p.
void enlarge(MeshData& data, const Vec3& p) {
  data.view.extent = std::max(data.view.extent, extentOf(data, p));
  data.low = data.low.cwiseMin(p);
  data.high = data.high.cwiseMax(p);
}

Status checkPositions(const MeshData& data, const Vec3* positions, int count) {
  for (int i = 0; i < count; ++i) {
    if (!positions[i].allFinite()) return Status::notFinite;
    if (!(extentOf(data, positions[i]) <= kLargestExtent)) return Status::outOfRange;
  }
  return Status::ok;
}

// Unused vertices may be far away until a triangle uses them.
Status checkCorners(const MeshData& data, const std::array<int, 3>* corners, int count) {
  const int most = static_cast<int>(data.mesh.vertices.size());
  for (int i = 0; i < count; ++i)
    for (const int v : corners[i])
      if (v < 0 || v >= most || !(extentOf(data, data.mesh.vertices[v]) <= kLargestExtent)) return Status::outOfRange;
  return Status::ok;
}

std::int32_t freeSlotOf(const MeshData& data, std::int32_t leaf) {
  std::int32_t slot = leaf * kWidth;
  while (data.triangles[slot].index >= 0) ++slot;
  return slot;
}

// Choose a free slot near the future place of triangle t: in a leaf of its neighbours, or as deep in the hierarchy as
// possible. There are as many slots as possible triangles.
std::int32_t chooseSlot(const MeshData& data, std::int32_t t) {
  std::int32_t leaf = data.slotOf[t] / kWidth;
  for (const int v : data.mesh.triangles[t])
    for (std::int32_t c = data.firstCorner[data.place[v]]; c >= 0; c = data.nextCorner[c]) {
      if (c / 3 == t) continue;
      leaf = data.slotOf[c / 3] / kWidth;
      if (data.freeInLeaf[leaf] > 0) return freeSlotOf(data, leaf);
    }
  if (data.freeInLeaf[leaf] > 0) return freeSlotOf(data, leaf);
  std::int32_t node = data.leafParent[leaf].node;
  while (data.freeInNode[node] == 0) node = data.nodeParent[node].node;
  for (;;) {
    unsigned lanes = data.nodes[node].lanes;
    std::int32_t child = 0;
    for (;; lanes &= lanes - 1) {
      child = data.nodes[node].child[__builtin_ctz(lanes)];
      if ((child < 0 ? data.freeInLeaf[~child] : data.freeInNode[child]) > 0) break;
    }
    if (child < 0) return freeSlotOf(data, ~child);
    node = child;
  }
}

void takeOut(MeshData& data, std::int32_t t) {
  unlinkTriangle(data, t);
  clearSlot(data, data.slotOf[t]);
  countFree(data, data.slotOf[t] / kWidth, 1);
  markStale(data, data.slotOf[t] / kWidth);
  taint(data, data.mesh.triangles[t]);
}

void putIn(MeshData& data, std::int32_t t, const std::array<int, 3>& corners) {
  linkTriangle(data, t, corners);
  data.slotOf[t] = chooseSlot(data, t);
  countFree(data, data.slotOf[t] / kWidth, -1);
  for (const int v : corners) enlarge(data, data.mesh.vertices[v]);
  rewrite(data, t);
  taint(data, corners);
}

}  // namespace

void kernel::reserveForUpdates(MeshData& data, int spareVertices) {
  const auto more = static_cast<std::size_t>(spareVertices);
  data.mostVertices = static_cast<int>(data.mesh.vertices.size()) + spareVertices;
  data.mesh.vertices.reserve(data.mesh.vertices.size() + more);
  data.place.reserve(data.mesh.vertices.size() + more);
  data.firstCorner.reserve(data.firstCorner.size() + more);
  data.isTainted.reserve(data.firstCorner.size() + more);
  data.scratch.reserve(3 * kWidth);
  data.dirtyLeaves.reserve(data.leaves.size());
  data.isDirty.assign(data.leaves.size(), 0);
  data.isRewritten.assign(data.triangles.size(), 0);
  data.isTainted.assign(data.firstCorner.size(), 0);
  data.taintedPlaces.reserve(data.firstCorner.size() + more);
}

Status moveVertices(MeshModel& model, const int* vertices, const Vec3* positions, int count) noexcept {
  MeshData& data = Inside::of(model);
  const int most = static_cast<int>(data.mesh.vertices.size());
  if (count < 0 || std::any_of(vertices, vertices + count, [most](int v) { return v < 0 || v >= most; }))
    return Status::outOfRange;
  if (const Status status = checkPositions(data, positions, count); status != Status::ok) return status;
  for (int i = 0; i < count; ++i) {
    data.mesh.vertices[vertices[i]] = positions[i];
    enlarge(data, positions[i]);
  }
  for (int i = 0; i < count; ++i)
    for (std::int32_t c = data.firstCorner[data.place[vertices[i]]]; c >= 0; c = data.nextCorner[c]) {
      char& isRewritten = data.isRewritten[data.slotOf[c / 3]];
      if (isRewritten != 0) continue;
      isRewritten = 1;
      rewrite(data, c / 3);
      taint(data, data.mesh.triangles[c / 3]);
    }
  finish(data);
  return Status::ok;
}

Status addVertices(MeshModel& model, const Vec3* positions, int count) noexcept {
  MeshData& data = Inside::of(model);
  if (count < 0 || count > spareCapacity(model).vertices) return Status::outOfRange;
  if (const Status status = checkPositions(data, positions, count); status != Status::ok) return status;
  for (int i = 0; i < count; ++i) {
    data.place.push_back(static_cast<int>(data.firstCorner.size()));
    data.firstCorner.push_back(-1);
    data.isTainted.push_back(0);
    data.mesh.vertices.push_back(positions[i]);
  }
  return Status::ok;
}

Status addTriangles(MeshModel& model, const std::array<int, 3>* corners, int count) noexcept {
  MeshData& data = Inside::of(model);
  if (count < 0 || count > spareCapacity(model).triangles) return Status::outOfRange;
  if (const Status status = checkCorners(data, corners, count); status != Status::ok) return status;
  for (int i = 0; i < count; ++i) {
    data.mesh.triangles.push_back(corners[i]);
    putIn(data, static_cast<std::int32_t>(data.mesh.triangles.size()) - 1, corners[i]);
  }
  finish(data);
  return Status::ok;
}

Status removeTriangles(MeshModel& model, const int* triangles, int count) noexcept {
  MeshData& data = Inside::of(model);
  if (!areTriangles(data, triangles, count)) return Status::outOfRange;
  data.view.tight = 0;
  for (int i = 0; i < count; ++i)
    if (hasTriangle(data, triangles[i])) takeOut(data, triangles[i]);
  finish(data);
  return Status::ok;
}

Status replaceTriangles(MeshModel& model, const int* triangles, const std::array<int, 3>* corners, int count) noexcept {
  MeshData& data = Inside::of(model);
  if (!areTriangles(data, triangles, count)) return Status::outOfRange;
  if (const Status status = checkCorners(data, corners, count); status != Status::ok) return status;
  data.view.tight = 0;
  for (int i = 0; i < count; ++i) {
    if (hasTriangle(data, triangles[i])) takeOut(data, triangles[i]);
    putIn(data, triangles[i], corners[i]);
  }
  finish(data);
  return Status::ok;
}

SpareCapacity spareCapacity(const MeshModel& model) noexcept {
  const MeshData& data = Inside::of(model);
  return {data.mostVertices - static_cast<int>(data.mesh.vertices.size()),
          static_cast<int>(data.slotOf.size() - data.mesh.triangles.size())};
}

bool isPresent(const MeshModel& model, int triangle) noexcept {
  const MeshData& data = Inside::of(model);
  return triangle >= 0 && triangle < static_cast<int>(data.mesh.triangles.size()) && hasTriangle(data, triangle);
}

}  // namespace enamel
