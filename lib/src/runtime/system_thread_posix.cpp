#include <pthread.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): sigset_t is not in <csignal>
#include <sys/prctl.h>

#include <cerrno>
#include <ctime>

#include "runtime/system_thread.hpp"

namespace enamel::system {
namespace {

constexpr std::int64_t kSecond = 1000000000;  // ns

}  // namespace

std::int64_t clockNow() noexcept {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

void sleepUntil(std::int64_t deadline) noexcept {
  const timespec t{deadline / kSecond, deadline % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) continue;
}

bool requestRealtime(int priority) noexcept {
  prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);  // ns, for the normal class
  sched_param parameters{};
  parameters.sched_priority = priority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

void nameThread(const char* name) noexcept { pthread_setname_np(pthread_self(), name); }

// A broken pipe or a file size limit must be an error of write(), not the end of the process.
void makeWriteErrorsOrdinary() noexcept {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGPIPE);
  sigaddset(&signals, SIGXFSZ);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

}  // namespace enamel::system
