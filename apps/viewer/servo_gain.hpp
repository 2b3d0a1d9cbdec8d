// The servo gain of a device.
#pragma once

#include <string>

#include "experiment.hpp"

namespace enamel::viewer {

/// Loads a device and the gain of its position servo at kPeriod. Throws Error. Realtime: no.
ServoedDevice loadServoedDevice(const std::string& path);

}  // namespace enamel::viewer
