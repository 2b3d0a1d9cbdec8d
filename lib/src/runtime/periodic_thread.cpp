#include "enamel/runtime/periodic_thread.hpp"

#include <pthread.h>
#include <sys/prctl.h>

#include <cerrno>
#include <cmath>
#include <ctime>
#include <string>
#include <system_error>
#include <utility>

#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr std::int64_t kSecond = 1000000000;  // ns

std::int64_t now() noexcept {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

constexpr std::int64_t kLongestSleep = kSecond / 20;  // ns: the thread ends within this time

void sleepUntil(std::int64_t deadline) noexcept {
  const timespec t{deadline / kSecond, deadline % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) continue;
}

double seconds(std::int64_t duration) noexcept { return 1e-9 * static_cast<double>(duration); }

}  // namespace

PeriodicThread::PeriodicThread(double period, std::function<void()> work, int priority) : work_(std::move(work)) {
  if (!(period >= 1e-5 && period <= 10.0))
    throw Error("periodic thread: the period is " + formatNumber(period) + " s, must be in 1e-05 to 10 s");
  try {
    thread_ = std::thread(&PeriodicThread::run, this, std::llround(period * kSecond), priority);
  } catch (const std::system_error& error) {
    throw Error(std::string("periodic thread: cannot start: ") + error.what());
  }
}

PeriodicThread::~PeriodicThread() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void PeriodicThread::run(std::int64_t period, int priority) noexcept {
  pthread_setname_np(pthread_self(), "haptics");
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
  sched_param parameters{};
  parameters.sched_priority = priority;
  const bool granted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
  timing_.realtime.store(granted, std::memory_order_relaxed);

  std::int64_t deadline = now() + period, before = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    if (const std::int64_t soon = now() + kLongestSleep; soon < deadline) {
      sleepUntil(soon);
      continue;
    }
    sleepUntil(deadline);
    const std::int64_t begin = now();
    timing_.wakeUp.add(seconds(begin - deadline));
    if (before > 0) timing_.interval.add(seconds(begin - before));
    before = begin;
    work_();
    const std::int64_t end = now();
    timing_.compute.add(seconds(end - begin));
    timing_.periods.fetch_add(1, std::memory_order_relaxed);
    deadline += period;
    if (end > deadline) {
      const std::int64_t late = (end - deadline) / period + 1;
      timing_.missed.fetch_add(static_cast<std::uint64_t>(late), std::memory_order_relaxed);
      deadline += late * period;
    }
  }
}

}  // namespace enamel
