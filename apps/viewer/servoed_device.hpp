// A device with the servo of hold.
#pragma once

#include <memory>
#include <string>

#include "settings.hpp"

namespace enamel::viewer {

/// A device with the servo of hold for kPeriod, and a plugin.
struct ServoedDevice {
  DeviceParameters parameters;
  ServoGain gain;                               ///< of hold
  std::shared_ptr<const PluginLibrary> plugin;  ///< may be nullptr
  PluginSetup pluginSetup;
};

/// Load a device without a plugin, and the servo of hold from the file `gain`. If `gain` is empty, design it at home
/// for kPeriod with the paper's weights. Throws Error: as loadDevice(), makeMechanism(), designServo() and loadServo();
/// a file for another period or another number of joints. Realtime: no.
ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain = "");

}  // namespace enamel::viewer
