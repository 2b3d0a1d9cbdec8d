// Reports the tick's measurements (the functions behind `enamel bench`). Times are printed, never judged.
#include <cstdio>

#include "bench/measurement.hpp"
#include "support/catch.hpp"

namespace enamel::test_tick {

TEST_CASE("speed against error of a tick and of a push", "[timing]") {
  const auto rows = bench::measureTick(0.1);
  REQUIRE_FALSE(rows.empty());
  for (const auto& row : rows) {
    std::printf("%-45s p50 %9.3f us, p99 %9.3f us, p99.9 %9.3f us, error %.1e (%s)\n", row.name.c_str(), row.median_us,
                row.p99_us, row.p999_us, row.error, row.errorOf.c_str());
    CHECK(row.error < 1e-9);
    CHECK(row.median_us > 1e-3);  // less than any of them takes: the compiler has dropped the work
    CHECK_FALSE(row.p99_us < row.median_us);
  }
}

}  // namespace enamel::test_tick
