// A device from a vendor's SDK in a haptic loop: the driver, and a stiff table under the stylus.
//
//   vendor_sdk data/devices/cartesian-3.toml [seconds]
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "enamel/core/error.hpp"
#include "enamel/device/cartesian/mechanism.hpp"
#include "enamel/render/surface_servo.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "sdk.h"

namespace {

// The driver: units, axes, rates and errors of the SDK become those of a HapticDevice.
class VendorDevice final : public enamel::HapticDevice {
 public:
  void open() override {
    if (sdk_open() != 0) throw enamel::Error("the stylus cannot be opened: is another program using it?");
    sdk_sleep(0.01);  // until it has a position
  }

  void close() noexcept override {
    const double none[3] = {0.0, 0.0, 0.0};
    (void)sdk_force(none);
    sdk_close();
  }

  enamel::Status measure(enamel::Measurement& m) noexcept override {
    double position_mm[3];
    int grip = 0;
    if (sdk_position(position_mm, &grip) != 0) return enamel::Status::stale;
    const double time = std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    const enamel::Vec3 position(1e-3 * position_mm[0], 1e-3 * position_mm[1], -1e-3 * position_mm[2]);
    // The SDK has no rates: the difference of the positions through a low pass of 100 Hz.
    if (started_)
      rates_ += -std::expm1(-2.0 * M_PI * 100.0 * (time - time_)) * ((position - last_) / (time - time_) - rates_);
    started_ = true;
    last_ = position;
    time_ = m.time = time;
    m.q = position;
    m.rates = rates_;
    m.applied.resize(0);  // the SDK does not tell
    m.enabled = grip != 0;
    return enamel::Status::ok;
  }

  enamel::Status actuate(const enamel::Command& command) noexcept override {
    const double force[3] = {command.torque[0], command.torque[1], -command.torque[2]};
    return sdk_force(force) == 0 ? enamel::Status::ok : enamel::Status::outOfRange;
  }

 private:
  bool started_ = false;
  double time_ = 0.0;                          // s
  enamel::Vec3 last_ = enamel::Vec3::Zero();   // m
  enamel::Vec3 rates_ = enamel::Vec3::Zero();  // m/s
};

int run(const std::string& file, double seconds) {
  constexpr double period = 1e-3;  // s
  const enamel::CartesianMechanism stylus(enamel::loadCartesian(file));
  const enamel::Scene table = enamel::flatWall();
  enamel::SurfaceServoRenderer servo(enamel::surfaceServoFor(stylus.limits().count, period, 0, 1));
  enamel::HapticTick haptics(stylus, table, enamel::Tool(), servo, period);
  VendorDevice device;
  enamel::HapticLoop loop(device, haptics);  // the wall is there from here to the end of this function

  std::printf("a line every 50 ms: height of the stylus over the table, force of the table\n");
  double largest = 0.0;
  for (int line = 0; line * 0.05 < seconds; ++line) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    (void)loop.refresh();
    const enamel::LoopTick& t = loop.latest();
    const double z_mm = 1e3 * t.pose.position.z(), force = t.command.torque.size() == 3 ? t.command.torque[2] : 0.0;
    largest = std::max(largest, force);
    const int column = 16 + static_cast<int>(std::lround(4.0 * std::fmax(-2.0, std::fmin(10.0, z_mm))));
    std::string picture(60, ' ');
    picture[16] = '|';
    picture[static_cast<std::size_t>(column)] = 'o';
    std::printf("%6.2f s %7.3f mm %6.2f N %s %s\n", 0.05 * (line + 1), z_mm, force, picture.c_str(),
                t.reason == enamel::GuardReason::none ? "" : toString(t.reason));
    // A fault of the guard (on a busy machine: a tick came late) stays until somebody says go on; here that is at once.
    if (isFault(t.reason)) (void)loop.reset();
  }
  const enamel::PeriodicTiming& timing = loop.timing();
  std::printf(
      "%llu ticks, %llu missed, %s scheduling; wake-up error p99 %.0f us, compute p99 %.0f us, command's age p99 %.0f "
      "us\n",
      static_cast<unsigned long long>(timing.periods.load()), static_cast<unsigned long long>(timing.missed.load()),
      timing.realtime ? "real-time" : "normal", 1e6 * timing.wakeUp.quantile(0.99), 1e6 * timing.compute.quantile(0.99),
      1e6 * loop.age().quantile(0.99));
  std::printf("largest force on a line: %.2f N\n", largest);
  return largest > 0.3 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: vendor_sdk DEVICE.toml [seconds]\n"), 2;
  try {
    return run(argv[1], argc > 2 ? std::atof(argv[2]) : 2.0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "vendor_sdk: %s\n", error.what());
    return 1;
  }
}
