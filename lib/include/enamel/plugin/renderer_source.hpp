// Renderers by name: those that are linked, and plugins.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "enamel/plugin/host.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/position_control.hpp"

namespace enamel {

inline constexpr const char* kPositionControl = "position-control";  // PositionControlRenderer
inline constexpr const char* kHold = "hold";                         // HoldRenderer, the paper's controller
inline constexpr const char* kImpedance = "impedance";
inline constexpr const char* kPassivity = "passivity";  // PassivityRenderer around the impedance wall

/// A renderer that a user asked for: a linked one by its name, or a plugin.
struct RendererSource {
  std::string name;                             ///< of the linked one, or as the plugin describes itself
  std::shared_ptr<const PluginLibrary> plugin;  ///< nullptr: linked
};

/// Find a renderer: a linked one by its name, or a plugin by its path or by its name in `pluginFolder`.
/// Throws PluginError: as findPlugin(). Realtime: no.
RendererSource findRenderer(const std::string& nameOrPath, const std::string& pluginFolder);

/// Return which linked renderer a servo file is for: kPositionControl where it is a position-control design, kHold
/// where it is an LQR design. Throws Error: as loadServo(), where it is neither. Realtime: no.
std::string rendererOf(const std::string& gain);

/// Load the gain of an LQR design for ticks of `period` s on a device with `joints` joints.
/// Throws Error: as loadServo(); it was designed for another period or number of joints. Realtime: no.
ServoGain loadGain(const std::string& path, int joints, double period);

/// Return the position control for a device, ticks of `period` s and a delay of the commands of `delayLow` to
/// `delayHigh` ticks: of a file, or where `gain` is "", as positionControlFor() has it. Throws Error: as
/// loadPositionControl() and PositionControlRenderer; the file is for another period, number of joints or delay.
/// Realtime: no.
PositionControlOptions positionControlOptions(const std::string& gain, const Mechanism& mechanism, double period,
                                              int delayLow, int delayHigh);

/// Make a linked renderer from parameters under the names that the plugins give them, the others at their defaults:
/// gain, delay and delay-high of position-control; gain, release and anti-windup of hold; stiffness and damping of
/// impedance and passivity. Parameters of others are left aside. Throws Error: an unknown name; a value that cannot be
/// read; as positionControlOptions(), loadGain() and the renderers. Realtime: no.
std::unique_ptr<Renderer> makeLinked(const std::string& name, const std::map<std::string, std::string>& parameters,
                                     const std::shared_ptr<const Mechanism>& device, double period);

}  // namespace enamel
