// A device in simulated time, for the program that replaces the clock of C++ (simulated/drivers.cpp).
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <utility>

#include "enamel/device/haptic_device.hpp"
#include "support/driver_rigs.hpp"

namespace enamel::test {

/// The time of the replaced clock, ns.
extern std::atomic<std::int64_t> clock_ns;

/// The device of a driver: each measure() is a step of the simulated time, s. `pass(time)` lets the stand-in follow.
class SteppedDevice final : public HapticDevice {
 public:
  SteppedDevice(std::unique_ptr<HapticDevice> device, const Rig& rig, double step,
                std::function<void(double time)> pass)
      : device_(std::move(device)), rig_(rig), step_(step), pass_(std::move(pass)) {}
  /// The stand-in has periods of 1 ms.
  SteppedDevice(std::unique_ptr<HapticDevice> device, const Rig& rig, double step)
      : SteppedDevice(std::move(device), rig, step, [&rig, step, passed = 0.0](double) mutable {
          if ((passed += step) < 0.999e-3) return;
          passed = 0.0;
          rig.period();
        }) {}
  void open() override { device_->open(); }
  void close() noexcept override { device_->close(); }
  [[nodiscard]] Status measure(Measurement& m) noexcept override {
    clock_ns += static_cast<std::int64_t>(1e9 * step_);
    time_ += step_;
    pass_(time_);
    Status status = device_->measure(m);
    if (rig_.await) rig_.await(*device_, m, status);
    return status;
  }
  [[nodiscard]] Status actuate(const Command& command) noexcept override {
    const std::uint64_t before = rig_.messages ? rig_.messages() : 0;
    const Status status = device_->actuate(command);
    // The stand-in must answer at this instant of the simulated time; it does not if it has a fault.
    for (int i = 0; i < 500 && rig_.messages && status == Status::ok && rig_.messages() == before; ++i)
      std::this_thread::sleep_for(std::chrono::microseconds(20));
    return status;
  }
  double time() const noexcept { return time_; }

 private:
  std::unique_ptr<HapticDevice> device_;
  const Rig& rig_;
  double step_, time_ = 0.0;  // s
  std::function<void(double)> pass_;
};

}  // namespace enamel::test
