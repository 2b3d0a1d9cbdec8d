// The virtual device as a HapticDevice for a loop: a person holds it, and time advances.
#pragma once

#include <functional>

#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// Wrench of a person on the platform at the TCP (N, N m) at a time (s), pose and twist. An integration step calls it
/// several times. It must be Realtime: yes.
using WrenchFunction = std::function<Vec6(double time, const Pose& pose, const Vec6& twist)>;

/// A VirtualDevice that actuate() moves on: by one period or, in real time, to the present of the clock since its first
/// command.
class SimulatedDevice final : public HapticDevice {
 public:
  /// Throws Error as VirtualDevice. Realtime: no.
  SimulatedDevice(const Mechanism& mechanism, const VirtualDeviceSetup& setup, WrenchFunction load,
                  bool realTime = false)
      : device_(mechanism, setup), load_(std::move(load)), period_(setup.period), realTime_(realTime) {}

  void open() override;

  /// Measure as VirtualDevice::measure(). Returns its status, or the status of the configuration that the device cannot
  /// leave. Realtime: yes.
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override;

  /// Move on by one period. In real time, if the clock advanced by more, also move on by that time, up to 100 ms, with
  /// the last torque. Realtime: yes (bounded by 100 ms of simulation).
  [[nodiscard]] Status actuate(const Command& command) noexcept override;

  /// Return the device with its true state. Threads: the loop's.
  const VirtualDevice& device() const noexcept { return device_; }

 private:
  VirtualDevice device_;
  WrenchFunction load_;
  double period_;
  bool realTime_;
  bool isMoving_ = false;   // from the first command on: a loop may take milliseconds to start
  std::int64_t begin_ = 0;  // ns, clock at the device's time 0
  Status status_ = Status::ok;
};

}  // namespace enamel
