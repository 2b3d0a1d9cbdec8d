// Result codes of the functions that are called in a tick. Outside a tick, errors are exceptions (error.hpp).
#pragma once

#include <cstdint>

namespace enamel {

/// Result of a function of a tick. Outputs are finite and defined for every status.
enum class Status : std::uint8_t {
  ok = 0,
  notFinite,     ///< an input is NaN or infinite
  unreachable,   ///< the device cannot have this pose or these joint angles
  singular,      ///< a singularity is at the configuration or on the way to it
  notConverged,  ///< the iteration limit was reached
  outOfRange,    ///< an input is finite but outside its valid range
  stale,         ///< the time of the input has not advanced
  inactive,      ///< step() was called without activate()
  stopped,       ///< the guard has stopped the renderer; its reason says why
};

inline constexpr int kStatuses = 9;

/// Return the name of a status in plain words, for messages. Realtime: yes.
const char* toString(Status status) noexcept;

}  // namespace enamel
