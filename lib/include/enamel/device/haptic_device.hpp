// The interface of a haptic device, real or virtual: measure and actuate once a tick. A HapticDevice handles time and
// wires; a Mechanism holds the geometry and mass.
#pragma once

#include <cstdint>
#include <optional>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// Reports of a device about itself: bits of Measurement::conditions.
enum DeviceCondition : std::uint32_t {
  kForcesCut = 1,     ///< it has cut its forces by itself, for example because a motor is hot
  kUncalibrated = 2,  ///< its positions may be wrong
};

/// Return a condition in plain words. Realtime: yes.
constexpr const char* toString(DeviceCondition condition) noexcept {
  return condition == kForcesCut ? "the device has cut its forces by itself" : "the device is not calibrated";
}

/// One measurement of a device. A tick without a new sample is a normal tick: `age` is then above 0, and the tick
/// predicts the state.
struct Measurement {
  double time = 0.0;  ///< time of this tick, s, strictly increasing
  JointVector q;      ///< joint coordinates, rad or m
  JointVector rates;  ///< q', rad/s or m/s
  /// Torque that acted since the last measurement, N m or N; empty if the device does not report it.
  std::optional<JointVector> applied;
  bool enabled = true;            ///< the user's enable, such as a dead man's switch; true if the device has none
  std::uint32_t buttons = 0;      ///< bit i: button i is pressed
  std::optional<double> gripper;  ///< opening angle, rad; empty if the device has none
  std::uint32_t conditions = 0;   ///< DeviceCondition
  double heat = 0.0;              ///< of the hottest motor: share of its limit; 0 if the device does not report it
  /// Age of the sample, periods. 0: a new sample. Above 0: `q`, `rates` and `applied` are ignored.
  int age = 0;
  bool failed = false;  ///< the driver cannot continue (`age` is above 0): the guard's fault `device`
};

/// One command to a device.
struct Command {
  JointVector effort;    ///< motor torque or force, N m or N
  double gripper = 0.0;  ///< force of the gripper's motor, N, opening it; devices without one ignore it
};

/// Delay between a tick's torque and the motors, in ticks. The torque computed at tick j acts from tick j + d. If low <
/// high, each tick draws its own d uniformly, and the motors receive the torque computed at tick j - d. Commands may
/// then be repeated or skipped.
struct Delay {
  int low = 0;
  int high = 0;
};

/// A device that is measured and then actuated once a tick, between open() and close(). The virtual device and all
/// drivers implement it.
class HapticDevice {
 public:
  virtual ~HapticDevice() = default;

  /// Prepare the device for measure(). Until the first actuate(), the motors give zero effort or balance gravity.
  /// Throws Error with the cause. Realtime: no.
  virtual void open() {}

  /// Switch the motors off and release what open() acquired; do nothing if the device is not open. Realtime: no.
  virtual void close() noexcept {}

  /// Read the newest measurement. Realtime: yes.
  /// Statuses:
  /// - ok: a new measurement;
  /// - stale: no new measurement since the last call;
  /// - any other: the driver cannot continue, and the guard stops rendering.
  [[nodiscard]] virtual Status measure(Measurement& measurement) noexcept = 0;

  /// Send a command to the motors. Returns a status other than ok if the command was not sent. Realtime: yes.
  [[nodiscard]] virtual Status actuate(const Command& command) noexcept = 0;
};

}  // namespace enamel
