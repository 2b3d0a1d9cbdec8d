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
  data.nextCorner.assign(3 * mesh.triangles.size(), -1);
  for (auto t = static_cast<std::int32_t>(mesh.triangles.size()); t-- > 0;) insertCorners(data, t);
  data.neighbour.assign(mesh.triangles.size(), {-1, -1, -1});
  std::vector<EdgeUse> edges = sortedEdges(mesh, data.place);
  data.closed = !edges.empty();
  forEachEdge(edges, [&](const EdgeUse* first, const EdgeUse* last) {
    data.closed = data.closed && balanceOf(first, last) == 0;
    if (last - first != 2) return;
    data.neighbour[first[0].triangle][first[0].edge] = first[1].triangle;
    data.neighbour[first[1].triangle][first[1].edge] = first[0].triangle;
  });
  return edges;
}

void unlinkTriangle(MeshData& data, std::int32_t triangle) {
  eraseCorners(data, triangle);
  data.neighbour[triangle] = {-1, -1, -1};
  relink(data, data.mesh.triangles[triangle]);
}

void linkTriangle(MeshData& data, std::int32_t triangle, const std::array<int, 3>& corners) {
  data.mesh.triangles[triangle] = corners;
  insertCorners(data, triangle);
  relink(data, corners);
}

}  // namespace enamel::kernel
