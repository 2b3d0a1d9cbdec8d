// A hand presses a tool against a flat wall on the virtual device. After 0.5 s a fault occurs: in a sample of the
// driver, or in the host's handling of the wall. The result describes the motion from then on.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "enamel/device/device_file.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_device.hpp"
#include "support/devices.hpp"

namespace enamel::test {

struct PressedWall {
  std::string device = "tau-nominal.toml";
  double force = 8.0;      // of the hand, N
  double period = 1e-3;    // of the samples, s; the controller is designed for 1 ms
  Delay delay;             // ticks; the controller knows it
  std::uint64_t seed = 1;  // of a random delay
  double vibration = 0.0;  // amplitude of a force of 150 Hz that an effect adds after the controller, N

  // `tick` counts from the fault and is negative before it. `driver` may change a sample or replace its status; `host`
  // may move the wall.
  std::function<Status(int tick, Measurement& sample)> driver;
  std::function<void(int tick, Scene& scene)> host;
};

struct PressResult {
  bool finished = false;                  // false: the tool left the workspace
  double depthBefore = 0.0;               // deepest point below the wall in the 0.1 s before the fault, m
  double depth = 0.0;                     // deepest point below the wall afterwards, m
  double lift = 0.0;                      // highest point above the wall afterwards, m
  double energy = 0.0;                    // largest work of the motors on the tool since the fault, without gravity, J
  double energyAtEnd = 0.0;               // the same work in the last 0.2 s, J
  std::uint64_t ignoredReports = 0;       // of the torque that acted
  GuardReason guard = GuardReason::none;  // last one in the list of reasons that occurred
};

namespace pressed_wall {

class Driver final : public HapticDevice {
 public:
  Driver(VirtualDevice& device, const PressedWall& press, int faultTick)
      : device_(device), press_(press), tick_(-faultTick - 1) {}  // the loop first waits for one sample
  Status measure(Measurement& sample) noexcept override {
    const Status status = device_.measure(sample);
    const int tick = tick_++;
    return status == Status::ok && press_.driver ? press_.driver(tick, sample) : status;
  }
  Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

 private:
  VirtualDevice& device_;
  const PressedWall& press_;
  int tick_;
};

// An application's renderer: the controller's torque, and a vibration along the wall's normal.
class Vibrating final : public Renderer {
 public:
  Vibrating(Renderer& controller, double amplitude) : controller_(controller), amplitude_(amplitude) {}
  bool needsInertia() const noexcept override { return controller_.needsInertia(); }

 private:
  void prepare(double period) override { controller_.activate(period); }
  Status render(const TickFrame& input, TickOutput& output) noexcept override {
    const Status status = controller_.step(input, output);
    Vec6 wrench = Vec6::Zero();
    wrench[2] = amplitude_ * std::sin(2.0 * M_PI * 150.0 * input.time);
    if (status == Status::ok) output.torque += torqueOf(input.kinematics.jacobian, wrench);
    return status;
  }
  void resetState() noexcept override { controller_.reset(); }
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  Renderer& controller_;
  double amplitude_;  // N
};

}  // namespace pressed_wall

/// Run for 1 s, with the fault in the middle.
inline PressResult run(const PressedWall& press) {
  const auto mechanism = makeMechanism(loadDevice(deviceFile(press.device)));
  const int ticks = static_cast<int>(std::lround(1.0 / press.period)), faultTick = ticks / 2;
  VirtualDeviceSetup setup;
  setup.start.position = {0.0, 0.0, 2e-3};
  setup.period = press.period;
  setup.encoders = {true, RateSource::lowPass};
  setup.delay = press.delay;
  setup.seed = press.seed;
  VirtualDevice device(*mechanism, setup);
  pressed_wall::Driver driver(device, press, faultTick);
  Scene scene = flatWall();
  PositionControlRenderer controller(positionControlFor(*mechanism, 1e-3, press.delay.low, press.delay.high));
  pressed_wall::Vibrating effect(controller, press.vibration);
  HapticTick haptics(*mechanism, scene, Tool{},
                     press.vibration == 0.0 ? static_cast<Renderer&>(controller) : static_cast<Renderer&>(effect), 1e-3,
                     setup.start);
  LoopBody loop(driver, haptics, {});
  const auto hand = [&](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = guidingWrench(pose, twist, setup.start, Vec3::UnitZ());
    wrench[2] -= (time < 0.05 ? 1.0 : press.force) + 3.0 * twist[2];
    return wrench;
  };

  PressResult result;
  double work = 0.0, workBefore = 0.0;
  for (int i = 0; i < ticks; ++i) {
    const int tick = i - faultTick;
    if (press.host) press.host(tick, scene);
    loop.step();
    const double height = device.state().position.z() - scene.obstacles()[0].pose.position.z();
    if (tick < 0 && tick >= -static_cast<int>(0.1 / press.period))
      result.depthBefore = std::max(result.depthBefore, -height);
    if (tick >= 0) {
      result.depth = std::max(result.depth, -height);
      result.lift = std::max(result.lift, height);
    }
    if (tick >= 0 || isFault(loop.tick().reason)) result.guard = std::max(result.guard, loop.tick().reason);
    if (device.advance(hand) != Status::ok) return result;
    const Kinematics& k = device.kinematics();
    if (tick >= 0) work += press.period * wrenchOf(k, device.torque() - k.gravity).dot(device.state().twist);
    result.energy = std::max(result.energy, work);
    if (tick == faultTick - static_cast<int>(0.2 / press.period)) workBefore = work;
  }
  result.energyAtEnd = work - workBefore;
  result.ignoredReports = haptics.guard().ignoredReports();
  result.finished = true;
  return result;
}

}  // namespace enamel::test
