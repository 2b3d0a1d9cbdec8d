// The closed loop on the virtual device, tick by tick: measure -> haptic tick -> actuate -> advance.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "enamel/render/tick.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// Make a device between a virtual device and its loop, such as a driver. It must call measure() and
/// actuate() of the virtual device once a tick.
using DeviceWrapper = std::function<std::unique_ptr<HapticDevice>(VirtualDevice&)>;

/// All data of a loop except the person.
struct LoopSetup : VirtualDeviceSetup {
  Scene scene = flatWall();
  Tool tool;
  bool guarded = true;        ///< false: the guard lets every torque pass
  double force = kUnlimited;  ///< the guard's limit of the rendered force at the TCP, N
  DeviceWrapper wrapper;      ///< empty: the loop measures and commands the device itself
};

/// Check a setup. Throws Error as checkVirtualDevice(), and if the scene has no obstacles or the force is below 0.
/// Realtime: no.
void checkLoop(const LoopSetup& setup);

/// Record of one tick. State and measurement are those before the tick's torque acts.
struct TickRecord {
  std::uint64_t tick = 0;
  double time = 0.0;               ///< s
  Pose pose;                       ///< of the plant
  Vec6 twist = Vec6::Zero();       ///< of the plant
  JointVector q;                   ///< measured, rad or m
  JointVector requested;           ///< by the renderer, N m or N
  JointVector command;             ///< as the guard changed it, N m or N
  JointVector torque;              ///< acting during this tick, N m or N
  Vec6 handWrench = Vec6::Zero();  ///< wrench of the person at the TCP at the beginning of this tick, N, N m
  Vec6 rendered = Vec6::Zero();    ///< wrench of the motors on the tool above gravity during this tick, N, N m
  Contact nearest;                 ///< nearest contact of the plant's tool with the scene, at any distance
  double gapRate = 0.0;            ///< of the nearest contact's gap, m/s
  double normalForce = 0.0;        ///< force of the wall on the tool after the guard, N
  RenderMode mode = RenderMode::free;
  bool saturated = false;
  Status status = Status::ok;  ///< of the haptic tick
  GuardReason guard = GuardReason::none;
};

/// Fill in all fields that follow from a haptic tick, the torque of the record, and the pose of the device. `device` is
/// that of the plant, or as measured. Realtime: yes.
void describe(const TickFrame& tick, const Kinematics& device, const Scene& scene, const Tool& tool, ToolCache* cache,
              TickRecord& record) noexcept;

/// The loop: a virtual device and a haptic tick. It refers to mechanisms and renderer, which must outlive it.
class VirtualLoop {
 public:
  /// `model` is the mechanism that the haptic tick assumes. The guard's limits are the plant's. Throws Error as
  /// checkLoop(), VirtualDevice and HapticTick. Realtime: no.
  VirtualLoop(const Mechanism& plant, const Mechanism& model, Renderer& renderer, const LoopSetup& setup);
  VirtualLoop(const Mechanism& mechanism, Renderer& renderer, const LoopSetup& setup)
      : VirtualLoop(mechanism, mechanism, renderer, setup) {}

  /// Use another plant than the closed form.
  VirtualLoop(std::unique_ptr<Plant> plant, const Mechanism& model, Renderer& renderer, const LoopSetup& setup);
  VirtualLoop(const VirtualLoop&) = delete;
  VirtualLoop& operator=(const VirtualLoop&) = delete;

  /// Run one tick under the person's load. Fill `record` with the state before the tick and the events during it.
  /// Returns ok, or the status of the configuration that the plant cannot leave; the loop then does not move. Realtime:
  /// yes, if plant and load are.
  [[nodiscard]] Status tick(const ExternalWrench& load, TickRecord& record) noexcept;

  /// Run one tick under a load that jumps within the tick, as VirtualDevice::advance(). Realtime: yes, if both loads
  /// are.
  [[nodiscard]] Status tick(const ExternalWrench& before, double instant, const ExternalWrench& after,
                            TickRecord& record) noexcept;

  /// Return the haptic tick. measurement() and command() return what the device sent and received at the last tick.
  /// Realtime: yes.
  const HapticTick& hapticTick() const noexcept { return tick_; }
  const Measurement& measurement() const noexcept { return measurement_; }
  const Command& command() const noexcept { return command_; }

  /// Return the data of the last tick, and the guard. Realtime: yes.
  const TickFrame& frame() const noexcept { return tick_.frame(); }
  const Guard& guard() const noexcept { return tick_.guard(); }

  /// Attach a bur as HapticTick::attach(). Realtime: yes.
  void attach(Drill* drill) noexcept { tick_.attach(drill); }

  /// Continue after a fault of the guard, as HapticTick::reset(). Realtime: yes.
  void reset() noexcept { tick_.reset(); }

  /// Restart at tick 0 with the tool at rest at a pose, as after construction. Returns a status of
  /// VirtualDevice::restart(); on an error nothing changes. Realtime: as VirtualDevice::restart().
  [[nodiscard]] Status restart(const Pose& start);

  /// Return the scene and the tool. Realtime: yes.
  const Scene& scene() const noexcept { return scene_; }
  const Tool& tool() const noexcept { return tool_; }

  /// Return the plant. Realtime: yes.
  const VirtualDevice& device() const noexcept { return device_; }

 private:
  Status react(TickRecord& record) noexcept;

  Scene scene_;
  Tool tool_;
  VirtualDevice device_;
  std::unique_ptr<HapticDevice> wrapped_;
  HapticDevice& driver_;  // wrapped_ or device_
  HapticTick tick_;
  ToolCache trueCache_;  // for the true contacts of the plant
  Measurement measurement_;
  Command command_;
};

}  // namespace enamel
