// What a tick asks of a device, virtual or real: measure, actuate. A device knows time and wires; its geometry and mass
// are those of a Mechanism.
#pragma once

#include <cstdint>
#include <optional>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// What a device reports at a tick. A tick without a new sample is a normal tick: `age` says so, and the tick predicts.
struct Measurement {
  double time = 0.0;  ///< of this tick, s, strictly increasing
  JointVector q;      ///< joint coordinates, rad or m
  JointVector rates;  ///< q', rad/s or m/s
  /// Torque that acted since the last measurement, N m or N; empty where the device cannot tell.
  std::optional<JointVector> applied;
  bool enabled = true;            ///< the user's enable, such as a dead man's switch; true where the device has none
  std::uint32_t buttons = 0;      ///< bit i: button i is pressed
  std::optional<double> gripper;  ///< opening angle, rad; empty where the device has none
  int age = 0;                    ///< periods since the sample; 0: a new one. Above 0, q, rates and applied are ignored
  bool failed = false;            ///< the driver cannot go on: the guard's fault `device`; with an age above 0
};

/// What a device is told.
struct Command {
  JointVector effort;  ///< N m or N
};

/// A device that can be measured and actuated, in this order, once a tick, between open() and close(). The virtual
/// device and every driver.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;

  /// Makes the device ready to be measured; its motors give nothing, or what balances gravity, until actuate(). Throws
  /// Error with the cause. Realtime: no.
  virtual void open() {}

  /// Ends what open() began, with the motors off; does nothing on a device that is not open. Realtime: no.
  virtual void close() noexcept {}

  /// Statuses: ok; stale where there is no measurement since the last call; any other where the driver cannot go on:
  /// the loop then stops rendering. Realtime: yes.
  [[nodiscard]] virtual Status measure(Measurement& measurement) noexcept = 0;

  /// Realtime: yes.
  [[nodiscard]] virtual Status actuate(const Command& command) noexcept = 0;
};

}  // namespace enamel
