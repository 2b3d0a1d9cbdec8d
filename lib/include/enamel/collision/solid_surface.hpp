// The surface of a solid as triangles, to draw and to write.
#pragma once

#include <cstdint>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel {

/// Triangles with what it takes to draw them.
struct SolidSurface {
  TriangleMesh mesh;
  std::vector<Vec3> normals;  ///< by vertex: outward, of unit length
  std::vector<int> layers;    ///< by vertex: just below the surface

  /// The memory stays.
  void clear() noexcept;
};

/// Appends the surface of one brick with these samples, the solid's or a copy from some moment. Vertices on the border
/// have the same bits as those of the next brick, normals there differ a little. Of the solid only what no cut changes
/// is read: any thread may do this while another one cuts. Allocates nothing but what `surface` lacks. Realtime: no,
/// some 10 us for a brick with surface. `step`: 2, 4 or 8 takes only every second, fourth or eighth sample, for a
/// quarter of the triangles each time: enough to see what is smooth. `coarser`: neighbours that are drawn with twice
/// the step, bit 13 + x + 3 y + 9 z for the one at (x, y, z), each -1, 0 or 1; the border then has their vertices, to
/// the bit.
void appendSurface(const Solid& solid, int brick, const BrickSamples& samples, SolidSurface& surface, int step = 1,
                   std::uint32_t coarser = 0);

/// `visit(bit, other)` for every brick that shares a corner with this one, bit as of `coarser` above.
template <typename Visit>
void forEachNeighbour(const Solid& solid, int brick, const Visit& visit) {
  const double edge = kBrickCells * solid.cell();
  const Vec3 middle = solid.lowOf(brick) + Vec3::Constant(0.5 * edge);
  for (int bit = 0; bit < 27; ++bit) {
    const int x = bit % 3 - 1, y = bit / 3 % 3 - 1, z = bit / 9 - 1;
    if (const int other = solid.brickAt(middle + edge * Vec3(x, y, z)); other >= 0 && other != brick) visit(bit, other);
  }
}

/// The surface of all of it: where the interpolation is 0 along the edges of the six tetrahedra around a diagonal of
/// every cell (Freudenthal 1942; Doi and Koide, "An efficient method of triangulating equi-valued surfaces by using
/// tetrahedral cells", 1991), a sample of 0 being outside. Watertight, two triangles at every edge, none through
/// another; empty where nothing is left. Vertices keep 1 % of an edge away from its ends, so that every triangle has an
/// area. Realtime: no.
TriangleMesh surfaceOf(const Solid& solid);

}  // namespace enamel
