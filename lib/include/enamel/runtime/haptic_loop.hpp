// The loop of a device: one thread that measures, ticks and actuates, on absolute time.
//
// Made of what it refers to, and over when it is destroyed: nothing has to be started, stopped or freed by hand.
//   construction: open the device, lock memory, first measurement, start the thread
//   destruction:  ramp the rendered part out through the guard, join the thread, close the device
#pragma once

#include <atomic>
#include <cstdint>

#include "enamel/core/spsc_ring.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/periodic_thread.hpp"
#include "enamel/runtime/triple_buffer.hpp"

namespace enamel {

/// A tick of a loop: what was measured, asked for and commanded, why, and how long it took. Plain data.
struct LoopTick {
  std::uint64_t number = 0;   ///< ticks before this one
  Measurement measurement;    ///< that the tick was given
  Pose pose;                  ///< of the platform
  Vec6 twist = Vec6::Zero();  ///< of the platform, m/s, rad/s
  JointVector requested;      ///< by the renderer, N m or N
  Command command;            ///< what the guard made of it
  double normalForce = 0.0;   ///< as the renderer reports it, N
  RenderMode mode = RenderMode::free;
  GuardReason reason = GuardReason::none;  ///< why the command is not what was requested
  Status status = Status::ok;              ///< of the haptic tick
  Status device = Status::ok;              ///< of measure(), else of actuate()
  bool reset = false;                      ///< HapticTick::reset() came before it
  double compute = 0.0;                    ///< from the end of measure() to actuate(), s
  double age = 0.0;  ///< of the command: from the beginning of measure() to the end of actuate(), s
};

/// What sees every tick of a loop, on the loop's thread.
class TickSink {
 public:
  virtual ~TickSink() = default;

  /// After actuate(). `haptics` has the whole of TickFrame and TickOutput, and the guard. Must be Realtime: yes.
  virtual void tick(const LoopTick& tick, const HapticTick& haptics) noexcept = 0;
};

struct HapticLoopOptions {
  /// Of the thread, 1e-4 to 2e-3 s; 0: that of the ticks. A shorter one asks the device more often: ticks are made
  /// where there is a new measurement (a device that runs on its own clock).
  double period = 0.0;
  double firstMeasurement = 1.0;  ///< for how long the constructor waits for it, s
  int priority = 80;              ///< of SCHED_FIFO
  bool lockMemory = true;         ///< mlockall(), for as long as the loop lives
  TickSink* sink = nullptr;       ///< outlives the loop
};

/// What the thread of a HapticLoop does once a period; runs without a thread too, on simulated time.
///
/// Where the device has no new sample (stale), the tick predicts (Measurement::age), for up to GuardOptions::longestGap
/// periods of the ticks; then the guard's fault `late` ramps out. Any other status of measure() is the fault `device`;
/// LoopTick::device has the status. A device that is back does not end a fault: reset() does.
class LoopBody {
 public:
  /// Opens the device, waits for its first measurement, resets a tick that has run before. Throws Error: the guard is
  /// off; a period outside 1e-4 to 2e-3 s, or longer than that of the ticks; no measurement within `firstMeasurement`;
  /// as HapticDevice::open().
  LoopBody(HapticDevice& device, HapticTick& haptics, const HapticLoopOptions& options);
  ~LoopBody();  ///< HapticDevice::close()
  LoopBody(const LoopBody&) = delete;
  LoopBody& operator=(const LoopBody&) = delete;

  /// One period. True until the rendered part has ramped out after stop(). Realtime: yes.
  bool step() noexcept;

  /// From the next step on; reset() does nothing while the device is silent. Realtime: yes.
  void stop() noexcept { stopping_ = true; }
  void reset() noexcept { reset_ = true; }

  /// Of the last tick. Realtime: yes.
  const LoopTick& tick() const noexcept { return tick_; }

  const DurationHistogram& age() const noexcept { return age_; }
  std::uint64_t held() const noexcept { return heldAll_.load(std::memory_order_relaxed); }
  std::uint64_t unsent() const noexcept { return unsent_.load(std::memory_order_relaxed); }
  double period() const noexcept { return period_; }

 private:
  HapticDevice& device_;
  HapticTick& haptics_;
  TickSink* sink_;
  double period_, ticks_;  // of the thread, of the ticks, s
  LoopTick tick_;
  Measurement measurement_;
  Command command_;
  bool stopping_ = false, reset_ = false, first_ = true, faulty_ = false;
  double silence_ = 0.0;  // since the last measurement, s
  int left_ = 0;          // ticks until the rendered part is out
  DurationHistogram age_;
  std::atomic<std::uint64_t> heldAll_{0}, unsent_{0};
};

/// A thread with a LoopBody. Refers to device and haptics, which must outlive it and are its own as long as it lives.
/// Functions are for one other thread at a time.
class HapticLoop {
 public:
  /// The thread runs when it returns. Throws as LoopBody and PeriodicThread do; the device is closed again then.
  HapticLoop(HapticDevice& device, HapticTick& haptics, const HapticLoopOptions& options = {});

  /// stop(), and waits for the end: some 50 ms.
  ~HapticLoop();
  HapticLoop(const HapticLoop&) = delete;
  HapticLoop& operator=(const HapticLoop&) = delete;

  /// Ramps the rendered part out; what balances gravity stays until the loop is destroyed. Both: false where 16
  /// commands are waiting already. Realtime: yes.
  bool stop() noexcept { return commands_.push(LoopCommand::stop); }

  /// Goes on after a fault of the guard; does nothing while the device is silent.
  bool reset() noexcept { return commands_.push(LoopCommand::reset); }

  /// Whether the rendered part is out after stop(). Realtime: yes.
  bool stopped() const noexcept { return stopped_.load(std::memory_order_acquire); }

  /// Moves latest() to the newest tick; false: there is none since the last call. Realtime: yes.
  bool refresh() noexcept { return state_.refresh(); }
  const LoopTick& latest() const noexcept { return state_.latest(); }

  /// Any thread, Realtime: yes. Wake-up error, compute time of all that a period does, missed periods, whether the
  /// real-time class was granted; age of the commands.
  const PeriodicTiming& timing() const noexcept { return thread_.timing(); }
  const DurationHistogram& age() const noexcept { return body_.age(); }
  std::uint64_t held() const noexcept { return body_.held(); }      ///< periods without a new measurement
  std::uint64_t unsent() const noexcept { return body_.unsent(); }  ///< commands that actuate() refused
  bool memoryLocked() const noexcept { return lock_.held; }

 private:
  enum class LoopCommand : std::uint8_t { stop, reset };
  struct MemoryLock {
    explicit MemoryLock(bool wanted) noexcept;
    ~MemoryLock();
    bool held = false;
  };

  void period() noexcept;

  MemoryLock lock_;
  LoopBody body_;
  std::atomic<bool> stopped_{false};
  SpscRing<LoopCommand, 16> commands_;
  TripleBuffer<LoopTick> state_;
  PeriodicThread thread_;  // last: ends before what it uses
};

}  // namespace enamel
