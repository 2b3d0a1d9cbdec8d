// Triangle meshes as they come, and what is wrong with them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "enamel/core/types.hpp"

namespace enamel {

/// Vertices and the triangles between them, as a file or a generator gave them: nothing is welded, split or dropped.
struct TriangleMesh {
  std::vector<Vec3> vertices;                 ///< m, in the mesh's own frame
  std::vector<std::array<int, 3>> triangles;  ///< indices of vertices, counterclockwise seen from outside
};

inline constexpr std::size_t kMostTriangles = std::size_t{1} << 27;  ///< of a mesh

/// What inspect() counts. Vertices at exactly the same place count as one, whatever their numbers.
struct MeshReport {
  int triangles = 0;
  int vertices = 0;             ///< as given
  int places = 0;               ///< different places among them
  int degenerateTriangles = 0;  ///< without area: lower than 1e-12 of their longest edge
  int duplicateTriangles = 0;   ///< beyond the first on the same three places
  int edges = 0;
  int boundaryEdges = 0;        ///< with one triangle
  int nonManifoldEdges = 0;     ///< with more than two triangles
  int flippedEdges = 0;         ///< with two triangles that run along it in the same direction
  int nonManifoldVertices = 0;  ///< whose triangles do not form one fan
  int components = 0;           ///< sets of triangles connected by edges
  bool watertight = false;      ///< every edge has as many triangles one way as the other: a volume is enclosed
  bool inwards = false;         ///< watertight, but the volume is negative: normals point into the solid
  double volume = 0.0;          ///< enclosed, m^3; 0 where the mesh is not watertight
  double area = 0.0;            ///< m^2
  Vec3 low = Vec3::Zero();      ///< corner of the bounding box, m
  Vec3 high = Vec3::Zero();     ///< opposite corner, m
};

/// Counts the defects of a mesh. V = sum of a.(b x c) / 6 over the triangles.
/// Throws Error as checkMesh() does. Realtime: no.
MeshReport inspect(const TriangleMesh& mesh);

/// Refuses a mesh that no query can work on: no triangle, a coordinate that is not finite or beyond 1e9 m, an index
/// out of range, more than 2^27 triangles. Throws Error with the number of the vertex or triangle.
void checkMesh(const TriangleMesh& mesh);

/// Number of the place of each vertex: equal for vertices with equal coordinates, counted from 0 by first occurrence.
std::vector<int> weld(const TriangleMesh& mesh);

}  // namespace enamel
