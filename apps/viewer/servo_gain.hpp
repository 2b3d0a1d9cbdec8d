// The servos of a device.
#pragma once

#include <string>

#include "experiment.hpp"

namespace enamel::viewer {

/// Loads a device, without a plugin, and its servos. The file `gain`, where it is not empty, is of position control
/// (loadSurfaceServo()) or of hold (loadServo()). What it does not give is chosen as usual: surfaceServoFor(), and for
/// hold a design at home for kPeriod with the paper's weights.
/// Throws Error: as loadDevice(), makeMechanism(), designServo() and the loaders; a file for another period, another
/// number of joints or other encoders. Realtime: no.
ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain = "");

}  // namespace enamel::viewer
