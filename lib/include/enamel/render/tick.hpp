// One haptic tick, from a measurement to the torque of the motors. It runs the stages of frame.hpp in order.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>

#include "enamel/device/haptic_device.hpp"
#include "enamel/render/drill.hpp"
#include "enamel/render/frame.hpp"
#include "enamel/render/guard.hpp"
#include "enamel/render/guidance.hpp"
#include "enamel/render/renderer.hpp"
#include "enamel/render/tap_transient.hpp"
#include "enamel/render/tick_scene.hpp"

namespace enamel {

/// The ticks of one device and one tool. The object owns the frame and all data that last from tick to tick. It refers
/// to mechanism, scene and renderer, which must outlive it. Obstacles may move between ticks. A host may set their
/// poses at every tick or at frame rate. SceneMotion computes the poses that a tick uses. exchange() brings another
/// scene.
///
/// A tick has no new sample if Measurement::age is above 0 or the time stamp repeats. It then keeps kinematics and
/// contacts of the last tick. The renderer predicts, and the drill does not cut. The guard accepts up to
/// GuardOptions::longestGap such ticks in a row. While the guard blocks the renderer, each tick resets it.
class HapticTick {
 public:
  /// Activate the renderer for ticks of `guard.period` s. `start` is the approximate pose of the platform at the first
  /// tick. An invalid or unreachable `start` is replaced by the home pose. Throws Error as Renderer::activate(), Guard
  /// and makeToolTrack(). Realtime: no.
  HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer,
             const GuardOptions& guard, const Pose& start = Pose{});

  /// Do the same with guardFor(mechanism, period).
  HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer, double period,
             const Pose& start = Pose{})
      : HapticTick(mechanism, scene, tool, renderer, guardFor(mechanism, period), start) {}

  /// Run one tick and write the command of the motors. With every status the command is the torque that the guard
  /// admits.
  ///
  /// - stale: there was no sample yet.
  /// - stopped: the guard has latched a fault.
  /// - Other statuses are those of Mechanism::track(), followContacts(), fillContactRows() and Renderer::step().
  ///
  /// Realtime: yes.
  [[nodiscard]] Status operator()(const Measurement& measurement, Command& command) noexcept;

  /// Attach a bur. From the next tick on, it cuts the material that it is pressed against. Null detaches it. The bur
  /// must outlive the ticks. The material that it has cut is not part of the tick's state. Realtime: yes.
  void attach(Drill* drill) noexcept { drill_ = drill; }
  /// Return the attached bur, or null. Realtime: yes.
  Drill* drill() const noexcept { return drill_; }

  /// Continue with another scene and tool from the next tick on. `other` then has the old ones. Obstacles that both
  /// scenes have continue their motion (TickScene::takeOver()). The state is then that of the new scene. Realtime: yes.
  void exchange(TickScene& other) noexcept;

  /// Continue with another renderer, which was activated for the same period; it is reset. It must outlive the ticks.
  /// Realtime: yes.
  void select(Renderer& renderer) noexcept;

  /// Add a wrench (W at the TCP, N and N m) to every tick's rendered torque: an effect of the application, such as
  /// vibration. The renderer takes account of it also if the device does not report the torque. The guard limits the
  /// sum. Not finite numbers count as zero. Realtime: yes.
  void setEffect(const Vec6& wrench) noexcept { effect_ = wrench.allFinite() ? wrench : Vec6(Vec6::Zero()); }

  /// Give a movable obstacle an impulse of another device's tool, as SceneMotion::push(). Realtime: yes.
  void push(int obstacle, const Vec6& impulse) noexcept { scene_.motion().push(obstacle, impulse); }

  /// Set the force of the gripper's motor, N, opening it. The guard scales it as the rendered torque: zero after
  /// a fault. Not finite numbers count as zero. Realtime: yes.
  void setGripper(double force) noexcept { gripper_ = std::isfinite(force) ? force : 0.0; }

  /// Continue after a fault: reset guard and renderer, and put obstacles at their stated poses. Realtime: yes.
  void reset() noexcept;

  /// Restart as after construction, with the platform near `start`. Realtime: yes.
  void restart(const Pose& start) noexcept;

  /// Return the data of the last tick. Realtime: yes.
  const TickFrame& frame() const noexcept { return frame_; }
  const Guard& guard() const noexcept { return guard_; }
  const Renderer& renderer() const noexcept { return *renderer_; }
  const TickScene& scene() const noexcept { return scene_; }
  const TapTransient& tap() const noexcept { return tap_; }
  const Guidance& guidance() const noexcept { return guidance_; }

  /// Save and load all state needed to continue bit for bit: stateSize() bytes, aligned as doubles, the renderer's
  /// last. The guard's record of past ticks and the attached drill are not part of it. A saved state becomes invalid
  /// when an obstacle is moved or changed. Bytes of an invalid state give the state after reset(). Realtime: yes.
  std::size_t stateSize() const noexcept { return numbers() * sizeof(double) + renderer_->stateSize(); }
  void saveState(void* state) const noexcept;
  void loadState(const void* state) noexcept;

 private:
  static constexpr double kNever = std::numeric_limits<double>::lowest();

  PartRange bur() const noexcept { return drill_ != nullptr && drill_->spins() ? drill_->parts() : PartRange(); }
  bool hasGuides() const noexcept { return scene_.scene().guides() != nullptr; }
  bool needsInertia() const noexcept { return renderer_->needsInertia() || scene_.hasTaps(); }
  Measurement adjusted(const Measurement& measurement) const noexcept;
  Status tick(const Measurement& measurement) noexcept;
  Status sense(const Measurement& measurement) noexcept;
  Status findContacts(double time, double elapsed) noexcept;
  Status render(Status status) noexcept;
  double share() const noexcept;
  Vec3 wallForce() const noexcept;
  void react() noexcept;
  void cut(double elapsed, bool isStopped) noexcept;
  void placeAt(const Pose& start) noexcept;
  std::size_t numbers() const noexcept;

  const Mechanism& mechanism_;
  TickScene scene_;
  Renderer* renderer_;
  Guard guard_;
  TickFrame frame_;
  TapTransient tap_;
  Guidance guidance_;
  Vec6 effect_ = Vec6::Zero();
  Vec6 added_ = Vec6::Zero();   // effect and guides of the last tick
  double gripper_ = 0.0;        // N
  double sampleTime_ = kNever;  // of the last sample, s
  Drill* drill_ = nullptr;
};

}  // namespace enamel
