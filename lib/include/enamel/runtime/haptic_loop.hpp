// The loop of a device: one thread that measures, ticks and actuates, on absolute time. The life of the object is the
// life of the loop:
//
//   construction: open the device, lock memory, take the first measurement, start the thread
//   destruction:  ramp the rendered part out through the guard, join the thread, close the device
#pragma once

#include <atomic>
#include <cstdint>

#include "enamel/core/spsc_ring.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/periodic_thread.hpp"
#include "enamel/runtime/triple_buffer.hpp"

namespace enamel {

/// Record of one tick of a loop: measurement, requested torque, command, reason, durations. Plain data.
struct LoopTick {
  std::uint64_t number = 0;   ///< number of ticks before this one
  Measurement measurement;    ///< input of the tick
  Pose pose;                  ///< of the platform
  Vec6 twist = Vec6::Zero();  ///< of the platform, m/s, rad/s
  JointVector requested;      ///< torque requested by the renderer, N m or N
  Command command;            ///< as the guard changed it
  double normalForce = 0.0;   ///< as the renderer reports it, N
  RenderMode mode = RenderMode::free;
  GuardReason reason = GuardReason::none;  ///< why the command differs from the requested torque
  Status status = Status::ok;              ///< of the haptic tick
  Status device = Status::ok;              ///< of measure() or, if that was ok, of actuate()
  bool reset = false;                      ///< HapticTick::reset() was called before this tick
  double compute = 0.0;                    ///< from the end of measure() to actuate(), s
  double age = 0.0;  ///< age of the command: from the start of measure() to the end of actuate(), s
};

/// Fill in what a tick computed: pose, twist, requested torque, force, mode, reason. Realtime: yes.
void describe(const HapticTick& haptics, LoopTick& tick) noexcept;

/// Receiver of every tick of a loop, on the loop's thread.
class TickSink {
 public:
  virtual ~TickSink() = default;

  /// Called once on the thread of the loop, before its first period. Must be Realtime: yes.
  virtual void atStart() noexcept {}

  /// Called before each tick. It may change the measurement, for example `enabled`. Must be Realtime: yes.
  virtual void before(Measurement& measurement) noexcept { (void)measurement; }

  /// Called when actuate() refused a command. Must be Realtime: yes.
  virtual void unsent() noexcept {}

  /// Called after actuate(). `haptics` has the TickFrame with its output, and the guard. Must be Realtime: yes.
  virtual void tick(const LoopTick& tick, const HapticTick& haptics) noexcept = 0;
};

struct HapticLoopOptions {
  /// Period of the thread, 1e-4 to 2e-3 s; 0: that of the ticks. A shorter one polls the device more often, for a
  /// device with its own clock. A tick then runs when there is a new measurement.
  double period = 0.0;
  double firstMeasurement = 1.0;  ///< longest wait of the constructor for a measurement, s
  int priority = 80;              ///< SCHED_FIFO priority
  bool lockMemory = true;         ///< lock memory with mlockall() during the life of the loop
  TickSink* sink = nullptr;       ///< must outlive the loop
};

/// The work of a HapticLoop in one period. It also runs without a thread, on simulated time.
///
/// If the device has no new sample (stale), the tick predicts (Measurement::age). This lasts for up to
/// GuardOptions::longestGap tick periods. Then the guard's fault `late` ramps the torque out. Any other status of
/// measure() is the fault `device`; LoopTick::device has the status. The fault remains when the device returns, until
/// reset().
class LoopBody {
 public:
  /// Open the device and wait for its first measurement. Reset a tick that has run before. Throws Error as
  /// HapticDevice::open(), and in these cases:
  ///
  /// - the guard is off;
  /// - the period is outside 1e-4 to 2e-3 s, or longer than that of the ticks;
  /// - no measurement arrives within `firstMeasurement`.
  LoopBody(HapticDevice& device, HapticTick& haptics, const HapticLoopOptions& options);
  ~LoopBody();  ///< calls HapticDevice::close()
  LoopBody(const LoopBody&) = delete;
  LoopBody& operator=(const LoopBody&) = delete;

  /// Run one period. Return true until the rendered part has ramped out after stop(). Realtime: yes.
  bool step() noexcept;

  /// Stop, or reset the tick, at the next step. reset() has no effect while the device does not respond. Realtime: yes.
  void stop() noexcept { stopping_ = true; }
  void reset() noexcept { reset_ = true; }

  /// Return the last tick. age() returns the ages of commands, held() the number of periods without a measurement.
  /// unsent() returns the number of commands that actuate() refused, period() the period of the thread, s. Realtime:
  /// yes.
  const LoopTick& tick() const noexcept { return tick_; }

  const DurationHistogram& age() const noexcept { return age_; }
  std::uint64_t held() const noexcept { return heldAll_.load(std::memory_order_relaxed); }
  std::uint64_t unsent() const noexcept { return unsent_.load(std::memory_order_relaxed); }
  double period() const noexcept { return period_; }

  /// Return the name of the function that step() is calling now; null: none. Threads: any. Realtime: yes.
  const char* calling() const noexcept { return calling_.load(std::memory_order_relaxed); }

 private:
  Status send() noexcept;

  HapticDevice& device_;
  HapticTick& haptics_;
  TickSink* sink_;
  double period_, ticks_;  // of the thread; of the ticks; s
  LoopTick tick_;
  Measurement measurement_;
  Command command_;
  bool stopping_ = false, reset_ = false, first_ = true, faulty_ = false;
  double silence_ = 0.0;  // time since the last measurement, s
  int left_ = 0;          // ticks until the rendered part has ramped out
  DurationHistogram age_;
  std::atomic<std::uint64_t> heldAll_{0}, unsent_{0};
  std::atomic<const char*> calling_{nullptr};
};

/// A thread with a LoopBody. It refers to device and haptics, which must outlive it. No other code may use them while
/// it lives. Threads: one other thread at a time may call its functions, unless stated otherwise.
class HapticLoop {
 public:
  /// Start the thread. It runs when the constructor returns. Throws Error as LoopBody and PeriodicThread; the device is
  /// then closed again.
  HapticLoop(HapticDevice& device, HapticTick& haptics, const HapticLoopOptions& options = {});

  /// Stop and wait for the end, about 50 ms. If a function of the device, a renderer or a hook does not return for 2 s,
  /// one line on stderr names it. The destructor then waits further.
  ~HapticLoop();
  HapticLoop(const HapticLoop&) = delete;
  HapticLoop& operator=(const HapticLoop&) = delete;

  /// Ramp the rendered part out. The torque that balances gravity remains until the loop is destroyed. stop() and
  /// reset() return false if 16 commands are waiting. Realtime: yes.
  bool stop() noexcept { return commands_.push(LoopCommand::stop); }

  /// Continue after a fault of the guard. Has no effect while the device does not respond.
  bool reset() noexcept { return commands_.push(LoopCommand::reset); }

  /// Return whether the rendered part has ramped out after stop(). Realtime: yes.
  bool stopped() const noexcept { return stopped_.load(std::memory_order_acquire); }

  /// Move latest() to the newest tick. Return false if no tick was added since the last call. Realtime: yes.
  bool refresh() noexcept { return state_.refresh(); }
  const LoopTick& latest() const noexcept { return state_.latest(); }

  /// Return timing: wake-up error, compute time of a whole period, missed periods, and whether the real-time class was
  /// granted. age() returns the age of commands. Threads: any. Realtime: yes.
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
  PeriodicThread thread_;  // last member: ends before the members that it uses
};

}  // namespace enamel
