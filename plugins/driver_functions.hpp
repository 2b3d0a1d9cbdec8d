// Parts that drivers in C++ share.
#pragma once

#include <enamel/plugin/driver.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

namespace enamel {

/// Return the time of a monotonic clock, s. Realtime: yes.
inline double driverClock() noexcept {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Run `work`, and turn exceptions into a result with a message.
template <typename Work>
std::int32_t guardedSetup(EnamelMessage message, const Work& work) noexcept {
  try {
    work();
    return ENAMEL_OK;
  } catch (const std::exception& error) {
    if (message.text != nullptr && message.size > 0) std::snprintf(message.text, message.size, "%s", error.what());
    return ENAMEL_BAD_CONFIGURATION;
  }
}

/// Return the value of an option, or its default.
inline std::string optionOf(const EnamelParameter& option, const EnamelParameter* given, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (std::strcmp(given[i].key, option.key) == 0) return given[i].value;
  return option.value;
}

/// Return ENAMEL_OK if all efforts are finite, and there are as many as joints. Realtime: yes.
inline std::int32_t checkEfforts(const double* effort, std::int32_t count, std::int32_t joints) noexcept {
  if (count != joints) return ENAMEL_OUT_OF_RANGE;
  for (std::int32_t i = 0; i < count; ++i)
    if (!std::isfinite(effort[i])) return ENAMEL_NOT_FINITE;
  return ENAMEL_OK;
}

/// Make the table of a device from a class with open(), close(), measure(m) and actuate(effort, count).
template <typename Device>
EnamelDevice deviceTable(Device* device) noexcept {
  return {sizeof(EnamelDevice),
          0u,
          device,
          [](void* user, EnamelMessage message) {
            return guardedSetup(message, [user] { static_cast<Device*>(user)->open(); });
          },
          [](void* user) { static_cast<Device*>(user)->close(); },
          [](void* user, EnamelMeasurement* m) { return static_cast<Device*>(user)->measure(*m); },
          [](void* user, const double* effort, std::int32_t count) {
            return static_cast<Device*>(user)->actuate(effort, count);
          }};
}

/// Return the table of a driver.
template <typename Device>
EnamelDriver driverTable(const EnamelDescription* (*describe)(), decltype(EnamelDriver::list) list,
                         decltype(EnamelDriver::connect) connect) noexcept {
  return {ENAMEL_DRIVER_ABI_VERSION,
          sizeof(EnamelDriver),
          sizeof(EnamelConnected),
          sizeof(EnamelMeasurement),
          describe,
          list,
          connect,
          [](EnamelConnected* connected) { delete static_cast<Device*>(connected->device.user); }};
}

}  // namespace enamel
