// Shared by tests of the first trial: single mistakes of a driver, and a person who does as told.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "enamel/session/first_touch.hpp"

namespace enamel::test {

enum class Mistake { none, sign, unit, axis, forceSign, forceUnit, forceAxis, delay, clock, lost };

/// Each mistake and the words that must name it.
inline constexpr std::pair<Mistake, const char*> kMistakes[] = {
    {Mistake::sign, "expected forwards (to the right): wrong sign"},
    {Mistake::unit, "is its unit m?"},
    {Mistake::axis, "the position moved along y"},
    {Mistake::forceSign, "the handle moved along z"},
    {Mistake::forceUnit, "unit of the forces"},
    {Mistake::forceAxis, "the handle moved along z"},
    {Mistake::delay, "the delay is"},
    {Mistake::clock, "is their unit s?"},
    {Mistake::lost, "of the samples are missing"}};

/// A driver with one mistake around a device that moves in simulated time.
class MistakenDevice final : public HapticDevice {
 public:
  MistakenDevice(std::unique_ptr<HapticDevice> device, Mistake mistake)
      : device_(std::move(device)), mistake_(mistake) {}
  void open() override { device_->open(); }
  void close() noexcept override { device_->close(); }
  Status measure(Measurement& m) noexcept override {
    const Status status = device_->measure(m);
    if (status != Status::ok) return status;
    if (mistake_ == Mistake::sign) m.q[0] = -m.q[0], m.rates[0] = -m.rates[0];
    if (mistake_ == Mistake::unit) m.q *= 0.1, m.rates *= 0.1;
    if (mistake_ == Mistake::axis) std::swap(m.q[0], m.q[1]), std::swap(m.rates[0], m.rates[1]);
    if (mistake_ == Mistake::clock) m.time *= 2.0;
    return mistake_ == Mistake::lost && ++calls_ % 4 == 3 ? Status::stale : status;
  }
  Status actuate(const Command& command) noexcept override {
    Command sent = command;
    if (mistake_ == Mistake::forceSign) sent.effort[2] = -sent.effort[2];
    if (mistake_ == Mistake::forceUnit) sent.effort *= 0.1;
    if (mistake_ == Mistake::forceAxis) std::swap(sent.effort[0], sent.effort[2]);
    if (mistake_ == Mistake::delay) {
      late_.push_back(sent);
      if (late_.size() < 6) return device_->actuate({JointVector::Zero(command.effort.size())});
      sent = late_.front();
      late_.pop_front();
    }
    return device_->actuate(sent);
  }

 private:
  std::unique_ptr<HapticDevice> device_;
  Mistake mistake_;
  int calls_ = 0;
  std::deque<Command> late_;
};

/// Try a device with a mistake. `hold` moves the person's hand: place, W, m; stiffness, N/m. The person moves, holds
/// loosely and pushes as told, and confirms so many steps.
inline FirstTouchResult tryOut(OpenedDevice opened, Mistake mistake,
                               const std::function<void(const Vec3& place, double stiffness)>& hold,
                               const std::string& recording = "", int confirmations = 1000) {
  opened.device = std::make_unique<MistakenDevice>(std::move(opened.device), mistake);
  FirstTouchOptions options;
  options.isSimulated = true;
  options.moveTime = 1.0;
  options.recording = recording;
  Vec3 target = Vec3::Zero();
  return firstTouch(opened, options, [&, target](const std::string& request) mutable {
    const auto has = [&request](const char* word) { return request.find(word) != std::string::npos; };
    if (has("handle to the right")) target += Vec3(0.03, 0.0, 0.0);
    if (has("handle up")) target += Vec3(0.0, 0.03, 0.0);
    if (has("handle towards you")) target += Vec3(0.0, 0.0, 0.02);
    if (has("loosely") || has("Lay")) target.setZero();
    if (has("against")) target = Vec3(0.0, 0.0, -0.003);
    hold(target, has("loosely") ? 30.0 : 300.0);
    return confirmations-- > 0;
  });
}

}  // namespace enamel::test
