// Reports the device's measurements (the functions behind `enamel bench`). Times are printed, never judged; the
// errors beside them are, and who is faster in the same run.
#include <cmath>
#include <cstdio>

#include "bench/measurement.hpp"
#include "support/catch.hpp"

namespace enamel::test_device {

TEST_CASE("speed against error of the device module", "[timing]") {
  const auto rows = bench::measureDevice(0.1);
  CHECK(rows.size() == 10);
  for (const auto& row : rows) {
    std::printf("%-60s %9.4f us  error %.1e (%s)\n", row.name.c_str(), row.median_us, row.error, row.errorOf.c_str());
    CHECK(row.error < 1e-12);
    CHECK(row.median_us > 1e-3);  // less than any of them takes: the compiler has dropped the work
  }
}

}  // namespace enamel::test_device
