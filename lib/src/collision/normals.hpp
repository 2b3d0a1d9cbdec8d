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

/// Sum of the unit normals of all triangles at an edge of this one, or around a corner, each there times its angle
/// (Baerentzen & Aanaes 2005). Made when it is asked for, which is seldom: cones decide most signs, and 52 bytes a
/// triangle would be what all sums take. Realtime: yes.
Vec3 normalAround(const MeshData& data, std::int32_t triangle, std::int32_t feature) noexcept;

/// Marks the edges and corners where a triangle has no normal, for which these sums do not tell the side.
void markWithoutNormal(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal);

}  // namespace enamel::kernel
