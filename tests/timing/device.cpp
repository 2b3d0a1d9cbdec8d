// Reports the measurements of the device (the functions of `enamel bench`). Times are printed only. Errors are checked,
// and which way is faster in the same run.
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
    CHECK(row.median_us > 1e-3);  // a shorter time means that the compiler removed the work
  }
}

}  // namespace enamel::test_device
