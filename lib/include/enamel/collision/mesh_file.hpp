// Strict readers of mesh files: PLY (text and binary), OBJ, STL (text and binary) and OFF (text).
#pragma once

#include <string>
#include <string_view>

#include "enamel/collision/mesh.hpp"

namespace enamel {

/// Read a mesh file. The extension .ply, .obj, .stl or .off determines the format. Realtime: no. Threads: safe.
///
/// Coordinates are multiplied by `scale` (m per unit of the file), in double. Polygons become fans of triangles. Only
/// positions and faces are read. Faces without area or with a repeated corner are kept.
///
/// Throws ConfigurationError with the file and the number of the vertex, face or line for:
/// - a file that cannot be opened, is larger than 2 GiB, or is not a regular file;
/// - an unknown format, or a truncated file;
/// - a header with larger counts than the file has room for (checked before memory is allocated);
/// - a coordinate that is not finite or above 1e9 m;
/// - an index out of range;
/// - a face with fewer than 3 or more than 255 corners;
/// - no faces, more than one triangle for every 6 bytes, or more than 2^27 triangles;
/// - a scale that is not positive and finite.
TriangleMesh loadMesh(const std::string& path, double scale = 1.0);

/// Read a mesh from bytes in memory, as loadMesh(). `path` determines the format and appears in messages.
TriangleMesh parseMesh(std::string_view bytes, const std::string& path, double scale = 1.0);

}  // namespace enamel
