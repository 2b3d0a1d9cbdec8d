// The servo gain of a device.
#pragma once

#include <string>

#include "experiment.hpp"

namespace enamel::viewer {

/// Loads a device, without a plugin, and designs its position servo at home for kPeriod, with the paper's weights.
/// Throws Error: as loadTau(), makeModel() and designServo(). Realtime: no.
ServoedDevice loadServoedDevice(const std::string& path);

}  // namespace enamel::viewer
