// Triangle meshes as input, and a report of their defects.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "enamel/core/types.hpp"

namespace enamel {

/// Vertices and triangles as a file or generator produced them: never welded, split or dropped.
struct TriangleMesh {
  std::vector<Vec3> vertices;                 ///< m, in the mesh's own frame
  std::vector<std::array<int, 3>> triangles;  ///< indices of vertices, counterclockwise seen from outside
};

inline constexpr std::size_t kMostTriangles = std::size_t{1} << 27;  ///< largest number of a mesh's triangles

/// Result of inspect(). Vertices with exactly the same coordinates count as one place, whatever their numbers.
struct MeshReport {
  int triangles = 0;
  int vertices = 0;             ///< as given in the mesh
  int places = 0;               ///< number of different places
  int degenerateTriangles = 0;  ///< without area: height below 1e-12 of the longest edge
  int duplicateTriangles = 0;   ///< repetitions of a triangle with the same three places
  int edges = 0;
  int boundaryEdges = 0;        ///< used by one triangle
  int nonManifoldEdges = 0;     ///< used by more than two triangles
  int flippedEdges = 0;         ///< two triangles use the edge in the same direction
  int nonManifoldVertices = 0;  ///< triangles at the vertex do not form one fan
  int components = 0;           ///< sets of triangles connected by edges
  bool watertight = false;      ///< every edge is used equally often in both directions, so a volume is enclosed
  bool inwards = false;         ///< watertight with a negative volume: normals point into the solid
  double volume = 0.0;          ///< enclosed volume, m^3; 0 if not watertight
  double area = 0.0;            ///< m^2
  Vec3 low = Vec3::Zero();      ///< corner of the bounding box, m
  Vec3 high = Vec3::Zero();     ///< opposite corner, m
};

/// Count the defects of a mesh. The volume is the sum of a.(b x c) / 6 over the triangles. Throws Error as checkMesh().
/// Realtime: no.
MeshReport inspect(const TriangleMesh& mesh);

/// Reject a mesh that queries cannot use. Throws Error with the number of the vertex or triangle for:
/// - no triangles, or more than 2^27;
/// - a coordinate that is not finite or above 1e9 m;
/// - an index out of range.
void checkMesh(const TriangleMesh& mesh);

/// Return the place number of each vertex. Vertices with equal coordinates have equal numbers. They count from 0 in the
/// order of first occurrence.
std::vector<int> weld(const TriangleMesh& mesh);

}  // namespace enamel
