// The renderer contract: the frame of a tick in, joint torques out. A renderer knows no mechanism: what it needs of one
// is in the frame.
//
// Life of a renderer: construct (configure, throws) -> activate(period) -> step ... reset ... step -> deactivate.
// step() and reset() run in the real-time thread: no allocation, lock, exception or I/O. A renderer proposes a torque;
// what reaches the motors is decided behind it.
#pragma once

#include <cstddef>
#include <vector>

#include "enamel/core/status.hpp"
#include "enamel/render/frame.hpp"

namespace enamel {

/// A renderer. The state between ticks is explicit: a block of stateSize() bytes that can be copied out, compared and
/// put back, so that a run can be replayed from any tick.
class Renderer {
 public:
  Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  virtual ~Renderer() = default;

  /// Prepares for ticks of `period` s and resets. Throws Error: a period outside 1e-5 to 0.1 s, or one that this
  /// renderer was not designed for; the renderer is then not active. Realtime: no.
  void activate(double period);

  /// One tick: checkFrame(), then the controller. Statuses: ok; notFinite, outOfRange, stale (bad frame; outOfRange
  /// also for a number of joints that this renderer was not made for, and for rows that it reads and that are missing);
  /// notFinite for an answer that is not finite or has not one torque a joint; outOfRange for one beyond 1e6 N m or N;
  /// inactive. A torque beyond a motor's limit is cut by saturate(). On any but ok the torque is zero, the mode is
  /// fault and the state is unchanged. Realtime: yes.
  [[nodiscard]] Status step(const TickFrame& frame, TickOutput& output) noexcept;

  /// Back to the state after activate(). Realtime: yes.
  void reset() noexcept;

  /// Whether step() reads the joint-space inertia and TickFrame::rows: ticks then compute them.
  virtual bool needsInertia() const noexcept { return false; }

  /// Ends the ticks; step() answers inactive until the next activate(). Realtime: no.
  void deactivate() noexcept { active_ = false; }

  /// Size of the state, bytes; copies it out to and back from stateSize() bytes. Bytes that no state can have give that
  /// after reset(). Before a first activate(), and after one that has failed, the state is empty. Realtime: yes.
  std::size_t stateSize() const noexcept;
  void saveState(void* state) const noexcept;
  void loadState(const void* state) noexcept;

 protected:
  /// The bytes of a renderer's own state: plain data.
  struct StateBlock {
    void* data;
    std::size_t size;
  };

  virtual void prepare(double period) = 0;  // throws
  virtual Status render(const TickFrame& frame, TickOutput& output) noexcept = 0;
  virtual void resetState() noexcept = 0;
  virtual StateBlock stateBlock() noexcept = 0;
  virtual void stateLoaded() noexcept {}  // after the block was written

  /// Whether a block of doubles holds finite numbers only: for stateLoaded().
  static bool isFinite(const StateBlock& block) noexcept;

 private:
  bool active_ = false, isReady_ = false;  // isReady_: prepared, also while not active
  double lastTime_ = 0.0;                  // s
  std::vector<unsigned char> kept_;        // the state before a tick: put back where its answer is refused
};

/// Checks what every renderer checks first: joint vectors of one size; finite numbers, sizes that a device can have
/// (joints to 1000 rad or m, rates to 1000 a second, positions to 10 m, speeds to 100 m/s, gaps to 100 m, torques to
/// 1e6 N m, a Jacobian to 1000, its inverse to 1e9); a rotation matrix; unit
/// normals (to 1e-6); a count within capacity; a time later than `lastTime`; an age of at least 0. Returns ok,
/// notFinite, outOfRange or stale. Realtime: yes.
[[nodiscard]] Status checkFrame(const TickFrame& frame, double lastTime) noexcept;

/// Where a torque exceeds +-maxTorque, scales the part above `gravity` down, all joints by the same factor: the wrench
/// on the tool keeps its direction. Joints without a motor (maxTorque 0) get 0 and set no limit. True if one did.
/// Realtime: yes.
bool saturate(JointVector& torque, const JointVector& gravity, const JointVector& maxTorque) noexcept;

/// Translation of the tool's material at `arm` from the TCP (W, m) by a motion or velocity [v; w] of the platform at
/// the TCP. Realtime: yes.
Vec3 translationAt(const Vec6& motion, const Vec3& arm) noexcept;

/// Velocity of the tool's material at the contact relative to the obstacle's, W, m/s. Realtime: yes.
Vec3 contactVelocity(const Kinematics& kinematics, const Contact& contact) noexcept;

/// Gap of a contact at the time of the tick, m: the sampled gap plus its rate times the age of the sample. Realtime:
/// yes.
double predictedGap(const TickFrame& frame, const Contact& contact, double period) noexcept;

}  // namespace enamel
