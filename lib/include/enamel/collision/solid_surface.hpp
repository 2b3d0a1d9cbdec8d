// The surface of a solid as triangles, for drawing and for files.
#pragma once

#include <cstdint>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel {

/// Triangles with normals and layers for drawing.
struct SolidSurface {
  TriangleMesh mesh;
  std::vector<Vec3> normals;  ///< for each vertex: outward unit normal
  std::vector<int> layers;    ///< for each vertex: the layer just below the surface

  /// Remove all triangles and vertices but keep the memory.
  void clear() noexcept;
};

/// Append the surface of one brick. Realtime: no.
/// - `samples`: those of the solid, or an earlier copy.
/// - `step`: 2, 4 or 8 uses only every second, fourth or eighth sample. Each doubling gives a quarter of the triangles,
///   enough for smooth regions.
/// - `coarser`: the neighbours that are drawn with twice the step. Bit 13 + x + 3 y + 9 z is the neighbour at
///   (x, y, z), each -1, 0 or 1. The common border then has exactly the neighbour's vertices.
///
/// Vertices on the border are bit-identical to those of the next brick; their normals differ slightly. The function
/// reads only parts of the solid that cuts do not change. Any thread may therefore call it while another thread cuts.
/// It allocates only when `surface` must grow.
void appendSurface(const Solid& solid, int brick, const BrickSamples& samples, SolidSurface& surface, int step = 1,
                   std::uint32_t coarser = 0);

/// Call `visit(bit, other)` for every brick that shares a corner with this one. `bit` is that of `coarser` above.
template <typename Visit>
void forEachNeighbour(const Solid& solid, int brick, const Visit& visit) {
  const double edge = kBrickCells * solid.cell();
  const Vec3 middle = solid.lowOf(brick) + Vec3::Constant(0.5 * edge);
  for (int bit = 0; bit < 27; ++bit) {
    const int x = bit % 3 - 1, y = bit / 3 % 3 - 1, z = bit / 9 - 1;
    if (const int other = solid.brickAt(middle + edge * Vec3(x, y, z)); other >= 0 && other != brick) visit(bit, other);
  }
}

/// Return the surface of the whole solid as a watertight mesh: two triangles at every edge, no triangle through
/// another. It is empty if the solid is cut away. Realtime: no.
///
/// Each cell is divided into six tetrahedra around a diagonal (Freudenthal 1942). Vertices are where the interpolation
/// is 0 along their edges, and a sample of 0 is outside. Source: Doi and Koide, "An efficient method of triangulating
/// equi-valued surfaces by using tetrahedral cells", 1991. Vertices keep a distance of 1 % of an edge from its ends, so
/// that every triangle has an area. If the middle of a triangle is more than 0.25 cells off the surface, the triangle
/// is split at a new vertex on the surface.
TriangleMesh surfaceOf(const Solid& solid);

}  // namespace enamel
