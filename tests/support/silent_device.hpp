// A device that does not report the torque that acts.
#pragma once

#include "enamel/sim/virtual_device.hpp"

namespace enamel::test {

/// A virtual device without reports of the torque, like the devices of vendors.
class SilentDevice final : public HapticDevice {
 public:
  explicit SilentDevice(VirtualDevice& device) : device_(device) {}
  Status measure(Measurement& m) noexcept override {
    const Status status = device_.measure(m);
    m.applied.reset();
    return status;
  }
  Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

 private:
  VirtualDevice& device_;
};

}  // namespace enamel::test
