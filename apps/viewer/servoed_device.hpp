// A device with its servos.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "enamel/render/position_control.hpp"
#include "settings.hpp"

namespace enamel::viewer {

/// A device with its servos for kPeriod, and a plugin.
struct ServoedDevice {
  DeviceParameters parameters;
  ServoGain gain;                                 ///< of hold
  std::optional<PositionControlOptions> surface;  ///< of position control, from a file; else positionControlFor()
  std::shared_ptr<const PluginLibrary> plugin;    ///< or nullptr
  PluginSetup pluginSetup;
};

/// What position control is made with under a delay, ticks: the file's options where the delay is the file's; else its
/// numbers with this delay. Throws Error: as positionControlFor(). Realtime: no.
PositionControlOptions positionControlOptions(const ServoedDevice& device, const Mechanism& model, const Delay& delay);

/// Loads a device, without a plugin, and its servos. The file `gain`, where it is not empty, is of position control
/// (loadPositionControl()) or of hold (loadServo()). What it does not give is chosen as usual: positionControlFor(),
/// and for hold a design at home for kPeriod with the paper's weights. Throws Error: as loadDevice(), makeMechanism(),
/// designServo() and the loaders; a file for another period, another number of joints or other encoders. Realtime: no.
ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain = "");

}  // namespace enamel::viewer
