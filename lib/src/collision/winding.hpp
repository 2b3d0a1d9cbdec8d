// The generalised winding number: how often a mesh, closed or not, goes round a point.
#pragma once

#include "mesh_data.hpp"

namespace enamel::kernel {

/// Sums over all triangles, from nothing but the hierarchy and its boxes.
void buildWinding(MeshData& data);

/// Makes the sums hold again what is in a leaf; its boxes must do so already.
void refitWinding(MeshData& data, std::int32_t leaf);

struct Winding {
  double number;  ///< 1 inside of a closed surface whose triangles run counterclockwise seen from outside, 0 outside
  double slope;   ///< bound of its gradient at p, 1/m; 64 / 27 of it bounds the gradient within a quarter of the distance
};

/// w = 1 / (4 pi) of the solid angles of all triangles (Jacobson, Kavan & Sorkine-Hornung, "Robust inside-outside
/// segmentation using generalized winding numbers", 2013). Triangles that are farther away than `accept` times the
/// radius of their cluster count by its dipole and the first moments of its normals (Barill et al., "Fast winding
/// numbers for soups and clouds", 2018), the others exactly. `distance` of p from the mesh, m. Largest error seen:
/// 0.022 at 2, 5e-4 at 8. Realtime: yes.
Winding windingNumber(const MeshData& data, const Vec3& p, double distance, double accept) noexcept;

}  // namespace enamel::kernel
