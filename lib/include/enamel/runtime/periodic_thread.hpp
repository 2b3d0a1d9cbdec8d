// A thread that calls a function at a fixed rate, and says how well it kept it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "enamel/runtime/duration_histogram.hpp"

namespace enamel {

/// How a periodic thread has done so far. Written by the thread, read by any.
struct PeriodicTiming {
  DurationHistogram wakeUp;               ///< from the deadline to the call, s
  DurationHistogram interval;             ///< from the call before, s
  DurationHistogram compute;              ///< of the call, s
  std::atomic<std::uint64_t> periods{0};  ///< calls
  std::atomic<std::uint64_t> missed{0};   ///< deadlines that passed before the call for an earlier one had returned
  std::atomic<bool> realtime{false};      ///< the operating system granted the real-time class (SCHED_FIFO)
};

/// Calls `work` once a period from a thread of its own, from construction to destruction, which takes up to 50 ms.
///
/// Sleeps on CLOCK_MONOTONIC to absolute deadlines, so that errors do not add up. Deadlines that have passed are
/// skipped and counted, never made up for in a burst. Asks for SCHED_FIFO at `priority` and, where that is refused,
/// runs in the normal class with 1 ns of timer slack: see PeriodicTiming::realtime. `work` must not throw.
class PeriodicThread {
 public:
  /// Throws Error: a period outside 10 us to 10 s, or the thread cannot be started. Realtime: no.
  PeriodicThread(double period, std::function<void()> work, int priority = 80);
  ~PeriodicThread();
  PeriodicThread(const PeriodicThread&) = delete;
  PeriodicThread& operator=(const PeriodicThread&) = delete;

  const PeriodicTiming& timing() const noexcept { return timing_; }

 private:
  void run(std::int64_t period, int priority) noexcept;

  std::function<void()> work_;
  PeriodicTiming timing_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace enamel
