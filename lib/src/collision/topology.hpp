// Which triangles of a mesh meet where. Vertices at the same place count as one.
#pragma once

#include <vector>

#include "mesh_data.hpp"

namespace enamel::kernel {

/// A triangle at an edge between two different places.
struct EdgeUse {
  std::int32_t low, high;  // places, low < high
  std::int32_t triangle;
  std::int8_t edge;  // 0: between corners 0 and 1, and so on
  bool forward;      // the triangle runs from low to high
};

/// Return all edges of all triangles, sorted so that those between the same places are adjacent.
std::vector<EdgeUse> sortedEdges(const TriangleMesh& mesh, const std::vector<int>& place);

/// Call visit(first, last) for the uses of every edge.
template <typename Visit>
void forEachEdge(const std::vector<EdgeUse>& edges, const Visit& visit) {
  const EdgeUse* const end = edges.data() + edges.size();
  for (const EdgeUse *first = edges.data(), *last; first != end; first = last) {
    for (last = first; last != end && last->low == first->low && last->high == first->high;) ++last;
    visit(first, last);
  }
}

/// Return how many more uses of an edge run from low to high than back.
inline int balanceOf(const EdgeUse* first, const EdgeUse* last) {
  int balance = 0;
  for (; first != last; ++first) balance += first->forward ? 1 : -1;
  return balance;
}

/// Find places, neighbours and the triangles at each place. Returns the edges.
std::vector<EdgeUse> buildTopology(MeshData& data);

/// Remove a triangle from the lists of its places and from its neighbours.
void unlinkTriangle(MeshData& data, std::int32_t triangle);

/// Set the corners of a triangle that is in no list, and link it.
void linkTriangle(MeshData& data, std::int32_t triangle, const std::array<int, 3>& corners);

}  // namespace enamel::kernel
