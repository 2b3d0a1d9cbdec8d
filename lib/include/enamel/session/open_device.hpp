// Devices by URL: one string for the tool, sessions, C and Python.
//
//   virtual:FILE                            a simulated device of a device file; without FILE, the nominal TAU.
//   udp://HOST:PORT?device=FILE&key=FILE    a driver in another process, language or machine (lib/docs/device.md).
//   NAME://ADDRESS?device=FILE              a driver plugin with this name (plugin/driver.h).
//
// The option delay=N or delay=LOW..HIGH replaces the delay that the driver states, in ticks.
// Text after "?" gives options. All texts are taken as they are: "%20" is not a space.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enamel/device/haptic_device.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/sim/simulated_device.hpp"

namespace enamel {

/// The parts of a URL: scheme:address?key=value&key=value, or scheme://address.
struct DeviceUrl {
  std::string text;  ///< the whole URL, for messages
  std::string scheme, address;
  std::map<std::string, std::string> options;
};

inline constexpr const char* kVirtualScheme = "virtual";

/// Return whether a text is a URL of a device, not the path of a file: two or more small letters, digits or "-", then
/// ":". Realtime: no.
bool isDeviceUrl(const std::string& text) noexcept;

/// Split a URL. Throws Error with the URL if it has no scheme, or an option without "=" or given twice. Realtime: no.
DeviceUrl parseDeviceUrl(const std::string& text);

struct OpenDeviceOptions {
  double period = 1e-3;       ///< of the ticks, s
  std::optional<Pose> start;  ///< where a virtual device begins, at rest; empty: home
  WrenchFunction hand;        ///< that holds a virtual device; empty: pressingHand()
  std::string pluginFolder;   ///< where drivers are searched by name
};

/// An open device and what a loop must know about it.
struct OpenedDevice {
  std::string file;   ///< path of its device file; empty: the file is built in
  std::string text;   ///< content of its device file (TOML)
  std::string facts;  ///< about this device, for reports: one line of its driver, or empty
  std::shared_ptr<const Mechanism> mechanism;
  Delay delay;        ///< of its commands, ticks: for the renderer
  double poll = 0.0;  ///< s, for HapticLoopOptions::period: four times a tick if the device has its own clock, else 0
  std::unique_ptr<HapticDevice> device;
};

/// Open a device. A virtual device has the encoders of its file, and moves in real time. Realtime: no.
/// Throws Error with the URL and the cause:
/// - an unknown scheme or option; the message lists the possible ones;
/// - a delay that is not N or LOW..HIGH in 0 to kMaxDelay ticks;
/// - a device file that cannot be read, or has another number of joints than that of the driver;
/// - a device that cannot be connected, or does not answer within 1 s.
OpenedDevice openDevice(const std::string& url, const OpenDeviceOptions& options = {});

/// A form of URLs that is built in.
struct DeviceForm {
  std::string form, summary;
};

/// Return the forms of URLs that need no driver. Realtime: no.
std::vector<DeviceForm> builtInDevices();

}  // namespace enamel
