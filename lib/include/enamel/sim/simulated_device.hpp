// The virtual device as a device that a loop finds: somebody holds it, and time goes on.
#pragma once

#include <functional>

#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// The wrench of a person on the platform at the TCP (N, N m) at a time (s), pose and twist. Called several times a
/// step of integration; must be Realtime: yes.
using WrenchFunction = std::function<Vec6(double time, const Pose& pose, const Vec6& twist)>;

/// A VirtualDevice that actuate() moves on: by one period, or in real time to where the clock is, counted from open().
class SimulatedDevice final : public HapticDevice {
 public:
  /// Throws Error: as VirtualDevice. Realtime: no.
  SimulatedDevice(const Mechanism& mechanism, const VirtualDeviceSetup& setup, WrenchFunction load,
                  bool realTime = false)
      : device_(mechanism, setup), load_(std::move(load)), period_(setup.period), realTime_(realTime) {}

  void open() override;

  /// As VirtualDevice::measure(), or the status of the configuration that it could not leave. Realtime: yes.
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override;

  /// Always moves on by a period; after the clock went on without it by more, up to 100 ms of it with the last torque.
  /// Realtime: yes (bounded by 100 ms of simulation).
  [[nodiscard]] Status actuate(const Command& command) noexcept override;

  /// The truth. The loop's thread.
  const VirtualDevice& device() const noexcept { return device_; }

 private:
  VirtualDevice device_;
  WrenchFunction load_;
  double period_;
  bool realTime_;
  std::int64_t begin_ = 0;  // ns, when the device's time was 0
  Status status_ = Status::ok;
};

}  // namespace enamel
