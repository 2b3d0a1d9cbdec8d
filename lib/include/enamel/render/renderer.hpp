// The renderer contract: the mechanism's motion and the contacts in, joint torques out, once a tick. A renderer knows
// no mechanism: what it needs of one stands in the Kinematics.
//
// Life of a renderer: construct (configure, throws) -> activate(period) -> step ... reset ... step -> deactivate.
// step() and reset() run in the real-time thread: no allocation, lock, exception or I/O. A renderer proposes a torque;
// what reaches the motors is decided behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "enamel/collision/contact.hpp"
#include "enamel/core/status.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// What is known at a tick. All in SI; poses, twists and contacts in W. Joint vectors have n entries.
///
/// A tick without a new sample has `age` k > 0. Kinematics and contacts are then those of the last sample, k periods
/// old. A renderer predicts from them and answers with a torque as at any other tick; it neither restarts nor learns.
/// The time between two ticks may differ from the period: a sample may be late, and where ticks are missing, the last
/// torque acted until this one.
struct TickInput {
  double time = 0.0;         ///< s, strictly increasing
  int age = 0;               ///< periods since the sample; 0: a new sample
  Kinematics kinematics;     ///< measured; the inertia where the renderer asked for it
  ContactSnapshot contacts;  ///< at the pose; the deepest first
  JointVector maxTorque;     ///< limit of every motor, N m or N
  JointVector applied;       ///< torque that really acted since the last tick, N m or N; empty: the device cannot tell
};

/// What a renderer is doing.
enum class RenderMode : std::uint8_t {
  free = 0,  ///< no contact: gravity is balanced
  contact,   ///< a wall is rendered
  fault,     ///< the input was unusable: see the status
};

/// Name of a mode in plain words. Realtime: yes.
const char* toString(RenderMode mode) noexcept;

/// What a renderer asks for.
struct TickOutput {
  JointVector torque;  ///< N m or N, gravity included; finite and within +-maxTorque whatever the status
  RenderMode mode = RenderMode::fault;
  bool saturated = false;    ///< a motor's limit cut the torque
  double normalForce = 0.0;  ///< of the wall on the tool along the deepest contact's normal, N
};

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

  /// One tick: checkInput(), then the renderer's law. Statuses: ok; notFinite, outOfRange, stale (bad input; outOfRange
  /// also for a number of joints that this renderer was not made for); notFinite for an answer that is not finite or
  /// has not one torque a joint; outOfRange for one beyond 1e6 N m or N; inactive. A torque beyond a motor's limit is
  /// cut by saturate(). On any but ok the torque is zero, the mode is fault and the state is unchanged. Realtime: yes.
  [[nodiscard]] Status step(const TickInput& input, TickOutput& output) noexcept;

  /// Back to the state after activate(). Realtime: yes.
  void reset() noexcept;

  /// Whether step() reads the joint-space inertia: ticks then compute it.
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
  virtual Status render(const TickInput& input, TickOutput& output) noexcept = 0;
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
/// 1e6 N m); a rotation matrix; unit normals (to 1e-6); a count within capacity; a time later than
/// `lastTime`; an age of at least 0. Returns
/// ok, notFinite, outOfRange or stale. Realtime: yes.
[[nodiscard]] Status checkInput(const TickInput& input, double lastTime) noexcept;

/// Where a torque is beyond +-maxTorque, makes the part beyond `gravity` smaller, all joints by the same factor: the
/// wrench on the tool keeps its direction. True if one was. Realtime: yes.
bool saturate(JointVector& torque, const JointVector& gravity, const JointVector& maxTorque) noexcept;

/// Translation of the tool's material at `arm` from the TCP (W, m) by a motion or velocity [v; w] of the platform at
/// the TCP. Realtime: yes.
Vec3 translationAt(const Vec6& motion, const Vec3& arm) noexcept;

/// Velocity of the tool's material at the contact relative to the obstacle's, W, m/s. Realtime: yes.
Vec3 contactVelocity(const Kinematics& kinematics, const Contact& contact) noexcept;

/// Gap of a contact at the time of the tick, m: the sampled gap plus its rate times the age of the sample. Realtime:
/// yes.
double predictedGap(const TickInput& input, const Contact& contact, double period) noexcept;

}  // namespace enamel
