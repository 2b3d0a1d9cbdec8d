// Makes a mesh that comes from a scanner one that a tool can touch: manifold, closed, and no larger than it need be.
#pragma once

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

struct PrepareOptions {
  double deviation = 0.0;  ///< triangles may go while the measured deviation stays within this, m; 0: none goes
  double base = 0.0;       ///< the longest opening is closed by a base so much below it, m; 0: as every hole
};

/// Distances between two meshes, at the vertices and the middles of edges and faces of one, exactly to the other.
struct Deviation {
  double most = 0.0, rms = 0.0;  ///< m
  int points = 0;
};

struct PrepareReport {
  int joinedVertices = 0;          ///< at the place of another
  int uselessTriangles = 0;        ///< with a repeated corner, or on the same corners as another
  int misfitTriangles = 0;         ///< left out: more than two at an edge, or sheets that meet in a corner
  int turnedTriangles = 0;         ///< all of them, where the surface was inside out
  int closedHoles = 0;             ///< the one with the base among them
  int openHoles = 0;               ///< that could not be closed
  int beforeDecimation = 0;        ///< triangles
  Deviation fromFile;              ///< of what was in the file from the result
  Deviation fromClosed, toClosed;  ///< of the closed mesh from the decimated one, and the other way
};

/// What is written: joined, closed, decimated, its vertices rounded to single precision in mm. Throws Error as
/// checkMesh() does, and where nothing of the mesh is left.
TriangleMesh prepareMesh(const TriangleMesh& mesh, const PrepareOptions& options, PrepareReport& report);

}  // namespace enamel::app
