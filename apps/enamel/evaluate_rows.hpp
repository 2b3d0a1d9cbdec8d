// The rows of `enamel evaluate`: kinematics and dynamics of the TAU, JSON in, JSON out.
#pragma once

#include <string>

namespace enamel::app {

/// Throws Error: a file cannot be read or written, or is not a list of rows; the device is not a TAU.
void evaluateRows(const std::string& devicePath, const std::string& inputPath, const std::string& outputPath);

}  // namespace enamel::app
