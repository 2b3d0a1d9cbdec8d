// Local changes of a mesh in use, such as a surface that deforms or a tooth that is drilled. The work depends on the
// size of the change, not on the size of the mesh. Queries then return the same as with a new model of the changed
// mesh. Triangles keep their numbers, and queries never report removed ones.
//
// Common to all functions:
// - A status other than ok means that nothing was changed.
// - outOfRange: the mesh has no such number, or a count is negative.
// - No other thread may query the model during a change.
// - Realtime: yes (no allocation; work for the triangles at the vertices and the levels above them).
#pragma once

#include <array>

#include "enamel/collision/proximity.hpp"

namespace enamel {

/// Move vertices: positions[i] is the new position of vertices[i], m. All triangles at these vertices follow, with
/// their boxes and normals. Vertices keep their connections: two at one place move together only if both are named.
/// Statuses: notFinite (a position); outOfRange, also if a position is too far away. The limit is the distance from the
/// mesh's centre along an axis: 8 to 16 times half the mesh's size when the model was built.
[[nodiscard]] Status moveVertices(MeshModel& model, const int* vertices, const Vec3* positions, int count) noexcept;

/// Add vertices; their numbers start at mesh().vertices.size(). A new vertex is connected to nothing, even at the place
/// of another one. Statuses as moveVertices(); outOfRange also if there is not enough room for all.
[[nodiscard]] Status addVertices(MeshModel& model, const Vec3* positions, int count) noexcept;

/// Add triangles between vertices; their numbers start at mesh().triangles.size(). outOfRange also if there is not
/// enough room for all, or if a vertex is too far away (moveVertices()).
[[nodiscard]] Status addTriangles(MeshModel& model, const std::array<int, 3>* corners, int count) noexcept;

/// Remove triangles; skip those that are already removed. Their numbers are not reused for new triangles.
[[nodiscard]] Status removeTriangles(MeshModel& model, const int* triangles, int count) noexcept;

/// Give triangles other corners (indices of vertices), also triangles that were removed. Use it to replace the material
/// that a drill removed by the surface of the cavity. outOfRange also if a vertex is too far away (moveVertices()).
[[nodiscard]] Status replaceTriangles(MeshModel& model, const int* triangles, const std::array<int, 3>* corners,
                                      int count) noexcept;

/// Return the remaining room for addVertices() and addTriangles(): the spare capacity of the model minus additions.
SpareCapacity spareCapacity(const MeshModel& model) noexcept;

/// Return true if a triangle exists and was not removed.
bool isPresent(const MeshModel& model, int triangle) noexcept;

}  // namespace enamel
