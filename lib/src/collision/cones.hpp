// Cones of normals: in which directions from the surface a local minimum of the distance can lie.
#pragma once

#include <vector>

#include "topology.hpp"

namespace enamel::kernel {

/// Writes the cones of all triangles, leaves and nodes.
void buildCones(MeshData& data, const std::vector<EdgeUse>& edges, const std::vector<Vec3>& normal);

/// Gives up what is known of the normals below a child of a node, and so of the nodes above.
void openCones(MeshData& data, Parent at);

}  // namespace enamel::kernel
