// `enamel design --stability`: errors of a device at which the linear closed loop of position control is stable.
#pragma once

#include <string>

#include "enamel/device/device_file.hpp"

namespace enamel::app {

/// Print the ranges of single errors for delays of 0 to `largestDelay` ticks, and write maps of pairs of errors (SVG).
/// The result does not depend on `threads`. Throws Error as LinearLoop and writeFile().
void writeStability(const DeviceParameters& device, double period, int largestDelay, int threads,
                    const std::string& path);

}  // namespace enamel::app
