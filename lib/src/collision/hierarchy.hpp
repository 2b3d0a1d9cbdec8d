// The hierarchy of a mesh.
#pragma once

#include "mesh_data.hpp"

namespace enamel::kernel {

/// Builds the hierarchy over all triangles of data.mesh.
void buildHierarchy(MeshData& data);

/// Writes one slot of a leaf from the mesh's vertices.
void writeSlot(MeshData& data, std::int32_t slot, std::int32_t triangle);

/// Marks a slot as unused.
void clearSlot(MeshData& data, std::int32_t slot);

/// A number that no other state of any mesh has.
std::uint64_t nextRevision() noexcept;

}  // namespace enamel::kernel
