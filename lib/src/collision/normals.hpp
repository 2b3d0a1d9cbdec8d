// Normals of triangles, and their sums around edges and corners, which give the sign of a distance.
#pragma once

#include <vector>

#include "topology.hpp"

namespace enamel::kernel {

/// Return the unit normal of a triangle, or zero if its height is below 1e-12 of its longest edge.
Vec3 unitNormal(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

/// Return the angle at corner a between the directions to b and c, rad; 0 if one of them has no length.
double cornerAngle(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

/// Return unitNormal() of all triangles.
std::vector<Vec3> unitNormals(const TriangleMesh& mesh);

/// Return the sum of the unit normals of all triangles at an edge of this one, or around a corner. Around a corner each
/// counts by its angle (Baerentzen & Aanaes 2005). Computed on demand: cones decide most signs, and storing all sums
/// would take 52 bytes per triangle. Realtime: yes.
Vec3 normalAround(const MeshData& data, std::int32_t triangle, std::int32_t feature) noexcept;

/// Mark the edges and corners at a triangle without a normal, where these sums do not give the side.
void markWithoutNormal(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal);

}  // namespace enamel::kernel
