// Renderers by name: linked ones and plugins.
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

/// A renderer that a user selected: a linked one, or a plugin.
struct RendererSource {
  std::string name;                             ///< of the linked one, or from the plugin's description
  std::shared_ptr<const PluginLibrary> plugin;  ///< nullptr: linked
};

/// Find a linked renderer by its name, or a plugin by its path or by its name in `pluginFolder`. Throws PluginError as
/// findPlugin(). Realtime: no.
RendererSource findRenderer(const std::string& nameOrPath, const std::string& pluginFolder);

/// Throw Error if a linked renderer does not know one of the parameters. The message lists those that it knows.
/// Realtime: no.
void requireKnown(const std::string& name, const std::map<std::string, std::string>& parameters);

/// Load the gain of an LQR design for ticks of `period` s on a device with `joints` joints. Throws Error as
/// loadServo(), and if it was designed for another period or number of joints. Realtime: no.
ServoGain loadGain(const std::string& path, int joints, double period);

/// Make a linked renderer from parameters. They have the same names as in plugins:
///
/// - position-control: delay, delay-high, drive;
/// - hold: gain, release, anti-windup;
/// - impedance, passivity: stiffness, damping.
///
/// Missing parameters have their defaults. Parameters of other renderers are ignored. Throws Error if the name is
/// unknown or a value cannot be read. Also throws as loadGain() and the renderers. Realtime: no.
std::unique_ptr<Renderer> makeLinked(const std::string& name, const std::map<std::string, std::string>& parameters,
                                     const std::shared_ptr<const Mechanism>& device, double period);

}  // namespace enamel
