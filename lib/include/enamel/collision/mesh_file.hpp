// Mesh files: PLY (text and binary), OBJ, STL (text and binary) and OFF (text), read strictly.
#pragma once

#include <string>
#include <string_view>

#include "enamel/collision/mesh.hpp"

namespace enamel {

/// Reads a mesh file; the format follows from the extension .ply, .obj, .stl or .off. Coordinates are multiplied by
/// `scale` (m per unit of the file), in double. Polygons become fans of triangles. Every face of the file is kept, also
/// those without area or with a repeated corner; only positions and faces are read.
/// Throws ConfigurationError with the file and the number of the vertex, face or line: file that cannot be opened or is
/// larger than 2 GiB or no plain file, unknown format, header that promises more than the file has room for (found
/// before memory is spent on it), truncated file, coordinate that is not finite or beyond 1e9 m, index out of range,
/// face with fewer than 3 or more than 255 corners, more than one triangle for every 6 bytes, no faces at all.
/// Realtime: no. Threads: safe.
TriangleMesh loadMesh(const std::string& path, double scale = 1.0);

/// loadMesh() on bytes in memory; `path` gives the format and stands in messages.
TriangleMesh parseMesh(std::string_view bytes, const std::string& path, double scale = 1.0);

}  // namespace enamel
