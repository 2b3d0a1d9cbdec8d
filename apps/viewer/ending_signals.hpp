// SIGINT and SIGTERM as a wish that a loop looks at.
#pragma once

#include <array>
#include <csignal>

namespace enamel::viewer {

/// While it lives, SIGINT and SIGTERM only ask the loop to end. One at a time.
class EndingSignals {
 public:
  EndingSignals();
  ~EndingSignals();
  EndingSignals(const EndingSignals&) = delete;
  EndingSignals& operator=(const EndingSignals&) = delete;

  /// The signal that came, or 0.
  int caught() const;

 private:
  std::array<struct sigaction, 2> before_{};
};

}  // namespace enamel::viewer
