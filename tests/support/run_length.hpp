// How much a test does: a short run by default, the full one with ENAMEL_LONG=1 (`check.sh --long`).
#pragma once

#include <cstdlib>
#include <string_view>

namespace enamel::test {

inline bool longRun() {
  const char* value = std::getenv("ENAMEL_LONG");
  return value != nullptr && std::string_view(value) == "1";
}

inline int count(int shortRun, int fullRun) { return longRun() ? fullRun : shortRun; }

}  // namespace enamel::test
