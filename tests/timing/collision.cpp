// Reports the collision module's measurements (the functions behind `enamel bench`). Times are printed, never judged;
// the errors beside them are.
#include <cstdio>

#include "bench/measurement.hpp"
#include "support/catch.hpp"

TEST_CASE("speed against error of the collision module", "[timing]") {
  for (const auto& row : enamel::bench::measureCollision(0.1)) {
    std::printf("%-60s %9.4f us  p99 %9.4f us  error %.1e (%s)\n", row.name.c_str(), row.median_us, row.p99_us,
                row.error, row.errorOf.c_str());
    const bool isPeer = row.name.find("Embree") == 0 || row.name.find("FCL") == 0;
    if (!isPeer) CHECK(row.error < 1e-13);  // m; the jaw is 0.06 m wide
  }
}
