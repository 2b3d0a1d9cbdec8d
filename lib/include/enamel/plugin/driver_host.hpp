// For hosts: find, load and connect drivers of devices.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enamel/device/haptic_device.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/plugin/driver.h"
#include "enamel/plugin/host.hpp"

namespace enamel {

/// A loaded driver. The library stays loaded while this object or a device of it exists.
class DriverLibrary {
 public:
  /// Load a shared library as PluginLibrary::load(), with enamel_driver(). Throws PluginError in the same cases, and if
  /// the name cannot be a scheme. Realtime: no.
  static std::shared_ptr<const DriverLibrary> load(const std::string& path);

  /// Use a table of functions in this program. `name` appears in messages. Throws PluginError as load(). Realtime: no.
  static std::shared_ptr<const DriverLibrary> of(const EnamelDriver& table, const std::string& name);

  const std::string& path() const noexcept { return path_; }
  const EnamelDescription& description() const noexcept { return *description_; }
  const EnamelDriver& table() const noexcept { return *table_; }

 private:
  DriverLibrary() = default;
  void use(const EnamelDriver& table);

  std::string path_;
  std::shared_ptr<void> handle_;
  const EnamelDriver* table_ = nullptr;
  const EnamelDescription* description_ = nullptr;
};

/// A device that a driver has connected.
struct DriverDevice {
  std::string text;   ///< content of the device file (TOML)
  std::string facts;  ///< about this device, for reports: one line of its driver, or empty
  std::shared_ptr<const Mechanism> mechanism;
  int delayLow = 0, delayHigh = 0;  ///< ticks, see EnamelConnected
  bool hasOwnClock = false;
  std::unique_ptr<HapticDevice> device;  ///< keeps the library; its end disconnects
};

/// Connect a device. `address` and `options` are those of its URL. Throws PluginError in these cases:
/// - the driver does not have an option, or one without a default is missing; the message lists the options;
/// - the driver cannot connect; the message has its reason;
/// - the device file of the driver is not valid, or has another number of joints, or a delay is not in 0 to 63 ticks.
/// Realtime: no; the device's measure() and actuate() if the driver's are.
DriverDevice connectDriver(std::shared_ptr<const DriverLibrary> library, const std::string& address,
                           const std::map<std::string, std::string>& options);

/// One device that a driver can connect.
struct DriverListing {
  std::string address;  ///< of the URL, after "scheme://"
  std::string text;     ///< for users, one line
};

/// Return the devices of a driver that are connected. Throws PluginError with the driver's reason if it finds no
/// device. Realtime: no.
std::vector<DriverListing> listDriver(const DriverLibrary& library);

/// Find a driver as findPlugin() does: by its path, or by its name, which is the scheme of URLs, in `folder`. Realtime:
/// no.
std::shared_ptr<const DriverLibrary> findDriver(const std::string& nameOrPath, const std::string& folder);

/// Return whether the file exports a driver. Throws PluginError if it cannot be loaded. Realtime: no.
bool isDriver(const std::string& path);

}  // namespace enamel
