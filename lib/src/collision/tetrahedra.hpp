// A cube divided into six tetrahedra around a diagonal (Freudenthal 1942), and the surface in them.
#pragma once

#include <algorithm>
#include <array>
#include <utility>

namespace enamel::kernel {

inline constexpr double kEnd = 0.01;  ///< share of an edge: least distance of a vertex from its ends

/// From corner to opposite corner along the three axes in every order. Bits x, y, z of a corner.
struct Tetrahedron {
  std::array<int, 4> corners;
  bool isOdd;
};
inline constexpr std::array<Tetrahedron, 6> kTetrahedra = {{{{0, 1, 3, 7}, false},
                                                            {{0, 2, 6, 7}, false},
                                                            {{0, 4, 5, 7}, false},
                                                            {{0, 2, 3, 7}, true},
                                                            {{0, 4, 6, 7}, true},
                                                            {{0, 1, 5, 7}, true}}};

/// Add the triangles of a cube. `isInside(corner)`; `on(from, to)` returns the vertex between two corners, and
/// `add(a, b, c)` takes three vertices, counterclockwise seen from outside.
template <typename IsInside, typename On, typename Add>
void addTriangles(const IsInside& isInside, const On& on, const Add& add) {
  for (const Tetrahedron& tetrahedron : kTetrahedra) {
    std::array<int, 4> c;  // corners inside first
    int inside = 0, outside = 0;
    bool isOdd = tetrahedron.isOdd;
    std::array<int, 4> others;
    for (const int corner : tetrahedron.corners) {
      if (isInside(corner)) {
        c[static_cast<std::size_t>(inside++)] = corner;
        isOdd = isOdd != (outside % 2 != 0);
      } else {
        others[static_cast<std::size_t>(outside++)] = corner;
      }
    }
    if (inside == 0 || outside == 0) continue;
    std::copy(others.begin(), others.begin() + outside, c.begin() + inside);
    if (isOdd) inside == 1 ? std::swap(c[2], c[3]) : std::swap(c[0], c[1]);
    if (inside == 1) {
      add(on(c[0], c[1]), on(c[0], c[2]), on(c[0], c[3]));
    } else if (inside == 3) {
      add(on(c[3], c[0]), on(c[3], c[1]), on(c[3], c[2]));
    } else {
      add(on(c[0], c[2]), on(c[0], c[3]), on(c[1], c[3]));
      add(on(c[0], c[2]), on(c[1], c[3]), on(c[1], c[2]));
    }
  }
}

}  // namespace enamel::kernel
