#include "enamel/sim/simulated_device.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "enamel/sim/hand.hpp"

namespace enamel {
namespace {

std::int64_t now() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

constexpr double kMostBehind = 0.1;  // s

}  // namespace

WrenchFunction pressingHand(const Pose& start) {
  return [start](double, const Pose& pose, const Vec6& twist) {
    constexpr double kPush = 1.0, kDamping = 5.0, kDeepest = 20e-3, kStop = 200.0;  // N, N s/m, m, N/m
    Vec6 wrench = guidingWrench(pose, twist, start, Vec3::UnitZ());
    const double beyond = start.position.z() - kDeepest - pose.position.z();
    wrench[2] -= kPush + kDamping * twist[2] - kStop * std::max(0.0, beyond);
    return wrench;
  };
}

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
