// A thread that calls a function at a fixed rate and measures how accurately it does so.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "enamel/runtime/duration_histogram.hpp"

namespace enamel {

/// Timing of a periodic thread. The thread writes it; any thread may read it.
struct PeriodicTiming {
  DurationHistogram wakeUp;               ///< from the deadline to the call, s
  DurationHistogram interval;             ///< from one call to the next, s
  DurationHistogram compute;              ///< duration of the call, s
  std::atomic<std::uint64_t> periods{0};  ///< number of calls
  /// Number of deadlines that passed while an earlier call was running.
  std::atomic<std::uint64_t> missed{0};
  std::atomic<bool> realtime{false};  ///< the operating system granted real-time priority
};

/// Call `work` once per period in a separate thread, from construction to destruction. Destruction takes up to 50 ms.
///
/// The thread sleeps on CLOCK_MONOTONIC until absolute deadlines, so errors do not accumulate. It skips and counts
/// missed deadlines and does not repeat them. It requests SCHED_FIFO at `priority`. If that is refused, it runs in the
/// normal class with 1 ns of timer slack; see PeriodicTiming::realtime. Windows: lib/docs/windows.md. `work` must not
/// throw.
class PeriodicThread {
 public:
  /// Throws Error if the period is outside 10 us to 10 s, or the thread cannot start. Realtime: no.
  PeriodicThread(double period, std::function<void()> work, int priority = 80);
  ~PeriodicThread();
  PeriodicThread(const PeriodicThread&) = delete;
  PeriodicThread& operator=(const PeriodicThread&) = delete;

  const PeriodicTiming& timing() const noexcept { return timing_; }

  /// Request the end after the present call, without waiting. ended() returns whether the thread has ended. Realtime:
  /// yes.
  void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  bool ended() const noexcept { return ended_.load(std::memory_order_acquire); }

 private:
  void run(std::int64_t period, int priority) noexcept;

  std::function<void()> work_;
  PeriodicTiming timing_;
  std::atomic<bool> stop_{false}, ended_{false};
  std::thread thread_;
};

}  // namespace enamel
