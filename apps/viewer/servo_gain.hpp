// The servo gain of a device.
#pragma once

#include <string>

#include "experiment.hpp"

namespace enamel::viewer {

/// Loads a device, without a plugin, and the gain of its position servo: from the file `gain` (loadServo()), or, where
/// that is empty, designed at home for kPeriod with the paper's weights.
/// Throws Error: as loadDevice(), makeMechanism(), loadServo() and designServo(); a gain for another period or another
/// number of joints. Realtime: no.
ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain = "");

}  // namespace enamel::viewer
