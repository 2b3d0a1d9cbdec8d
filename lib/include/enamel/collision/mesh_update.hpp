// Local changes of a mesh that is in use: a surface that gives way, a tooth that is drilled. The work depends on how
// much changes, not on the size of the mesh, and the answers are those of a new model built from the changed mesh
// (triangles keep their numbers; removed ones are never reported).
//
// Common to all: nothing is changed unless the answer is ok. outOfRange: the mesh has no such number or a count is
// negative. Not while other threads query the model. Realtime: yes (no allocation; work for the triangles at the
// vertices and the levels above them).
#pragma once

#include <array>

#include "enamel/collision/proximity.hpp"

namespace enamel {

/// Moves vertices: positions[i] is the new place of vertices[i], m. All triangles at these vertices follow, their boxes
/// and normals too. Moved vertices keep their connections: two at one place move together only if both are named.
/// notFinite: a position is not finite. outOfRange also where a position is farther from the mesh's centre, along an
/// axis, than 8 to 16 times half its size when it was built.
[[nodiscard]] Status moveVertices(MeshModel& model, const int* vertices, const Vec3* positions, int count) noexcept;

/// Adds vertices; they are numbered on from mesh().vertices.size(). Each is connected to nothing, also where it lies at
/// the place of another. Errors as moveVertices(); outOfRange also where there is no room for all of them.
[[nodiscard]] Status addVertices(MeshModel& model, const Vec3* positions, int count) noexcept;

/// Adds triangles between vertices; they are numbered on from mesh().triangles.size(). outOfRange also where there is
/// no room for all of them, or a vertex lies too far away, as for moveVertices().
[[nodiscard]] Status addTriangles(MeshModel& model, const std::array<int, 3>* corners, int count) noexcept;

/// Removes triangles; those removed before are skipped. Their numbers are not given to others.
[[nodiscard]] Status removeTriangles(MeshModel& model, const int* triangles, int count) noexcept;

/// Gives triangles other corners (indices of vertices), also triangles that were removed: the surface of a cavity
/// takes the place of what a drill cut away. outOfRange also where a vertex lies too far away, as for moveVertices().
[[nodiscard]] Status replaceTriangles(MeshModel& model, const int* triangles, const std::array<int, 3>* corners,
                                      int count) noexcept;

/// Room that is left for addVertices() and addTriangles(): what the model was built with, less what was added.
SpareCapacity spareCapacity(const MeshModel& model) noexcept;

/// Whether a triangle is there (not removed).
bool isPresent(const MeshModel& model, int triangle) noexcept;

}  // namespace enamel
