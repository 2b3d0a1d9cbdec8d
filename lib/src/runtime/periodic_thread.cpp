#include "enamel/runtime/periodic_thread.hpp"

#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "runtime/system_thread.hpp"

namespace enamel {
namespace {

constexpr std::int64_t kSecond = 1000000000;  // ns

constexpr std::int64_t kLongestSleep = kSecond / 20;  // ns: the thread ends within this time

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
  stop();
  thread_.join();
}

void PeriodicThread::run(std::int64_t period, int priority) noexcept {
  system::nameThread("haptics");
  const bool granted = system::requestRealtime(priority);
  timing_.realtime.store(granted, std::memory_order_relaxed);

  std::int64_t deadline = system::clockNow() + period, before = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    if (const std::int64_t soon = system::clockNow() + kLongestSleep; soon < deadline) {
      system::sleepUntil(soon);
      continue;
    }
    system::sleepUntil(deadline);
    const std::int64_t begin = system::clockNow();
    timing_.wakeUp.add(seconds(begin - deadline));
    if (before > 0) timing_.interval.add(seconds(begin - before));
    before = begin;
    work_();
    const std::int64_t end = system::clockNow();
    timing_.compute.add(seconds(end - begin));
    timing_.periods.fetch_add(1, std::memory_order_relaxed);
    deadline += period;
    if (end > deadline) {
      const std::int64_t late = (end - deadline) / period + 1;
      timing_.missed.fetch_add(static_cast<std::uint64_t>(late), std::memory_order_relaxed);
      deadline += late * period;
    }
  }
  ended_.store(true, std::memory_order_release);
}

}  // namespace enamel
