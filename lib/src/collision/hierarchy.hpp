// The hierarchy of a mesh.
#pragma once

#include "mesh_data.hpp"

namespace enamel::kernel {

/// Builds the hierarchy over all triangles of data.mesh, with room for `spare` others, close to all of them alike.
void buildHierarchy(MeshData& data, int spare);

/// Writes one slot of a leaf from the mesh's vertices.
void writeSlot(MeshData& data, std::int32_t slot, std::int32_t triangle);

/// Marks a slot as unused.
void clearSlot(MeshData& data, std::int32_t slot);

/// A leaf has so many free slots more.
void countFree(MeshData& data, std::int32_t leaf, int change) noexcept;

/// A number that no other state of any mesh has.
std::uint64_t nextRevision() noexcept;

}  // namespace enamel::kernel
