// A functional test waits for a state, never for a fixed time.
#pragma once

#include <chrono>
#include <thread>

namespace enamel::test {

/// Return true as soon as a condition holds; false after 15 min, far longer than a loaded machine needs.
template <typename Condition>
bool eventually(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(15);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace enamel::test
