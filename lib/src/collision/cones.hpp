// Cones of normals: the directions from the surface in which a local minimum of the distance can lie.
#pragma once

#include <vector>

#include "topology.hpp"

namespace enamel::kernel {

/// Write the cones of all triangles, leaves and nodes.
void buildCones(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal);

/// Discard the cone of a child of a node, and so those of the nodes above.
void openCones(MeshData& data, Parent at);

}  // namespace enamel::kernel
