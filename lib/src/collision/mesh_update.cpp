// Triangles keep their slots. Boxes only ever have to hold what is in them, so removing needs no work there. The sums
// of normals around a change are not repaired but marked: signs there are judged from the triangles themselves.
#include "enamel/collision/mesh_update.hpp"

#include <algorithm>
#include <cmath>

#include "mesh_data.hpp"

namespace enamel {
namespace {

using namespace kernel;

constexpr double kLargestExtent = 8.0;  // local; the mesh at its building reaches from -1 to 1

int placeOfCorner(const MeshData& data, std::int32_t corner) {
  return data.place[data.mesh.triangles[corner / 3][corner % 3]];
}

void insertCorners(MeshData& data, std::int32_t triangle) {
  for (std::int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
    std::int32_t& first = data.firstCorner[placeOfCorner(data, corner)];
    data.nextCorner[corner] = first;
    first = corner;
  }
}

void eraseCorners(MeshData& data, std::int32_t triangle) {
  for (std::int32_t corner = 3 * triangle; corner < 3 * triangle + 3; ++corner) {
    std::int32_t* at = &data.firstCorner[placeOfCorner(data, corner)];
    while (*at >= 0 && *at != corner) at = &data.nextCorner[*at];
    if (*at == corner) *at = data.nextCorner[corner];
  }
}

// Neighbours across the edge between two places: those of exactly two triangles.
void relinkEdge(MeshData& data, int a, int b) {
  std::int32_t user[2] = {-1, -1}, edge[2] = {0, 0};
  int count = 0;
  for (std::int32_t corner = data.firstCorner[a]; corner >= 0; corner = data.nextCorner[corner]) {
    const std::int32_t t = corner / 3, i = corner % 3;
    for (const int e : {i, (i + 2) % 3}) {  // the edges that leave and reach this corner
      const int other = placeOfCorner(data, 3 * t + (e == i ? (i + 1) % 3 : e));
      if (other != b || a == b) continue;
      data.neighbour[t][e] = -1;
      if (count < 2) {
        user[count] = t;
        edge[count] = e;
      }
      ++count;
    }
  }
  if (count != 2) return;
  data.neighbour[user[0]][edge[0]] = user[1];
  data.neighbour[user[1]][edge[1]] = user[0];
}

void relink(MeshData& data, const std::array<int, 3>& corners) {
  for (int i = 0; i < 3; ++i) relinkEdge(data, data.place[corners[i]], data.place[corners[(i + 1) % 3]]);
}

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
  if (data.isDirty[leaf] != 0) return;
  data.isDirty[leaf] = 1;
  data.dirtyLeaves.push_back(leaf);
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
  data.view.revision = nextRevision();
}

bool areTriangles(const MeshData& data, const int* triangles, int count) {
  const int most = static_cast<int>(data.mesh.triangles.size());
  return std::all_of(triangles, triangles + count, [most](int t) { return t >= 0 && t < most; });
}

}  // namespace

Status moveVertices(MeshModel& model, const int* vertices, const Vec3* positions, int count) noexcept {
  MeshData& data = Inside::of(model);
  const int most = static_cast<int>(data.mesh.vertices.size());
  const Vec3 centre(data.view.centre[0], data.view.centre[1], data.view.centre[2]);
  double extent = data.view.extent;
  for (int i = 0; i < count; ++i) {
    if (vertices[i] < 0 || vertices[i] >= most || !positions[i].allFinite()) return Status::notFinite;
    extent = std::max(extent, ((positions[i] - centre) * data.view.scale).cwiseAbs().maxCoeff());
  }
  if (!(extent <= kLargestExtent)) return Status::notFinite;
  data.view.extent = extent;
  for (int i = 0; i < count; ++i) data.mesh.vertices[vertices[i]] = positions[i];
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
  if (!areTriangles(data, triangles, count)) return Status::notFinite;
  data.closed = false;
  data.view.tight = 0;
  for (int i = 0; i < count; ++i) {
    const int t = triangles[i];
    if (!hasTriangle(data, t)) continue;
    eraseCorners(data, t);
    clearSlot(data, data.slotOf[t]);
    data.neighbour[t] = {-1, -1, -1};
    relink(data, data.mesh.triangles[t]);
    taint(data, data.mesh.triangles[t]);
  }
  finish(data);
  return Status::ok;
}

Status replaceTriangles(MeshModel& model, const int* triangles, const std::array<int, 3>* corners, int count) noexcept {
  MeshData& data = Inside::of(model);
  const int most = static_cast<int>(data.mesh.vertices.size());
  if (!areTriangles(data, triangles, count)) return Status::notFinite;
  double extent = data.view.extent;
  const Vec3 centre(data.view.centre[0], data.view.centre[1], data.view.centre[2]);
  for (int i = 0; i < count; ++i)
    for (const int v : corners[i]) {
      if (v < 0 || v >= most) return Status::notFinite;
      extent = std::max(extent, ((data.mesh.vertices[v] - centre) * data.view.scale).cwiseAbs().maxCoeff());
    }
  if (!(extent <= kLargestExtent)) return Status::notFinite;  // a vertex that no triangle used before
  data.view.extent = extent;
  data.closed = false;
  data.view.tight = 0;
  for (int i = 0; i < count; ++i) {
    const int t = triangles[i];
    if (hasTriangle(data, t)) {
      eraseCorners(data, t);
      data.neighbour[t] = {-1, -1, -1};
      relink(data, data.mesh.triangles[t]);
      taint(data, data.mesh.triangles[t]);
    }
    data.mesh.triangles[t] = corners[i];
    insertCorners(data, t);
    relink(data, corners[i]);
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
