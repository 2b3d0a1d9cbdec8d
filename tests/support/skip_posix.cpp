#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "support/skip.hpp"

namespace enamel::test {

namespace {

constexpr int kSkipped = 4;  // same as SKIP_RETURN_CODE in tests/CMakeLists.txt
bool skipped = false;

// Catch2 2 has no SKIP(). Its status is the number of failures: four failures must not count as skipped.
const int registered = on_exit(
    [](int status, void*) {
      const int told = status == 0 && skipped ? kSkipped : status == kSkipped ? 1 : status;
      if (told == status) return;
      std::fflush(nullptr);
      _exit(told);
    },
    nullptr);

}  // namespace

void skipTest(const std::string& reason) {
  std::printf("skipped: %s\n", reason.c_str());
  skipped = true;
}

}  // namespace enamel::test
