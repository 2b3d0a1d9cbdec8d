// Settings of a person.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/sim/virtual_loop.hpp"

namespace enamel::viewer {

inline constexpr double kPeriod = 1e-3;  // s, period of the haptic loop

/// Renderers to choose from: position control, spring, hold, spring with passivity control, and a plugin that does not
/// replace one of these.
enum class RendererSlot : std::uint8_t { positionControl, impedance, hold, passivity, plugin };
inline constexpr std::size_t kLinkedRenderers = 4, kMaxRenderers = 5;

constexpr std::size_t indexOf(RendererSlot slot) noexcept { return static_cast<std::size_t>(slot); }

/// Return the names of the renderers by slot, as in `--renderer` and scripts. A plugin (or nullptr) replaces the linked
/// renderer of the same name, or else gets its own slot. Realtime: no.
std::vector<std::string> rendererNames(const PluginLibrary* plugin);
RendererSlot slotOf(const PluginLibrary& plugin) noexcept;

/// Settings whose change needs a new experiment.
struct Settings {
  HoldOptions hold;
  ImpedanceOptions spring;
  double extraMass = 0.0;    ///< of the platform, unknown to the renderers, kg
  double friction = 0.0;     ///< viscous, of every joint, in addition to the device file's, N m s/rad
  double toolDamping = 4.0;  ///< mechanical damping of the TCP along x, y, z, in addition to the device file's, N s/m
  Delay delay;               ///< ticks, at most kMaxLoopDelay
  EncoderOptions encoders{true};
  double noise = 0.0;  ///< standard deviation of the hand's force along the contact's normal, N
};

/// Return the parameters of a device with a person's changes.
DeviceParameters changed(DeviceParameters device, const Settings& settings);

}  // namespace enamel::viewer
