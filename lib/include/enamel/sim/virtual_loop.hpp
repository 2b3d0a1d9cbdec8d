// The closed loop on the virtual device, tick by tick: measure -> haptic tick -> actuate -> advance.
#pragma once

#include <cstdint>
#include <memory>

#include "enamel/render/tick.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// What determines a loop, but for the person.
struct LoopSetup : VirtualDeviceSetup {
  Scene scene = flatWall();
  Tool tool;
  bool guarded = true;        ///< false: the guard lets everything through
  double force = kUnlimited;  ///< the guard's limit of the rendered force at the TCP, N
};

/// Checks a setup. Throws Error: as checkVirtualDevice(); a scene without obstacles; a force below 0. Realtime: no.
void checkLoop(const LoopSetup& setup);

/// What happened at one tick. State and measurement are those before the tick's torque acts.
struct TickRecord {
  std::uint64_t tick = 0;
  double time = 0.0;               ///< s
  Pose pose;                       ///< of the plant
  Vec6 twist = Vec6::Zero();       ///< of the plant
  JointVector q;                   ///< measured, rad or m
  JointVector requested;           ///< by the renderer, N m or N
  JointVector command;             ///< what the guard made of it, N m or N
  JointVector torque;              ///< that acts during this tick, N m or N
  Vec6 handWrench = Vec6::Zero();  ///< wrench of the person at the TCP at the beginning of this tick, N, N m
  Vec6 rendered = Vec6::Zero();    ///< wrench of the motors on the tool beyond gravity during this tick, N, N m
  Contact nearest;                 ///< of the plant's tool with the scene, near or far
  double gapRate = 0.0;            ///< of the nearest contact's gap, m/s
  double normalForce = 0.0;        ///< of the wall on the tool, as the renderer reports it or the guard leaves it, N
  RenderMode mode = RenderMode::free;
  bool saturated = false;
  Status status = Status::ok;  ///< of the haptic tick
  GuardReason guard = GuardReason::none;
};

/// The loop: a virtual device and a haptic tick in front of it. Refers to mechanisms and renderer, which must outlive
/// it.
class VirtualLoop {
 public:
  /// `model`: what the haptic tick takes the plant for; the guard's limits are the plant's. Throws Error: as
  /// checkLoop(), VirtualDevice and HapticTick do. Realtime: no.
  VirtualLoop(const Mechanism& plant, const Mechanism& model, Renderer& renderer, const LoopSetup& setup);
  VirtualLoop(const Mechanism& mechanism, Renderer& renderer, const LoopSetup& setup)
      : VirtualLoop(mechanism, mechanism, renderer, setup) {}

  /// The same on another plant than the closed form.
  VirtualLoop(std::unique_ptr<Plant> plant, const Mechanism& model, Renderer& renderer, const LoopSetup& setup);
  VirtualLoop(const VirtualLoop&) = delete;
  VirtualLoop& operator=(const VirtualLoop&) = delete;

  /// One tick under the person's load. Fills `record` with what happened before and during the tick. Returns ok, or the
  /// status of the configuration that the plant could not leave; the loop then stays where it is. Realtime: yes, if
  /// plant and load are.
  [[nodiscard]] Status tick(const ExternalWrench& load, TickRecord& record) noexcept;

  /// The same under a load that jumps inside the tick, VirtualDevice::advance(). Realtime: yes, if both are.
  [[nodiscard]] Status tick(const ExternalWrench& before, double instant, const ExternalWrench& after,
                            TickRecord& record) noexcept;

  /// The haptic tick, and what the device told and was told at the last one. Realtime: yes.
  const HapticTick& hapticTick() const noexcept { return tick_; }
  const Measurement& measurement() const noexcept { return measurement_; }
  const Command& command() const noexcept { return command_; }

  /// Everything about the last tick; the guard. Realtime: yes.
  const TickFrame& frame() const noexcept { return tick_.frame(); }
  const Guard& guard() const noexcept { return tick_.guard(); }

  /// HapticTick::attach(). Realtime: yes.
  void attach(Drill* drill) noexcept { tick_.attach(drill); }

  /// Goes on after the guard has stopped: HapticTick::reset(). Realtime: yes.
  void reset() noexcept { tick_.reset(); }

  /// Starts again at tick 0 with the tool at rest at a pose, as after construction. Statuses and Realtime: as
  /// VirtualDevice::restart(); on another than ok nothing is changed.
  [[nodiscard]] Status restart(const Pose& start);

  /// What the tool meets, the tool. Realtime: yes.
  const Scene& scene() const noexcept { return scene_; }
  const Tool& tool() const noexcept { return tool_; }

  /// The plant. Realtime: yes.
  const VirtualDevice& device() const noexcept { return device_; }

 private:
  Status react(TickRecord& record) noexcept;

  Scene scene_;
  Tool tool_;
  VirtualDevice device_;
  HapticTick tick_;
  ToolCache trueCache_;  // of the plant's side
  Measurement measurement_;
  Command command_;
};

}  // namespace enamel
