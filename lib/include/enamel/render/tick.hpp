// One haptic tick, from what a device measured to the torque that its motors get: the stages of frame.hpp in order.
#pragma once

#include <cstddef>
#include <limits>

#include "enamel/collision/contacts.hpp"
#include "enamel/device/haptic_device.hpp"
#include "enamel/render/drill.hpp"
#include "enamel/render/frame.hpp"
#include "enamel/render/guard.hpp"
#include "enamel/render/renderer.hpp"
#include "enamel/render/scene_motion.hpp"

namespace enamel {

/// Obstacles farther from the tool than this are no contacts of a tick, m.
inline constexpr double kContactMargin = 1e-3;

/// The tick of one device and one tool: owns the frame and what lasts from tick to tick; refers to mechanism, scene and
/// renderer, which must outlive it. Obstacles may move between ticks, none may be added.
/// Poses may come at the rate of the ticks or at that of frames: SceneMotion says what a tick sees of them.
///
/// A tick without a new sample (Measurement::age above 0, or a time stamp that repeats) keeps kinematics and contacts
/// of the last one; the renderer predicts, the drill waits. The guard lets GuardOptions::longestGap of them through.
/// While the guard lets nothing through, the renderer is reset at every tick: it starts again where it is let in.
class HapticTick {
 public:
  /// Activates the renderer for ticks of `guard.period` s. `start`: about where the platform is at the first tick (home
  /// where that is no pose or cannot be reached). Throws Error: as Renderer::activate(), Guard and
  /// makeToolTrack(). Realtime: no.
  HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer,
             const GuardOptions& guard, const Pose& start = Pose{});

  /// The same with guardFor(mechanism, period).
  HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer, double period,
             const Pose& start = Pose{})
      : HapticTick(mechanism, scene, tool, renderer, guardFor(mechanism, period), start) {}

  /// One tick. Statuses: those of Mechanism::track(), findContacts(), fillContactRows() and Renderer::step(); stale
  /// without any sample so far; stopped where the guard has latched a fault. Whatever the status, the command is what
  /// guard() let through. Realtime: yes.
  [[nodiscard]] Status operator()(const Measurement& measurement, Command& command) noexcept;

  /// From the next tick on this bur cuts what it is pressed against; null: none does. It must outlive the ticks. What
  /// it has cut is no part of the tick's state. Realtime: yes.
  void attach(Drill* drill) noexcept { drill_ = drill; }
  /// What is attached, null: nothing. Realtime: yes.
  Drill* drill() const noexcept { return drill_; }

  /// Goes on after a fault: guard and renderer start again, obstacles are at their stated poses. Realtime: yes.
  void reset() noexcept;

  /// Starts again as after construction, with the platform about at `start`. Realtime: yes.
  void restart(const Pose& start) noexcept;

  /// Everything about the last tick. Realtime: yes.
  const TickFrame& frame() const noexcept { return frame_; }
  const Guard& guard() const noexcept { return guard_; }
  const Renderer& renderer() const noexcept { return renderer_; }
  const SceneMotion& obstacles() const noexcept { return obstacles_; }

  /// Save and load all state needed to continue bit for bit, stateSize() bytes aligned as doubles, the renderer's last.
  /// The ticks that the guard keeps and the attached drill are not part of it. Invalid once an obstacle was moved or
  /// changed. Bytes that no state can have give one as after reset(). Realtime: yes.
  std::size_t stateSize() const noexcept { return numbers() * sizeof(double) + renderer_.stateSize(); }
  void saveState(void* state) const noexcept;
  void loadState(const void* state) noexcept;

 private:
  static constexpr double kNever = std::numeric_limits<double>::lowest();

  Measurement adjusted(const Measurement& measurement) const noexcept;
  Status tick(const Measurement& measurement) noexcept;
  Status sense(const Measurement& measurement) noexcept;
  Status findContacts(double time) noexcept;
  Status render(Status status) noexcept;
  void cut(double elapsed) noexcept;
  void placeAt(const Pose& start) noexcept;
  std::size_t numbers() const noexcept;

  const Mechanism& mechanism_;
  const Scene& scene_;
  Tool tool_;
  Renderer& renderer_;
  Guard guard_;
  SceneMotion obstacles_;
  ToolTrack track_;
  TickFrame frame_;
  double sampleTime_ = kNever;  // of the last sample, s
  Drill* drill_ = nullptr;
};

}  // namespace enamel
