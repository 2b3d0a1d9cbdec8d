// Which triangles of a mesh meet where. Vertices at one place count as one.
#pragma once

#include <vector>

#include "mesh_data.hpp"

namespace enamel::kernel {

/// One triangle at an edge between two different places.
struct EdgeUse {
  std::int32_t low, high;  // places, low < high
  std::int32_t triangle;
  std::int8_t edge;  // 0: corners 0 and 1, and so on round
  bool forward;      // the triangle runs from low to high
};

/// All edges of all triangles, those between the same places side by side.
std::vector<EdgeUse> sortedEdges(const TriangleMesh& mesh, const std::vector<int>& place);

/// Calls visit(first, last) for the uses of every edge.
template <typename Visit>
void forEachEdge(const std::vector<EdgeUse>& edges, const Visit& visit) {
  const EdgeUse* const end = edges.data() + edges.size();
  for (const EdgeUse *first = edges.data(), *last; first != end; first = last) {
    for (last = first; last != end && last->low == first->low && last->high == first->high;) ++last;
    visit(first, last);
  }
}

/// How many more uses of an edge run from low to high than back.
inline int balanceOf(const EdgeUse* first, const EdgeUse* last) {
  int balance = 0;
  for (; first != last; ++first) balance += first->forward ? 1 : -1;
  return balance;
}

/// Finds places, neighbours and the triangles at each place; answers the edges.
std::vector<EdgeUse> buildTopology(MeshData& data);

/// Takes a triangle out of the lists of its places and from its neighbours.
void unlinkTriangle(MeshData& data, std::int32_t triangle);

/// Gives a triangle that is in no list its corners, and links it.
void linkTriangle(MeshData& data, std::int32_t triangle, const std::array<int, 3>& corners);

}  // namespace enamel::kernel
