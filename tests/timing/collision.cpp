// Reports the measurements of the collision module (the functions of `enamel bench`). Times are printed only; errors
// are checked.
#include <cstdio>

#include "bench/measurement.hpp"
#include "support/catch.hpp"
#include "support/run_length.hpp"

namespace enamel::test_collision {

TEST_CASE("speed against error of the collision module", "[timing]") {
  const auto rows = bench::measureCollision(test::longRun() ? 0.1 : 0.02);
  REQUIRE_FALSE(rows.empty());
  for (const auto& row : rows) {
    std::printf("%-60s %9.4f us  p99 %9.4f us  error %.1e (%s)\n", row.name.c_str(), row.median_us, row.p99_us,
                row.error, row.errorOf.c_str());
    const bool isPeer = row.name.find("Embree") == 0 || row.name.find("FCL") == 0;
    if (!isPeer) CHECK(row.error < 1e-13);  // m; the jaw is 0.06 m wide
    CHECK(row.median_us > 1e-3);            // a shorter time means that the compiler removed the work
  }
}

TEST_CASE("speed against error of solids", "[timing]") {
  const auto rows = bench::measureSolid(0.1);
  REQUIRE_FALSE(rows.empty());
  for (const auto& row : rows) {
    std::printf("%-60s %9.4f us  p99 %9.4f us  error %.1e (%s)\n", row.name.c_str(), row.median_us, row.p99_us,
                row.error, row.errorOf.c_str());
    CHECK(row.error < (row.errorOf[0] == 'm' ? 5e-5 : 0.1));  // half a cell
    CHECK(row.median_us > 1e-3);
  }
}

}  // namespace enamel::test_collision
