// A cut solid compared with the target of a preparation: volumes over and under cut, and distances of the surfaces.
#pragma once

#include <vector>

#include "enamel/collision/mesh.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel {

/// Differences in one region of a preparation.
struct CutDifference {
  RemovedVolume overCut{};   ///< removed but part of the target, m^3 by layer
  RemovedVolume underCut{};  ///< present but not part of the target, m^3 by layer
  double area = 0.0;         ///< of the cut solid's surface in the preparation, m^2
  double mean = 0.0;         ///< of the distance of that surface from the target's, weighted by area, m
  double p95 = 0.0;          ///< 95 % of the area are nearer than this, m
  double deepest = 0.0;      ///< largest distance where too much is removed, m
  double highest = 0.0;      ///< largest distance where too little is removed, m
};

/// Result of compareCut().
struct CutComparison {
  RemovedVolume removed{};  ///< by the cuts, m^3 by layer
  RemovedVolume planned{};  ///< that cuts to the target would remove, m^3 by layer
  CutDifference whole;
  CutDifference floors;          ///< nearest to faces of the target whose normal is within 45 deg of the axis
  CutDifference walls;           ///< nearest to its other faces
  TriangleMesh surface;          ///< of the cut solid, m
  std::vector<double> distance;  ///< of each vertex from the target's surface, m; positive: material should go there
  std::vector<char> isPrepared;  ///< for each vertex: 1 if it is in the preparation
};

/// Compare a cut solid with a target, a closed mesh in the solid's frame. For another solid, pass the mesh of its
/// surfaceOf(). `axis` points out of the tooth (occlusal), of any length. Realtime: no, about a second for a molar.
///
/// Volumes: let o, c and t be the shares of a cell that the uncut solid, the cut one and the target fill, computed as
/// Solid::volume() does. Then over cut is the sum of max(0, min(o, t) - c), and under cut that of max(0, c - min(o,
/// t)). So planned - removed = underCut - overCut, for each layer. Their error is that of surfaces h^2 / (4 R) apart
/// (see Solid), times their area.
///
/// Distances: those of the vertices of surfaceOf(). The preparation is the part of the surface that is farther than a
/// cell from the surface of the uncut solid or from that of the target.
///
/// Throws Error for a target that is not closed, and for an axis that is zero or not finite.
CutComparison compareCut(const Solid& cut, const MeshModel& target, const Vec3& axis = Vec3::UnitZ());

}  // namespace enamel
