// Makes a scene from a scan.
#pragma once

#include <string>

#include "enamel/collision/scene_file.hpp"

namespace enamel::viewer {

/// Return whether the extension is that of a mesh: .ply, .obj, .stl or .off, in upper or lower case.
bool isScan(const std::string& path);

/// Make a scene with one obstacle, "scan": the mesh of a file in its own orientation (z up, towards the person). Its
/// highest point is 4 mm below the middle of the workspace. A tool with a ball of 1.2 mm starts 12 mm above it. The
/// size gives the unit: mm if the longest side is 2 to 500 units, m if it is smaller, um if it is larger. The first of
/// `notes` names the unit and the kind of mesh (describe()). Throws ConfigurationError: as loadMesh(); Error: as
/// checkMesh(), and if no unit gives 2 to 500 mm. Realtime: no.
SceneFile sceneOfScan(const std::string& path);

}  // namespace enamel::viewer
