// Prepares a scanned mesh for contact: manifold, closed, and as small as the allowed deviation permits.
#pragma once

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

struct PrepareOptions {
  double deviation = 0.0;  ///< largest measured deviation that decimation may cause, m; 0: no decimation
  double base = 0.0;       ///< the longest opening is closed by a base this far below it, m; 0: no base
};

/// Distances from one mesh to another, exact at the vertices and the centres of edges and faces of the first.
struct Deviation {
  double most = 0.0, rms = 0.0;  ///< m
  int points = 0;
};

struct PrepareReport {
  int joinedVertices = 0;          ///< merged with another vertex at the same place
  int uselessTriangles = 0;        ///< with a repeated corner, or with the same corners as another
  int misfitTriangles = 0;         ///< left out: more than two at an edge, or sheets that meet in a vertex
  int turnedTriangles = 0;         ///< all triangles if the surface was inside out
  int closedHoles = 0;             ///< including the one closed by the base
  int openHoles = 0;               ///< holes that could not be closed
  int beforeDecimation = 0;        ///< triangles
  Deviation fromFile;              ///< from the file's mesh to the result
  Deviation fromClosed, toClosed;  ///< from the closed mesh to the decimated one, and the reverse
};

/// Return the mesh to be written: merged, closed, decimated, with vertices rounded to single precision in mm. Throws
/// Error: as checkMesh(); no triangle of the mesh can be used.
TriangleMesh prepareMesh(const TriangleMesh& mesh, const PrepareOptions& options, PrepareReport& report);

}  // namespace enamel::app
