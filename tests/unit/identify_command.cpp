// `enamel identify` as a user runs it.
#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_identify_command {

using test::run;

TEST_CASE("identify plans, runs and estimates", "[identify]") {
  const test::TemporaryFolder folder;
  const std::string shipped = test::readFile(test::deviceFile("cartesian-3.toml"));
  std::string wrong = shipped;
  wrong.replace(wrong.find("mass = 0.045"), 12, "mass = 0.080");
  test::writeFile(folder / "mine.toml", wrong);
  const std::string device = "identify --device '" + (folder / "mine.toml") + "' ";
  const auto plan = run(device + "--plan --duration 8 --output '" + (folder / "plan.toml") + "'");
  INFO(plan.output);
  REQUIRE(plan.status == 0);
  CHECK(plan.output.find("platform.mass") != std::string::npos);

  const auto played =
      run(device + "--run '" + (folder / "plan.toml") + "' --virtual '" + test::deviceFile("cartesian-3.toml") +
          "' --delay constant:2 --record '" + (folder / "run.rec") + "'");
  INFO(played.output);
  REQUIRE(played.status == 0);

  const auto result = run(device + "'" + (folder / "run.rec") + "' --output '" + (folder / "identified.toml") + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK(result.output.find("loop delay: 2 ticks\n") != std::string::npos);
  const auto found = std::get<CartesianParameters>(loadDevice(folder / "identified.toml"));
  CHECK(found.mass == Approx(0.045).epsilon(0.01));  // the file said 0.080; the interval is about 0.1 %

  CHECK(run(device + "--plan").output.find("--output is needed") != std::string::npos);
  CHECK(run(device + "--output x.toml").output.find("give one of --plan, --run PLAN, or recordings") !=
        std::string::npos);
}

}  // namespace enamel::test_identify_command
