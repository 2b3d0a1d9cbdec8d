// The hierarchy of a mesh.
#pragma once

#include "mesh_data.hpp"

namespace enamel::kernel {

/// Build the hierarchy over all triangles of data.mesh, with room for `spare` others, spread evenly among them.
void buildHierarchy(MeshData& data, int spare);

/// Write one slot of a leaf from the vertices of the mesh.
void writeSlot(MeshData& data, std::int32_t slot, std::int32_t triangle);

/// Mark a slot as unused.
void clearSlot(MeshData& data, std::int32_t slot);

/// Change the number of free slots of a leaf.
void countFree(MeshData& data, std::int32_t leaf, int change) noexcept;

/// Return a number that no other state of any mesh has.
std::uint64_t nextRevision() noexcept;

}  // namespace enamel::kernel
