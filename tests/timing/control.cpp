// Reports the control module's measurements (the functions behind `enamel bench`). Times are printed, never judged; the
// errors beside them are.
#include <cstdio>

#include "bench/measurement.hpp"
#include "support/catch.hpp"

TEST_CASE("speed against error of the control module", "[timing]") {
  for (const auto& row : enamel::bench::measureControl(0.2)) {
    INFO(row.name);
    std::printf("%-60s %9.2f us  error %.1e (%s)\n", row.name.c_str(), row.median_us, row.error, row.errorOf.c_str());
    // DAREX 14 with rounded data cannot be better than 1e-7 (stated there); all else keeps to the project's bar.
    CHECK(row.error < (row.name == "Riccati, DAREX 14, tau = 1e8" ? 1e-7 : 1e-12));
  }
}
