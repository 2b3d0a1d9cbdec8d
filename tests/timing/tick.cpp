// Reports the measurements of the tick (the functions of `enamel bench`). Times are printed only.
#include <cstdio>
#include <string>

#include "bench/measurement.hpp"
#include "support/catch.hpp"

namespace enamel::test_tick {

TEST_CASE("speed against error of a tick and of a push", "[timing]") {
  const auto rows = bench::measureTick(0.1);
  const auto medianOf = [&rows](const std::string& name) {
    for (const auto& row : rows)
      if (row.name == name) return row.median_us;
    FAIL("no row " << name);
    return 0.0;
  };
  for (const auto& row : rows) {
    INFO(row.name);
    std::printf("%-45s p50 %9.3f us, p99 %9.3f us, p99.9 %9.3f us, error %.1e (%s)\n", row.name.c_str(), row.median_us,
                row.p99_us, row.p999_us, row.error, row.errorOf.c_str());
    CHECK(row.error < 1e-9);
  }
  // Every tick takes longer than reading the clock; otherwise the compiler removed it.
  for (const std::string renderer : {"position-control", "hold", "impedance"})
    CHECK(medianOf("whole tick, " + renderer) > medianOf("nothing (the clock's own cost)"));
  for (const std::string row : {"0 contacts, position-control", "6 contacts, position-control", "0 contacts, impedance",
                                "6 contacts, impedance"})
    CHECK(medianOf("whole tick, " + row) > medianOf("nothing (the clock's own cost)"));
}

}  // namespace enamel::test_tick
