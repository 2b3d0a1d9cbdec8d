// What the commands that push share about the options of renderers: --delay, --gain, --device-damping.
#pragma once

#include <string>
#include <vector>

#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel::app {

/// "none", "constant:D" or "random:A..B", in ticks, whole numbers in decimal digits. Throws Error.
Delay parseDelay(const std::string& text);

/// Throws Error: as loadServo(); a servo file (or "": none) where hold is not among the `linked` renderers of `option`.
void checkGain(const std::string& gain, const std::vector<std::string>& linked, const std::string& option);

/// Mechanical damping of a plant along `normal` (unit, W) at a pose, N s/m: of the TCP and of the joints.
/// Throws Error: the pose cannot be reached.
double dampingAlong(const Mechanism& plant, const Pose& pose, const Vec3& normal);

/// What to print where eq. 16 is not met; empty where it is.
std::string dampingWarning(const ImpedanceOptions& wall, double period, double available);

}  // namespace enamel::app
