#include "plugin/own_device.hpp"

#include <array>

#include "core/message.hpp"

namespace enamel {
namespace {

class OwnDevice final : public HapticDevice {
 public:
  OwnDevice(const EnamelDevice& device, int joints) : callbacks_(device), joints_(joints) {
    require(isKnown(device),
            "EnamelDevice.size is " + std::to_string(device.size) + ", must be " + std::to_string(sizeof device));
    require(device.measure != nullptr && device.actuate != nullptr, "EnamelDevice needs measure and actuate");
  }

  void open() override {
    if (callbacks_.open == nullptr) return;
    std::array<char, 1024> text{};
    const std::int32_t result = callbacks_.open(callbacks_.user, {text.data(), text.size()});
    text.back() = 0;
    if (result != ENAMEL_OK)
      throw Error("the device does not open" + (text[0] != 0 ? ": " : ", code " + std::to_string(result)) +
                  text.data());
  }
  void close() noexcept override {
    if (callbacks_.close != nullptr) callbacks_.close(callbacks_.user);
  }
  Status measure(Measurement& measurement) noexcept override {
    EnamelMeasurement plain{};
    plain.size = sizeof plain;
    plain.enabled = 1;
    const std::int32_t result = callbacks_.measure(callbacks_.user, &plain);
    if (result == ENAMEL_OK && plain.failed != 0) return Status::inactive;  // the driver cannot continue
    if (result == ENAMEL_OK) measurement = measurementOf(plain, joints_);
    return statusOf(result);
  }
  Status actuate(const Command& command) noexcept override {
    if (callbacks_.grip != nullptr) (void)callbacks_.grip(callbacks_.user, command.gripper);
    return statusOf(callbacks_.actuate(callbacks_.user, command.effort.data(), joints_));
  }

 private:
  EnamelDevice callbacks_;
  int joints_;
};

}  // namespace

std::unique_ptr<HapticDevice> makeDevice(const EnamelDevice& device, int joints) {
  return std::make_unique<OwnDevice>(device, joints);
}

}  // namespace enamel
