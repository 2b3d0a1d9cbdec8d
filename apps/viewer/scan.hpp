// Makes a scene from a scan.
#pragma once

#include <string>
#include <vector>

#include "enamel/core/types.hpp"

namespace enamel::viewer {

/// Return whether the extension is that of a mesh: .ply, .obj, .stl or .off, in upper or lower case. The next function
/// returns whether it is that of a recording: .rec.
bool isScan(const std::string& path);
bool isRecording(const std::string& path);

/// How a person places a scan.
struct ScanPlacement {
  Mat3 turn = Mat3::Identity();  ///< after the orientation that sceneOfScan() finds
  std::string unit;              ///< mm, m or um; empty: guessed
};

struct ScanScene {
  std::string text;  ///< scene file (TOML) that names the mesh by its absolute path
  std::string note;  ///< size, unit and kind of the surface, in words
};

/// Make a scene with one obstacle, "scan": the mesh of a file, with its occlusal side towards the person (z). A scan
/// that is open at one side faces away from it, and its flattest axis becomes z if that differs by less than 30 deg. A
/// closed mesh keeps its z. The highest point is 4 mm below the middle of the workspace. A tool with a ball of 1.2 mm
/// starts 12 mm above it. The size gives the unit: mm if the longest side is 2 to 500 units, m if it is smaller, um if
/// it is larger. Throws ConfigurationError: as loadMesh(); Error: if the longest side is not 2 to 500 mm. Realtime: no.
ScanScene sceneOfScan(const std::string& path, const ScanPlacement& placement = {});

}  // namespace enamel::viewer
