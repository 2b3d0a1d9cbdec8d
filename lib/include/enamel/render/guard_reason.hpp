// Reasons why a guard changed the torque of a tick.
#pragma once

#include <cstddef>
#include <cstdint>

namespace enamel {

/// Why the applied torque differs from the requested torque.
enum class GuardReason : std::uint8_t {
  none = 0,  ///< it does not differ
  // Temporary reasons, while they last:
  waiting,   ///< nothing is rendered yet because the demanded force is not small
  engaging,  ///< the rendered part ramps in
  disabled,  ///< the user's enable is off: the rendered part ramps out, or is zero
  force,     ///< limit of force or moment at the TCP
  torque,    ///< limit of a motor's torque
  slew,      ///< limit of the change of a motor's torque
  brake,     ///< the brake acts: above `speed` or `turn`, or outside `workspace`
  // Faults, latched until reset():
  measurement,  ///< invalid: not finite, or not one number per joint
  jump,         ///< a joint moved faster than `rate`
  frozen,       ///< the reading of a joint does not change although the joint moves
  clock,        ///< time did not advance
  late,         ///< no tick or no new sample for more than `longestGap` periods
  unreachable,  ///< no configuration of the device has these joint coordinates
  renderer,     ///< contacts or renderer failed, or the torque is not finite or too large
  workspace,    ///< outside the workspace and its margin
  speed,        ///< faster than `stopSpeed` or `stopTurn`
  energy,       ///< the tool received more energy than it returned, by more than the budget
  oscillation,  ///< the rendered torque oscillates
  deadlines,    ///< too many ticks or samples were missed
  device,       ///< the driver failed: Measurement::failed
  early,        ///< the mean time between samples is below half a period
};

inline constexpr std::size_t kGuardReasons = static_cast<std::size_t>(GuardReason::early) + 1;

inline constexpr bool isFault(GuardReason reason) noexcept { return reason >= GuardReason::measurement; }

/// Return the name of a reason in plain words. Realtime: yes.
const char* toString(GuardReason reason) noexcept;

}  // namespace enamel
