#include "enamel/sim/simulated_device.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace enamel {
namespace {

std::int64_t now() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

constexpr double kMostBehind = 0.1;  // s

}  // namespace

void SimulatedDevice::open() { isMoving_ = false; }

Status SimulatedDevice::measure(Measurement& measurement) noexcept {
  return status_ != Status::ok ? status_ : device_.measure(measurement);
}

Status SimulatedDevice::actuate(const Command& command) noexcept {
  double periods = 1.0;
  if (realTime_) {
    if (!isMoving_) begin_ = now() - std::llround(1e9 * device_.time());
    isMoving_ = true;
    const double behind = 1e-9 * static_cast<double>(now() - begin_) - device_.time();
    periods = std::clamp(std::round(behind / period_), 1.0, std::ceil(kMostBehind / period_));
    if (behind > kMostBehind + period_) begin_ = now() - std::llround(1e9 * (device_.time() + kMostBehind));
  }
  for (int i = 0; i < static_cast<int>(periods) && status_ == Status::ok; ++i) {
    (void)device_.actuate(command);
    status_ = device_.advance(load_);
  }
  return status_;
}

}  // namespace enamel
