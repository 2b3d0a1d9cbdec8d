// What a person can choose and set.
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

inline constexpr double kPeriod = 1e-3;  // s, of the haptic loop

/// The renderers to choose from: the contact-space servo, the spring, hold, the spring with passivity
/// control around it, and a plugin, where it does not stand for one of these.
enum class RendererSlot : std::uint8_t { positionControl, impedance, hold, passivity, plugin };
inline constexpr std::size_t kLinkedRenderers = 4, kMaxRenderers = 5;

constexpr std::size_t indexOf(RendererSlot slot) noexcept { return static_cast<std::size_t>(slot); }

/// Names of the renderers, slot by slot, as `--renderer` and scripts call them. A plugin (or nullptr) takes the place
/// of the linked renderer of its name, else a place of its own. Realtime: no.
std::vector<std::string> rendererNames(const PluginLibrary* plugin);
RendererSlot slotOf(const PluginLibrary& plugin) noexcept;

/// Everything that a person can set and that needs a new experiment.
struct Settings {
  HoldOptions hold;
  ImpedanceOptions spring;
  double extraMass = 0.0;    ///< on the platform, which no renderer is told of, kg
  double friction = 0.0;     ///< viscous, of every joint, beyond the device file's, N m s/rad
  double toolDamping = 4.0;  ///< mechanical, of the TCP along x, y, z, beyond the device file's, N s/m
  Delay delay;               ///< ticks, at most kMaxLoopDelay
  EncoderOptions encoders{true};
  double noise = 0.0;  ///< of the hand along the contact's normal, standard deviation, N
};

/// The parameters of a device with a person's changes to it.
DeviceParameters changed(DeviceParameters device, const Settings& settings);

}  // namespace enamel::viewer
