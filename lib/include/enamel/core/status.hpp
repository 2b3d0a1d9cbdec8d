// What a function called in a tick answers. Errors outside a tick are exceptions (error.hpp).
#pragma once

#include <cstdint>

namespace enamel {

/// Result of a tick-time function. Whatever the status, outputs are finite and defined.
enum class Status : std::uint8_t {
  ok = 0,
  notFinite,     ///< an input is NaN or infinite
  unreachable,   ///< no configuration of the device has this pose or these joint angles
  singular,      ///< the configuration is at, or the way there passes, a singularity
  notConverged,  ///< the iteration limit was reached
  outOfRange,    ///< an input is finite but beyond what a device can do
  stale,         ///< the input's time has not advanced
  inactive,      ///< step() without activate()
  stopped,       ///< the guard has stopped the renderer: see its reason
};

inline constexpr int kStatuses = 9;

/// Name of a status in plain words, for messages. Realtime: yes.
const char* toString(Status status) noexcept;

}  // namespace enamel
