// A scene made from somebody's scan.
#pragma once

#include <string>

#include "enamel/collision/scene_file.hpp"

namespace enamel::viewer {

/// Whether a file's name ends as that of a mesh: .ply, .obj, .stl or .off, in any case.
bool isScan(const std::string& path);

/// A scene whose one obstacle, "scan", is the mesh of a file, in its own orientation (z up, towards the person), with
/// its highest point 4 mm below the middle of the workspace; a tool with a ball of 1.2 mm begins 12 mm above it. The
/// unit is taken from the size: mm where the longest side is 2 to 500 units, else m (less) or um (more); the first of
/// `notes` says which, and what the mesh is (describe()). Throws ConfigurationError: as loadMesh(); Error: as
/// checkMesh(), and for a size that no unit makes 2 to 500 mm. Realtime: no.
SceneFile sceneOfScan(const std::string& path);

}  // namespace enamel::viewer
