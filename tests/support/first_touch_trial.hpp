// Shared by tests of the first trial: single mistakes of a driver, and a person who does as told.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enamel/session/first_touch.hpp"

namespace enamel::test {

/// One mistake of a driver, and the words that must name it.
struct Mistake {
  enum class Needs { nothing, turns, moments, gripper };  // of the device
  std::string what, words;
  std::function<void(Measurement&)> measured = {};
  std::function<void(Command&)> commanded = {};
  Needs needs = Needs::nothing;
  std::size_t late = 0;  // ticks, of the commands
  bool loses = false;    // every fourth sample
};

/// Change the joints from `first` on of positions and rates.
inline std::function<void(Measurement&)> onBoth(const std::function<void(JointVector&)>& change) {
  return [change](Measurement& m) {
    change(m.q);
    change(m.rates);
  };
}

/// Add wrong signs and exchanged axes of the three joints from `first` on. `senses` and `drives`: what a device needs.
inline void addSignsAndAxes(int first, Mistake::Needs senses, Mistake::Needs drives, std::vector<Mistake>& mistakes) {
  for (int i = 0; i < 3; ++i) {
    const int a = first + i, b = first + (i + 1) % 3;
    const std::string of = " of joint " + std::to_string(a), wrong = ": wrong sign";
    const auto negate = [a](JointVector& v) { v[a] = -v[a]; };
    const auto exchange = [a, b](JointVector& v) { std::swap(v[a], v[b]); };
    mistakes.push_back({"sign of the position" + of, wrong, onBoth(negate), {}, senses});
    mistakes.push_back({"axis of the position" + of, ": wrong axis", onBoth(exchange), {}, senses});
    mistakes.push_back({"sign of the rate" + of, "of the rates", [=](Measurement& m) { negate(m.rates); }, {}, senses});
    mistakes.push_back(
        {"axis of the rate" + of, "of the rates", [=](Measurement& m) { exchange(m.rates); }, {}, senses});
    mistakes.push_back({"sign of the force" + of, wrong, {}, [=](Command& c) { negate(c.effort); }, drives});
    mistakes.push_back({"axis of the force" + of, ": wrong axis", {}, [=](Command& c) { exchange(c.effort); }, drives});
  }
}

/// Return every single mistake.
inline std::vector<Mistake> allMistakes() {
  using Needs = Mistake::Needs;
  std::vector<Mistake> all;
  addSignsAndAxes(0, Needs::nothing, Needs::nothing, all);
  addSignsAndAxes(3, Needs::turns, Needs::moments, all);
  for (const double factor : {1e3, 1e2, 10.0, 0.1, 1e-2, 1e-3}) {
    const std::string times = " times " + std::to_string(factor);
    const auto scale = [factor](int first) {
      return [=](JointVector& v) {
        for (int i = first; i < std::min<int>(first + 3, static_cast<int>(v.size())); ++i) v[i] *= factor;
      };
    };
    all.push_back({"position" + times, "is its unit m|is the unit of the positions m", onBoth(scale(0))});
    all.push_back({"rate" + times, "of the rates", [=](Measurement& m) { scale(0)(m.rates); }});
    all.push_back({"force" + times, "unit of the forces|too fast", {}, [=](Command& c) { scale(0)(c.effort); }});
  }
  for (const double factor : {180.0 / M_PI, M_PI / 180.0}) {
    const auto scale = [factor](JointVector& v) { v.tail(3) *= factor; };
    all.push_back({"angle times " + std::to_string(factor),
                   "is its unit rad?|the guard stopped the loop",
                   onBoth(scale),
                   {},
                   Needs::turns});
  }
  all.push_back({"inverse rotation",
                 ": wrong sign",
                 [](Measurement& m) {
                   m.q.tail(3) *= -1.0;
                   m.rates.tail(3) *= -1.0;
                 },
                 {},
                 Needs::turns});
  all.push_back({"delay of 5 ticks", "the delay is", {}, {}, Needs::nothing, 5});
  all.push_back({"lost samples", "of the samples are missing", {}, {}, Needs::nothing, 0, true});
  all.push_back({"time in ms", "is their unit s?|is this computer busy", [](Measurement& m) { m.time *= 1e3; }});
  all.push_back({"time times 2", "is their unit s?", [](Measurement& m) { m.time *= 2.0; }});
  all.push_back({"frozen time", "the time stamps do not increase|time", [](Measurement& m) { m.time = 1.0; }});
  all.push_back({"not finite", "numbers that are not finite", [](Measurement& m) { m.q[0] = std::nan(""); }});
  all.push_back(
      {"not calibrated", "the device is not calibrated", [](Measurement& m) { m.conditions = kUncalibrated; }});
  all.push_back({"forces cut", "cut its forces by itself", [](Measurement& m) { m.conditions = kForcesCut; }});
  all.push_back({"not enabled", "press its force button", [](Measurement& m) { m.enabled = false; }});
  all.push_back({"sign of the gripper",
                 "while it opened: wrong sign",
                 [](Measurement& m) { m.gripper = -m.gripper.value_or(0.0); },
                 {},
                 Needs::gripper});
  all.push_back({"unit of the gripper",
                 "is its unit rad?",
                 [](Measurement& m) { m.gripper = 1e-3 * m.gripper.value_or(0.0); },
                 {},
                 Needs::gripper});
  all.push_back({"force of the gripper",
                 "wrong sign of its force",
                 {},
                 [](Command& c) { c.gripper = -c.gripper; },
                 Needs::gripper});
  return all;
}

/// Return whether one of the words, separated by "|", is in the text.
inline bool names(const std::string& text, const std::string& words) {
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t end = words.find('|', at);
    if (text.find(words.substr(at, end == std::string::npos ? end : end - at)) != std::string::npos) return true;
    at = end == std::string::npos ? end : end + 1;
  }
  return false;
}

/// A driver with one mistake around a device that moves in simulated time.
class MistakenDevice final : public HapticDevice {
 public:
  MistakenDevice(std::unique_ptr<HapticDevice> device, Mistake mistake)
      : device_(std::move(device)), mistake_(std::move(mistake)) {}
  void open() override { device_->open(); }
  void close() noexcept override { device_->close(); }
  Status measure(Measurement& m) noexcept override {
    const Status status = device_->measure(m);
    if (status == Status::ok && mistake_.measured) mistake_.measured(m);
    return status == Status::ok && mistake_.loses && ++calls_ % 4 == 3 ? Status::stale : status;
  }
  Status actuate(const Command& command) noexcept override {
    Command sent = command;
    if (mistake_.commanded) mistake_.commanded(sent);
    late_.push_back(sent);
    if (late_.size() <= mistake_.late) return device_->actuate({JointVector::Zero(command.effort.size())});
    sent = late_.front();
    late_.pop_front();
    return device_->actuate(sent);
  }

 private:
  std::unique_ptr<HapticDevice> device_;
  Mistake mistake_;
  int calls_ = 0;
  std::deque<Command> late_;
};

/// The hand of the person: the target in W, m and rad, the stiffness in N/m, and the opening of the gripper, rad.
struct TrialHand {
  Vec3 place = Vec3::Zero(), turn = Vec3::Zero();
  double stiffness = 300.0, gripper = 0.0;
};

/// Try a device with a mistake. `hold` moves the person's hand. The person moves, holds loosely and pushes as told, and
/// confirms so many steps.
inline FirstTouchResult tryOut(OpenedDevice opened, const Mistake& mistake,
                               const std::function<void(const TrialHand&)>& hold, const std::string& recording = "",
                               int confirmations = 1000) {
  opened.device = std::make_unique<MistakenDevice>(std::move(opened.device), mistake);
  FirstTouchOptions options;
  options.isSimulated = true;
  options.moveTime = 1.0;
  options.recording = recording;
  TrialHand hand;
  return firstTouch(opened, options, [&, hand](const std::string& request) mutable {
    const auto has = [&request](const char* words) { return request.find(words) != std::string::npos; };
    const bool isLoose = has("loosely");
    if (has("move the handle to the right")) hand.place += Vec3(0.03, 0.0, 0.0);
    if (has("move the handle up")) hand.place += Vec3(0.0, 0.03, 0.0);
    if (has("move the handle towards you")) hand.place += Vec3(0.0, 0.0, 0.02);
    const auto turn = [&hand](const Vec3& axis) {  // from where it is
      const Eigen::AngleAxisd before(hand.turn.norm(), hand.turn.norm() > 0.0 ? Vec3(hand.turn.normalized()) : axis);
      const Eigen::AngleAxisd after(Eigen::AngleAxisd(0.4, axis) * before);
      hand.turn = after.angle() * after.axis();
    };
    if (has("then turn the handle so that its front end goes up")) turn(Vec3::UnitX());
    if (has("then turn the handle so that its front end goes to the left")) turn(Vec3::UnitY());
    if (has("then turn the handle so that its right side goes up")) turn(Vec3::UnitZ());
    if (has("open it")) hand.gripper = 0.3;
    if (isLoose || has("Lay")) hand = {};
    if (has("against")) hand.place = Vec3(0.0, 0.0, -0.003);
    hand.stiffness = isLoose ? 30.0 : 300.0;
    hold(hand);
    return confirmations-- > 0;
  });
}

/// Call try(mistake) for each mistake that a device can have.
inline void forEachMistake(bool turns, bool moments, bool gripper, const std::function<void(const Mistake&)>& attempt) {
  for (const Mistake& mistake : allMistakes()) {
    const bool can = mistake.needs == Mistake::Needs::turns     ? turns
                     : mistake.needs == Mistake::Needs::moments ? moments
                     : mistake.needs == Mistake::Needs::gripper ? gripper
                                                                : true;
    if (can) attempt(mistake);
  }
}

}  // namespace enamel::test
