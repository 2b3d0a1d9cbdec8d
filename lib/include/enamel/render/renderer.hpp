// The renderer contract: step() reads the frame of a tick and returns joint torques. A renderer does not know the
// mechanism. The frame contains all that a renderer needs of it.
//
// Life of a renderer: construct (configure, throws) -> activate(period) -> step ... reset ... step -> deactivate.
// step() and reset() run in the real-time thread: no allocation, lock, exception or I/O. A renderer proposes a torque.
// The guard (guard.hpp) then decides which torque reaches the motors.
#pragma once

#include <cstddef>
#include <vector>

#include "enamel/core/status.hpp"
#include "enamel/device/haptic_device.hpp"
#include "enamel/render/frame.hpp"

namespace enamel {

/// A renderer computes joint torques from frames. The state between ticks is explicit: a block of stateSize() bytes. A
/// host can save, compare and restore it, and so replay a run from any tick.
class Renderer {
 public:
  Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  virtual ~Renderer() = default;

  /// Prepare for ticks of `period` s and reset the state. Throws Error if the period is outside 1e-5 to 0.1 s, or if
  /// this renderer was not designed for that period. The renderer is then not active. Realtime: no.
  void activate(double period);

  /// Check the frame with checkFrame(), then compute the torque of one tick. saturate() reduces a torque that exceeds a
  /// motor's limit.
  ///
  /// - ok: `output` is valid.
  /// - inactive: activate() was not called, or failed.
  /// - notFinite: the frame or the computed output is not finite, or the output does not have one torque per joint.
  /// - outOfRange: a value or size of the frame is out of range, the number of joints does not match, or required rows
  ///   are missing.
  /// - outOfRange: the computed torque or force exceeds 1e6 N m or N.
  /// - stale: the time of the frame did not advance.
  ///
  /// With any status but ok the torque is zero, the mode is `fault` and the state is unchanged. Realtime: yes.
  [[nodiscard]] Status step(const TickFrame& frame, TickOutput& output) noexcept;

  /// Restore the state after activate(). Realtime: yes.
  void reset() noexcept;

  /// Return whether step() reads the joint-space inertia and TickFrame::rows. If so, each tick computes them.
  virtual bool needsInertia() const noexcept { return false; }

  /// Return the delay of the motors, as far as the renderer knows it. Realtime: yes.
  virtual Delay delay() const noexcept { return {}; }

  /// Deactivate: step() then returns `inactive` until the next activate(). Realtime: no.
  void deactivate() noexcept { active_ = false; }

  /// Return the size of the state, in bytes. saveState() writes the state to a block of that size, and loadState()
  /// reads it from such a block. An invalid block gives the state after reset(). Before the first activate(), and after
  /// a failed one, the size is 0. Realtime: yes.
  std::size_t stateSize() const noexcept;
  void saveState(void* state) const noexcept;
  void loadState(const void* state) noexcept;

 protected:
  /// The memory block of a renderer's own state: plain data.
  struct StateBlock {
    void* data;
    std::size_t size;
  };

  virtual void prepare(double period) = 0;  // throws
  virtual Status render(const TickFrame& frame, TickOutput& output) noexcept = 0;
  virtual void resetState() noexcept = 0;
  virtual StateBlock stateBlock() noexcept = 0;
  virtual void stateLoaded() noexcept {}  // called after the block was written

  /// Return whether a block of doubles contains finite numbers only. For use in stateLoaded().
  static bool isFinite(const StateBlock& block) noexcept;

 private:
  bool active_ = false, isReady_ = false;  // isReady_: prepared; stays true after deactivate()
  double lastTime_ = 0.0;                  // s
  std::vector<unsigned char> kept_;        // state before a tick; restored if its output is rejected
};

/// Check a frame as Renderer::step() does before it renders. The checks run in this order:
///
/// - outOfRange: sizes of vectors or matrices do not match, the number of contacts is not in 0 to kMaxContacts, or the
///   age is negative.
/// - notFinite: a number is NaN or infinite.
/// - outOfRange: a value is outside its limit (see below), the rotation matrix is invalid, or a material is invalid.
/// - stale: the time is not greater than `lastTime`, in s.
///
/// Limits of Euclidean (Frobenius) norms:
///
/// - joint coordinates 1000 rad or m, joint rates 1000 rad/s or m/s, torques 1e6 N m or N;
/// - positions 10 m, linear velocities 100 m/s, angular velocity 1000 rad/s;
/// - Jacobian 1000, its inverse 1e9.
///
/// A gap may be up to +-100 m. A normal must have unit length (its square within 1e-6). Realtime: yes.
[[nodiscard]] Status checkFrame(const TickFrame& frame, double lastTime) noexcept;

/// Reduce a torque to +-maxTorque. Scale the part of it above `gravity` by one factor for all joints, so the wrench on
/// the tool keeps its direction. Joints without a motor (maxTorque 0) get 0 and do not affect the factor. Return
/// whether a limit reduced the torque. Realtime: yes.
bool saturate(JointVector& torque, const JointVector& gravity, const JointVector& maxTorque) noexcept;

/// Return the translation of the tool's material at `arm` (from the TCP, W, m). `motion` is a displacement or velocity
/// [v; w] of the platform at the TCP. Realtime: yes.
Vec3 translationAt(const Vec6& motion, const Vec3& arm) noexcept;

/// Return the velocity of the tool's material at the contact relative to the obstacle, W, m/s. Realtime: yes.
Vec3 contactVelocity(const Kinematics& kinematics, const Contact& contact) noexcept;

/// Return the gap of a contact at the time of the tick, m: the sampled gap plus its rate times the age of the sample.
/// Realtime: yes.
double predictedGap(const TickFrame& frame, const Contact& contact, double period) noexcept;

}  // namespace enamel
