#include "topology.hpp"

#include <algorithm>

namespace enamel::kernel {
namespace {

int placeOfCorner(const MeshData& data, std::int32_t corner) {
  return data.place[data.mesh.triangles[corner / 3][corner % 3]];
}

void insertCorners(MeshData& data, std::int32_t triangle) {
  for (std::int32_t corner = 3 * triangle + 2; corner >= 3 * triangle; --corner) {
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

// Number of triangles at an edge, and the difference between those in its direction and those against it.
struct EdgeState {
  int uses = 0, balance = 0;
};

// Link the neighbours across the edge between two places, if it has exactly two triangles.
EdgeState relinkEdge(MeshData& data, int a, int b) {
  EdgeState state;
  std::int32_t user[2] = {-1, -1}, edge[2] = {0, 0};
  int count = 0;
  for (std::int32_t corner = data.firstCorner[a]; corner >= 0; corner = data.nextCorner[corner]) {
    const std::int32_t t = corner / 3, i = corner % 3;
    for (const int e : {i, (i + 2) % 3}) {  // the edges that leave and reach this corner
      const int other = placeOfCorner(data, 3 * t + (e == i ? (i + 1) % 3 : e));
      if (other != b || a == b) continue;
      data.neighbour[t][e] = -1;
      state.balance += e == i ? 1 : -1;
      if (count < 2) {
        user[count] = t;
        edge[count] = e;
      }
      ++count;
    }
  }
  state.uses = count;
  if (count != 2) return state;
  data.neighbour[user[0]][edge[0]] = user[1];
  data.neighbour[user[1]][edge[1]] = user[0];
  return state;
}

void countEdge(MeshData& data, const EdgeState& edge, int change) {
  if (edge.balance != 0) data.openEdges += change;
  if (edge.uses > 2) data.crowdedEdges += change;
}

// Update after a triangle was removed (change -1) or inserted (1).
void relink(MeshData& data, const std::array<int, 3>& corners, int change) {
  const auto placeOf = [&](int i) { return data.place[corners[i % 3]]; };
  for (int i = 0; i < 3; ++i) {
    const int a = placeOf(i), b = placeOf(i + 1);
    const EdgeState after = relinkEdge(data, a, b);
    EdgeState before = after;
    bool isKnown = a == b;  // no edge, or an edge that a flat triangle uses twice
    for (int k = 0; k < 3; ++k) {
      const bool isSame = placeOf(k) == a && placeOf(k + 1) == b, isBack = placeOf(k) == b && placeOf(k + 1) == a;
      if (!isSame && !isBack) continue;
      isKnown = isKnown || k < i;
      before.uses -= change;
      before.balance -= isSame ? change : -change;
    }
    if (isKnown) continue;
    countEdge(data, before, -1);
    countEdge(data, after, 1);
  }
  data.closed = data.openEdges == 0;
  data.sound = data.closed && data.crowdedEdges == 0 && !data.crossesItself;
}

}  // namespace

std::vector<EdgeUse> sortedEdges(const TriangleMesh& mesh, const std::vector<int>& place) {
  std::vector<EdgeUse> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int e = 0; e < 3; ++e) {
      const int a = place[mesh.triangles[t][e]], b = place[mesh.triangles[t][(e + 1) % 3]];
      if (a == b) continue;
      edges.push_back(
          {std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), static_cast<std::int8_t>(e), a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return a.edge < b.edge;
  });
  return edges;
}

std::vector<EdgeUse> buildTopology(MeshData& data) {
  const TriangleMesh& mesh = data.mesh;
  data.place = weld(mesh);
  const std::size_t places = *std::max_element(data.place.begin(), data.place.end()) + 1u;
  data.firstCorner.assign(places, -1);
  data.nextCorner.assign(3 * data.slotOf.size(), -1);
  for (auto t = static_cast<std::int32_t>(mesh.triangles.size()); t-- > 0;) insertCorners(data, t);
  data.neighbour.assign(data.slotOf.size(), {-1, -1, -1});
  std::vector<EdgeUse> edges = sortedEdges(mesh, data.place);
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) {
    countEdge(data, {static_cast<int>(last - first), balanceOf(first, last)}, 1);
    if (last - first != 2) return;
    data.neighbour[first[0].triangle][first[0].edge] = first[1].triangle;
    data.neighbour[first[1].triangle][first[1].edge] = first[0].triangle;
  });
  data.closed = !edges.empty() && data.openEdges == 0;
  return edges;
}

void unlinkTriangle(MeshData& data, std::int32_t triangle) {
  eraseCorners(data, triangle);
  data.neighbour[triangle] = {-1, -1, -1};
  relink(data, data.mesh.triangles[triangle], -1);
}

void linkTriangle(MeshData& data, std::int32_t triangle, const std::array<int, 3>& corners) {
  data.mesh.triangles[triangle] = corners;
  insertCorners(data, triangle);
  relink(data, corners, 1);
}

}  // namespace enamel::kernel
