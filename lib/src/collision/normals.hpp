// Normals of triangles, and their sums around edges and corners, which tell the sign of a distance.
#pragma once

#include <vector>

#include "topology.hpp"

namespace enamel::kernel {

/// Unit normal of a triangle, or zero if it is lower than 1e-12 of its longest edge.
Vec3 unitNormal(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

/// Angle at corner a between the directions to b and c, rad; 0 where one of them has no length.
double cornerAngle(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

/// unitNormal() of all triangles.
std::vector<Vec3> unitNormals(const TriangleMesh& mesh);

/// Sums the normals around all edges and places.
void sumNormals(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal);

}  // namespace enamel::kernel
