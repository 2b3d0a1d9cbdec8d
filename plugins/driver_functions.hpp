// Parts that drivers in C++ share.
#pragma once

#include <enamel/plugin/driver.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
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

/// Rates of positions: differences through a low pass of 100 Hz. The estimators of vendors use longer windows.
class DriverRates {
 public:
  void reset() noexcept { isFirst_ = true; }

  /// Fill in the rates of `joints` joints from m.q and m.time, which increases. The first ones are zero. Realtime: yes.
  void add(EnamelMeasurement& m, std::int32_t joints) noexcept {
    constexpr double kCutoff = 100.0, kTurn = 6.283185307179586;  // Hz, rad
    const double elapsed = m.time - time_, gain = -std::expm1(-kTurn * kCutoff * elapsed);
    for (std::size_t i = 0; i < static_cast<std::size_t>(joints); ++i) {
      rates_[i] = isFirst_ ? 0.0 : rates_[i] + gain * ((m.q[i] - last_[i]) / elapsed - rates_[i]);
      last_[i] = m.q[i];
      m.rates[i] = rates_[i];
    }
    time_ = m.time;
    isFirst_ = false;
  }

 private:
  bool isFirst_ = true;
  double time_ = 0.0;  // s
  std::array<double, ENAMEL_MAX_JOINTS> last_{}, rates_{};
};

/// Make the table of a device from a class with open(), close(), measure(m) and actuate(effort, count). `grip`: of a
/// device whose gripper has a motor.
template <typename Device>
EnamelDevice deviceTable(Device* device, decltype(EnamelDevice::grip) grip = nullptr) noexcept {
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
          },
          grip};
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
