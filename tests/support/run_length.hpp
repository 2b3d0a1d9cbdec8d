// Length of a test: short by default, a tenth under a sanitizer (which is about ten times slower), full with
// ENAMEL_LONG=1 (`check.sh --long`). ENAMEL_SEED=N gives other random numbers (tests/attack/run.sh).
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace enamel::test {

inline bool longRun() {
  const char* value = std::getenv("ENAMEL_LONG");
  return value != nullptr && std::string_view(value) == "1";
}

#ifdef ENAMEL_SANITIZED
inline constexpr int kSlowdown = 10;
#else
inline constexpr int kSlowdown = 1;
#endif

inline std::uint64_t seed() {
  const char* value = std::getenv("ENAMEL_SEED");
  return value == nullptr ? 0 : std::strtoull(value, nullptr, 10);
}

inline int count(int shortRun, int fullRun) { return longRun() ? fullRun : std::max(1, shortRun / kSlowdown); }

}  // namespace enamel::test
