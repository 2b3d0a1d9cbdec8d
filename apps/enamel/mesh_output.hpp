// Files of meshes that a command writes: binary PLY or STL, in mm.
#pragma once

#include <string>
#include <vector>

#include "enamel/collision/mesh.hpp"

namespace enamel::app {

/// Throw Error unless the extension of a file name is .ply, .stl or empty (PLY).
void checkMeshOutput(const std::string& path);

/// Write a mesh. `colours`: red, green and blue of each vertex, 0 to 1; PLY only; may be empty. Throws Error with the
/// file and the cause.
void writeMesh(const TriangleMesh& mesh, const std::string& path, const std::vector<Vec3>& colours = {});

}  // namespace enamel::app
