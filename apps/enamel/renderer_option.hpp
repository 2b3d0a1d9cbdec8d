// Renderer options shared by the commands that push: --delay, --gain, --device-damping.
#pragma once

#include <string>
#include <vector>

#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel::app {

/// Parse "none", "constant:D" or "random:A..B": whole numbers of ticks in decimal digits. Throws Error.
Delay parseDelay(const std::string& text);

/// Check the servo file of --gain ("": no file). Throws Error: as loadServo(); hold is not among the `linked` renderers
/// of `option`.
void checkGain(const std::string& gain, const std::vector<std::string>& linked, const std::string& option);

/// Return the mechanical damping of a plant along `normal` (unit vector, frame W) at a pose, N s/m: of the TCP and of
/// the joints. Throws Error: the pose cannot be reached.
double dampingAlong(const Mechanism& plant, const Pose& pose, const Vec3& normal);

/// Return the warning to print if eq. 16 is violated; empty if it holds.
std::string dampingWarning(const ImpedanceOptions& wall, double period, double available);

}  // namespace enamel::app
