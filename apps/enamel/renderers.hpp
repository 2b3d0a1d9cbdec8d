// The renderers by name, and what the commands that push share about them.
#pragma once

#include <memory>
#include <string>

#include "enamel/control/device_plant.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::app {

inline constexpr const char* kPositionControl = "position-control";
inline constexpr const char* kImpedance = "impedance";

/// "none", "constant:D" or "random:A..B", in ticks, whole numbers in decimal digits. Throws Error.
Delay parseDelay(const std::string& text);

/// A renderer that a user asked for: a linked one by its name, or a plugin by its path or by its name in
/// pluginFolder().
struct RendererSource {
  std::string name;                             ///< of the linked one, or as the plugin describes itself
  std::shared_ptr<const PluginLibrary> plugin;  ///< nullptr: linked
};

/// Throws PluginError: as findPlugin().
RendererSource findRenderer(const std::string& nameOrPath);

/// The gain of a servo file (--gain) for ticks of `period` s on a device with `joints` joints.
/// Throws Error: as loadServo(); it was designed for another period or number of joints.
ServoGain loadGain(const std::string& path, int joints, double period);

/// Mechanical damping of a plant along `normal` (unit, W) at a pose, N s/m: of the TCP and of the joints.
/// Throws Error: the pose cannot be reached.
double dampingAlong(const Mechanism& plant, const Pose& pose, const Vec3& normal);

/// What to print where eq. 16 is not met; empty where it is.
std::string dampingWarning(const ImpedanceOptions& wall, double period, double available);

}  // namespace enamel::app
