// Local changes of a mesh that is in use: a surface that gives way, a tooth that is drilled. The work depends on how
// much changes, not on the size of the mesh, and the answers are those of a model built anew from the changed mesh
// (triangles keep their numbers; removed ones are never reported).
#pragma once

#include <array>

#include "enamel/collision/proximity.hpp"

namespace enamel {

/// Moves vertices: positions[i] is the new place of vertices[i], m. All triangles at these vertices follow, their boxes
/// and normals too. Moved vertices keep their connections: two at one place move together only if both are named.
/// notFinite: a position is not finite. outOfRange: an index is none of the mesh's, or a position is farther from the
/// mesh's centre, along an axis, than 8 to 16 times half its size when it was built. Nothing is changed then.
/// Realtime: yes (no allocation; work for the triangles at the vertices and the levels above them). Not while other
/// threads query the model.
Status moveVertices(MeshModel& model, const int* vertices, const Vec3* positions, int count) noexcept;

/// Removes triangles; those removed before are skipped. outOfRange: a number is none of the mesh's; nothing is changed
/// then. Realtime: yes, as moveVertices().
Status removeTriangles(MeshModel& model, const int* triangles, int count) noexcept;

/// Gives triangles other corners (indices of vertices), also triangles that were removed: the surface of a cavity
/// takes the place of what a drill cut away. outOfRange: a number or index is none of the mesh's, or a vertex lies too
/// far away, as for moveVertices(); nothing is changed then. Realtime: yes, as moveVertices(); a cavity far from the
/// triangle's old place loosens the boxes around it.
Status replaceTriangles(MeshModel& model, const int* triangles, const std::array<int, 3>* corners, int count) noexcept;

/// Whether a triangle is there (not removed). Realtime: yes.
bool isPresent(const MeshModel& model, int triangle) noexcept;

}  // namespace enamel
