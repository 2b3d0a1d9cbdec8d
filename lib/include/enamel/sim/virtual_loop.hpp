// The closed loop on the virtual device, tick by tick: measure -> haptic tick -> actuate -> integrate.
#pragma once

#include <cstdint>

#include "enamel/render/tick.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// What determines a loop, but for the person.
struct LoopSetup {
  Pose start;  ///< at rest
  Scene scene = flatWall();
  Tool tool;
  EncoderOptions encoders;
  Delay delay;
  double period = 1e-3;  ///< Ts, s
  int substeps = 1;      ///< integration steps a tick
  Integrator integrator = Integrator::rungeKutta4;
  std::uint64_t seed = 1;
  std::uint32_t run = 0;  ///< number of the random stream
};

/// Checks a setup. Throws Error: a scene without obstacles; substeps outside 1 to 1000; a period outside (0, 0.1] s;
/// delays outside 0 to kMaxDelay ticks or low > high; a cutoff that is not positive. Realtime: no.
void checkLoop(const LoopSetup& setup);

/// What happened at one tick. State and measurement are those before the tick's torque acts.
struct TickRecord {
  std::uint64_t tick = 0;
  double time = 0.0;             ///< s
  Pose pose;                     ///< of the plant
  Vec6 twist = Vec6::Zero();     ///< of the plant
  Vec6 q = Vec6::Zero();         ///< measured, rad
  Vec6 command = Vec6::Zero();   ///< of the renderer, N m
  Vec6 torque = Vec6::Zero();    ///< that acts during this tick, N m
  Vec6 person = Vec6::Zero();    ///< wrench of the person at the TCP at the beginning of this tick, N, N m
  Vec6 rendered = Vec6::Zero();  ///< wrench of the motors on the tool beyond gravity during this tick, N, N m
  Contact nearest;               ///< of the plant's tool with the scene, near or far
  double normalForce = 0.0;      ///< of the wall on the tool, as the renderer reports it, N
  RenderMode mode = RenderMode::free;
  bool saturated = false;
  Status status = Status::ok;  ///< of the haptic tick
};

/// The loop: a plant, its encoders and motors, and a renderer that it activates. Plain data but for references to
/// `model` (the plant, also the model for forward kinematics) and `renderer`, which must outlive it.
class VirtualLoop {
 public:
  /// Throws Error: as checkLoop() and Renderer::activate(), or the start pose is not reachable. Realtime: no.
  VirtualLoop(const TauModel& model, Renderer& renderer, const LoopSetup& setup);

  /// One tick under load(time, pose, twist), the person's wrench on the platform at the TCP (N, N m). Fills `record`
  /// with what happened before and during the tick. Returns ok, or the status of the configuration that the plant could
  /// not leave; the loop then stays where it is. Realtime: yes, if `load` is.
  template <typename Load>
  [[nodiscard]] Status tick(const Load& load, TickRecord& record) noexcept {
    if (const Status status = begin(record); status != Status::ok) return status;
    record.person = load(record.time, record.pose, record.twist);
    const double step = setup_.period / setup_.substeps;
    for (int i = 0; i < setup_.substeps; ++i) {
      const double time = record.time + i * step;
      if (const Status status = stepMotion(setup_.integrator, model_, time, step, record.torque, load, state_);
          status != Status::ok)
        return status;
    }
    ++tick_;
    return Status::ok;
  }

  /// What the renderer saw at the last tick. Realtime: yes.
  const TickInput& input() const noexcept { return input_; }

  /// Time of the next tick, s. Realtime: yes.
  double time() const noexcept { return static_cast<double>(tick_) * setup_.period; }

  /// State of the plant now. Realtime: yes.
  const DeviceState& state() const noexcept { return state_; }

 private:
  Status begin(TickRecord& record) noexcept;

  const TauModel& model_;
  Renderer& renderer_;
  LoopSetup setup_;
  RandomStream random_;
  DeviceState state_;
  TauConfiguration plant_;
  TickMemory memory_;        // of the measured side
  ToolCache plantContacts_;  // of the true side
  Encoders encoders_;
  Motors motors_;
  TickInput input_;
  TickOutput output_;
  std::uint64_t tick_ = 0;
};

}  // namespace enamel
