// Writes units.
#pragma once

#include <string>

#include "description.hpp"

namespace enamel::fmi {

struct ExportSetup {
  UnitConfiguration unit;
  std::string deviceFile, sceneFile;  ///< scene: of a renderer; empty: the wall z = 0 and a point
  std::string binary;                 ///< the library that the unit holds
};

/// modelDescription.xml of a unit, from variablesOf().
std::string modelDescription(const UnitConfiguration& unit, const Mechanism& device, const std::string& token);

/// Writes a unit (*.fmu). Throws Error: as makeMechanism(), loadScene() and the renderer; a file that cannot be read or
/// written.
void writeUnit(const std::string& path, const ExportSetup& setup);

/// The folder of binaries in units for this machine: "x86_64-linux".
std::string platformTuple();

}  // namespace enamel::fmi
