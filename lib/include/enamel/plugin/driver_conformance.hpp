// Tests of the contract of driver.h, for authors of drivers.
#pragma once

#include "enamel/plugin/conformance.hpp"
#include "enamel/plugin/driver_host.hpp"

namespace enamel {

struct DriverConformanceOptions {
  std::string address;                         ///< of the device, as in its URL
  std::map<std::string, std::string> options;  ///< of its URL
  double period = 1e-3;                        ///< of the ticks, s
  double duration = 1.0;                       ///< of the path of ticks, s
  std::function<long()> allocationCount;       ///< as in ConformanceOptions
};

/// Run every check on a device that is connected, and report each one when it is done. All efforts are zero, so nothing
/// moves it: it may be real. A person may move it slowly. Return whether no check failed. Realtime: no.
bool checkDriver(const std::shared_ptr<const DriverLibrary>& library, const DriverConformanceOptions& options,
                 const std::function<void(const ConformanceResult&)>& report);

}  // namespace enamel
