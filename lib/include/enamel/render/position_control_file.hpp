// A design of position control as a file: what `enamel design --surface --output` writes and `--gain` reads.
#pragma once

#include <string>

#include "enamel/render/position_control.hpp"

namespace enamel {

/// A file's content.
struct PositionControlFile {
  std::string model;  ///< name of the device that it was designed for
  PositionControlOptions options;
};

/// Reads a design (JSON: "kind": "surface", "model", "period" in s, "count", a list, one a joint, "delay", the smallest
/// and the largest in ticks, "horizon" in ticks, and every name of positionControlParameters(); other keys are
/// ignored). Throws ConfigurationError: the file cannot be read or is not JSON; a key is missing or of the wrong type;
/// a value that PositionControlRenderer refuses. Realtime: no.
PositionControlFile loadPositionControl(const std::string& path);

/// The file's text. Realtime: no.
std::string positionControlText(const PositionControlFile& file);

/// Whether a file is one of these, by its "kind"; false where it cannot be read. Realtime: no.
bool isPositionControlFile(const std::string& path);

}  // namespace enamel
