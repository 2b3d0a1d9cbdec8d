// Renderers by name: those that are linked, and plugins.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "enamel/plugin/host.hpp"
#include "enamel/render/hold.hpp"

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

/// Load the gain of an LQR design for ticks of `period` s on a device with `joints` joints.
/// Throws Error: as loadServo(); it was designed for another period or number of joints. Realtime: no.
ServoGain loadGain(const std::string& path, int joints, double period);

/// Make a linked renderer from parameters under the names that the plugins give them, the others at their defaults:
/// delay, delay-high and drive of position-control; gain, release and anti-windup of hold; stiffness and damping of
/// impedance and passivity. Parameters of others are left aside. Throws Error: an unknown name; a value that cannot be
/// read; as loadGain() and the renderers. Realtime: no.
std::unique_ptr<Renderer> makeLinked(const std::string& name, const std::map<std::string, std::string>& parameters,
                                     const std::shared_ptr<const Mechanism>& device, double period);

}  // namespace enamel
