// A device from a vendor's SDK in a haptic loop: the driver, and a stiff table under the stylus.
//
//   vendor_sdk cartesian-3.toml [seconds]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/runtime/haptic_loop.hpp>
#include <thread>

#include "sdk.h"

using namespace enamel;

// The driver: converts units, axes, rates and errors of the SDK to those of a HapticDevice.
class VendorDevice final : public HapticDevice {
 public:
  void open() override {
    if (sdk_open() != 0) throw Error("the stylus cannot be opened: is another program using it?");
    sdk_sleep(0.01);  // until the SDK has a position
  }
  void close() noexcept override { sdk_close(); }  // switches the motors off
  Status measure(Measurement& m) noexcept override {
    double mm[3];
    int grip = 0;
    if (sdk_position(mm, &grip) != 0) return Status::stale;  // no new sample
    const double time = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    const Vec3 position(1e-3 * mm[0], 1e-3 * mm[1], -1e-3 * mm[2]);
    if (time_ > 0.0)  // The SDK has no rates: differentiate the positions and low-pass the result at 100 Hz.
      rates_ += -std::expm1(-2.0 * M_PI * 100.0 * (time - time_)) * ((position - last_) / (time - time_) - rates_);
    time_ = m.time = time;
    m.q = last_ = position;
    m.rates = rates_;
    m.applied.reset();  // the SDK does not report it
    m.enabled = grip != 0;
    return Status::ok;
  }

  Status actuate(const Command& command) noexcept override {
    const double force[3] = {command.effort[0], command.effort[1], -command.effort[2]};
    return sdk_force(force) == 0 ? Status::ok : Status::outOfRange;
  }

 private:
  double time_ = 0.0;                                // s
  Vec3 last_ = Vec3::Zero(), rates_ = Vec3::Zero();  // m, m/s
};

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: vendor_sdk DEVICE.toml [seconds]\n"), 2;
  try {
    const double seconds = argc > 2 ? std::stod(argv[2]) : 2.0;
    const auto stylus = makeMechanism(loadDevice(argv[1]));
    const Scene table = flatWall();
    PositionControlRenderer servo(positionControlFor(*stylus, 1e-3, 0, 1));
    HapticTick haptics(*stylus, table, Tool(), servo, 1e-3);  // 1 kHz
    VendorDevice device;
    HapticLoop loop(device, haptics);  // the wall exists from here to the end of this function
    double largest = 0.0;
    for (int line = 1; 0.05 * line <= seconds; ++line) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      (void)loop.refresh();
      const LoopTick& t = loop.latest();
      const double z_mm = 1e3 * t.pose.position.z(), force = t.command.effort.size() == 3 ? t.command.effort[2] : 0.0;
      largest = std::max(largest, force);
      std::printf("%5.2f s %7.3f mm over the table %6.2f N %s\n", 0.05 * line, z_mm, force,
                  t.reason == GuardReason::none ? "" : toString(t.reason));
      if (isFault(t.reason)) (void)loop.reset();  // a fault (a late tick) remains until it is reset; here at once
    }
    std::printf("99 %% of the commands were younger than %.0f us; largest force on a line: %.2f N\n",
                1e6 * loop.age().quantile(0.99), largest);
    return largest > 0.3 ? 0 : 1;
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "vendor_sdk: %s\n", error.what()), 1;
  }
}
