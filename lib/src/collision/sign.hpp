// On which side of a mesh a point lies.
#pragma once

#include <vector>

#include "topology.hpp"

namespace enamel::kernel {

/// Finds out how the sign of distances is told: `edges` as buildTopology() answers them.
void chooseSign(MeshData& data, const std::vector<EdgeUse>& edges);

/// Whether p, `distance` away from the mesh, is inside by the winding number. `cache` may be null.
bool isInside(const MeshData& data, const Vec3& p, double distance, Cache* cache) noexcept;

}  // namespace enamel::kernel
