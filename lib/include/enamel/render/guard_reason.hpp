// What a guard did to a tick's torque, and why.
#pragma once

#include <cstddef>
#include <cstdint>

namespace enamel {

/// Why the applied torque is not the requested one.
enum class GuardReason : std::uint8_t {
  none = 0,  ///< it is
  // For as long as it lasts:
  waiting,   ///< nothing is rendered yet: the demanded force is not small
  engaging,  ///< the rendered part ramps in
  disabled,  ///< the user's enable is off: it ramps out, or is out
  force,     ///< the force or moment at the TCP
  torque,    ///< a motor's limit
  slew,      ///< a motor's torque may not change that fast
  brake,     ///< the damper beyond `speed`, `turn` or `workspace` acts
  // Faults, latched until reset():
  measurement,  ///< not finite, or not one number a joint
  jump,         ///< a joint moved faster than it can
  frozen,       ///< a joint's reading stands still, though it moves
  clock,        ///< time did not advance
  late,         ///< no tick or no new sample for more than `longestGap`
  unreachable,  ///< no configuration of the device has these joint coordinates
  renderer,     ///< contacts or renderer failed, or the torque is not finite or too large
  workspace,    ///< beyond the workspace and its margin
  speed,        ///< faster than `stopSpeed` or `stopTurn`
  energy,       ///< the tool was given more energy than it gave, beyond the budget
  oscillation,  ///< the rendered torque oscillates
  deadlines,    ///< too many ticks or samples were missed
  device,       ///< the driver failed: Measurement::failed
  early,        ///< samples come in less than half a period, on average
};

inline constexpr std::size_t kGuardReasons = static_cast<std::size_t>(GuardReason::early) + 1;

inline constexpr bool isFault(GuardReason reason) noexcept { return reason >= GuardReason::measurement; }

/// Name of a reason in plain words. Realtime: yes.
const char* toString(GuardReason reason) noexcept;

}  // namespace enamel
