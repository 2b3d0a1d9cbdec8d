// Triangles keep their slots. Boxes only ever have to hold what is in them, so removing needs no work there. The sums
// of normals around a change are not repaired but marked: signs there are judged from the triangles themselves.
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

constexpr double kLargestExtent = 8.0;  // local; the mesh at its building reaches from -1 to 1

// To be done at the end: all corners at the places of these vertices, and the edges that meet there.
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
    data.edgeNormals[slot].tainted |= 1u << (kCorner0 + i) | 1u << (kEdge01 + i) | 1u << (kEdge01 + (i + 2) % 3);
  }
  data.isTainted[place] = 0;
}

void rewrite(MeshData& data, std::int32_t triangle) {
  const std::int32_t slot = data.slotOf[triangle], leaf = slot / kWidth;
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

// Makes the boxes of a leaf and of all nodes above hold what is in it.
void refitLeaf(MeshData& data, std::int32_t leaf) {
  Parent at = data.leafParent[leaf];
  std::array<std::int32_t, kWidth> triangles{};
  data.scratch.clear();
  gatherCorners(data, triangles.data(), trianglesOf(data, leaf, triangles), data.scratch);
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

void enlargeBox(MeshData& data, const Vec3& p) {
  data.low = data.low.cwiseMin(p);
  data.high = data.high.cwiseMax(p);
}

bool areTriangles(const MeshData& data, const int* triangles, int count) {
  const int most = static_cast<int>(data.mesh.triangles.size());
  return std::all_of(triangles, triangles + count, [most](int t) { return t >= 0 && t < most; });
}

}  // namespace

void kernel::reserveForUpdates(MeshData& data) {
  data.scratch.reserve(3 * kWidth);
  data.dirtyLeaves.reserve(data.leaves.size());
  data.isDirty.assign(data.leaves.size(), 0);
  data.isRewritten.assign(data.triangles.size(), 0);
  data.isTainted.assign(data.firstCorner.size(), 0);
  data.taintedPlaces.reserve(data.firstCorner.size());
}

Status moveVertices(MeshModel& model, const int* vertices, const Vec3* positions, int count) noexcept {
  MeshData& data = Inside::of(model);
  const int most = static_cast<int>(data.mesh.vertices.size());
  double extent = data.view.extent;
  for (int i = 0; i < count; ++i) {
    if (vertices[i] < 0 || vertices[i] >= most) return Status::outOfRange;
    if (!positions[i].allFinite()) return Status::notFinite;
    extent = std::max(extent, local(data.view, positions[i]).cwiseAbs().maxCoeff());
  }
  if (!(extent <= kLargestExtent)) return Status::outOfRange;
  data.view.extent = extent;
  for (int i = 0; i < count; ++i) {
    data.mesh.vertices[vertices[i]] = positions[i];
    enlargeBox(data, positions[i]);
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

Status removeTriangles(MeshModel& model, const int* triangles, int count) noexcept {
  MeshData& data = Inside::of(model);
  if (!areTriangles(data, triangles, count)) return Status::outOfRange;
  data.view.tight = 0;
  for (int i = 0; i < count; ++i) {
    const int t = triangles[i];
    if (!hasTriangle(data, t)) continue;
    unlinkTriangle(data, t);
    clearSlot(data, data.slotOf[t]);
    markStale(data, data.slotOf[t] / kWidth);
    taint(data, data.mesh.triangles[t]);
  }
  finish(data);
  return Status::ok;
}

Status replaceTriangles(MeshModel& model, const int* triangles, const std::array<int, 3>* corners, int count) noexcept {
  MeshData& data = Inside::of(model);
  const int most = static_cast<int>(data.mesh.vertices.size());
  if (!areTriangles(data, triangles, count)) return Status::outOfRange;
  double extent = data.view.extent;
  for (int i = 0; i < count; ++i)
    for (const int v : corners[i]) {
      if (v < 0 || v >= most) return Status::outOfRange;
      extent = std::max(extent, local(data.view, data.mesh.vertices[v]).cwiseAbs().maxCoeff());
    }
  if (!(extent <= kLargestExtent)) return Status::outOfRange;  // a vertex that no triangle used before
  data.view.extent = extent;
  data.view.tight = 0;
  for (int i = 0; i < count; ++i) {
    const int t = triangles[i];
    if (hasTriangle(data, t)) {
      unlinkTriangle(data, t);
      taint(data, data.mesh.triangles[t]);
    }
    linkTriangle(data, t, corners[i]);
    for (const int v : corners[i]) enlargeBox(data, data.mesh.vertices[v]);
    rewrite(data, t);
    taint(data, corners[i]);
  }
  finish(data);
  return Status::ok;
}

bool isPresent(const MeshModel& model, int triangle) noexcept {
  const MeshData& data = Inside::of(model);
  return triangle >= 0 && triangle < static_cast<int>(data.mesh.triangles.size()) && hasTriangle(data, triangle);
}

}  // namespace enamel
