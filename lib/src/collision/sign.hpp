// The side of a mesh on which a point lies.
#pragma once

#include <vector>

#include "topology.hpp"

namespace enamel::kernel {

/// Choose how the sign of distances is determined. `edges` as returned by buildTopology().
void chooseSign(MeshData& data, const std::vector<EdgeUse>& edges);

/// Whether p, at `distance` from the mesh, is inside by the winding number. `cache` may be null.
bool isInside(const MeshData& data, const Vec3& p, double distance, Cache* cache) noexcept;

}  // namespace enamel::kernel
