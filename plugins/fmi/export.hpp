// Writes units.
#pragma once

#include <string>

#include "description.hpp"

namespace enamel::fmi {

struct ExportSetup {
  UnitConfiguration unit;
  std::string deviceFile, sceneFile;  ///< sceneFile: of a renderer; empty: the wall z = 0 and a point
  std::string binary;                 ///< library to include in the unit
};

/// Return the text of a unit's modelDescription.xml, made from variablesOf().
std::string modelDescription(const UnitConfiguration& unit, const Mechanism& device, const std::string& token);

/// Write a unit (*.fmu). Throws Error: as makeMechanism(), loadScene() and the renderer; a file cannot be read or
/// written.
void writeUnit(const std::string& path, const ExportSetup& setup);

/// Return the folder of this machine's binaries inside a unit: "x86_64-linux".
std::string platformTuple();

}  // namespace enamel::fmi
