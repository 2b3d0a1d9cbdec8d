#include "program/interrupt.hpp"

#include <atomic>
#include <csignal>

namespace enamel::app {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM};
std::atomic<int> arrived{0};

void endNext(int signal) {
  std::signal(signal, SIG_DFL);
  arrived = signal;
}

void ignoreNext(int signal) {
  std::signal(signal, ignoreNext);  // Windows removes a handler before it calls it
  arrived = signal;
}

}  // namespace

InterruptGuard::InterruptGuard(Second second) {
  arrived = 0;
  for (int i = 0; i < 2; ++i)
    before_[i] = std::signal(kSignals[i], second == Second::endsProcess ? endNext : ignoreNext);
}

InterruptGuard::~InterruptGuard() {
  for (int i = 0; i < 2; ++i) std::signal(kSignals[i], before_[i]);
}

int interruption() noexcept { return arrived; }

}  // namespace enamel::app
