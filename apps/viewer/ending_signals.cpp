#include "ending_signals.hpp"

namespace enamel::viewer {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM};
volatile std::sig_atomic_t gCaught = 0;

}  // namespace

EndingSignals::EndingSignals() {
  gCaught = 0;
  struct sigaction action {};
  action.sa_handler = [](int number) { gCaught = number; };
  action.sa_flags = SA_RESTART;
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before_[i]);
}

EndingSignals::~EndingSignals() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

int EndingSignals::caught() const { return gCaught; }

}  // namespace enamel::viewer
