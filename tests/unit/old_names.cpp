// Names of the previous version: the library, the commands and files accept them, with a warning if a user gave one.
#include "enamel/core/old_names.hpp"

#include <nlohmann/json.hpp>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_old_names {

using test::ContainsSubstring;

TEST_CASE("an old name has a present one, every other name stays", "[old_names]") {
  CHECK(presentName("plant", "real") == "imperfect");
  CHECK(presentName("plant", "real-stiff") == "imperfect-stiff");
  for (const char* name : {"imperfect", "imperfect-stiff", "closed-form", "wood", ""}) {
    CHECK(presentName("plant", name) == name);
    CHECK(oldNameWarning("plant", name, "--plant").empty());
  }
  CHECK(presentName("renderer", "real") == "real");
  CHECK(oldNameWarning("plant", "real", "--plant") ==
        "--plant real: is now called imperfect; version 0.4 removes the old name");
}

TEST_CASE("commands take an old name, do the same and warn on standard error", "[old_names]") {
  const test::TemporaryFolder folder;
  const std::string errors = folder / "errors.txt";
  const auto stdoutOf = [&](const std::string& arguments) {
    const auto result = test::runCommand("{ '" ENAMEL_TOOL "' " + arguments + " 2>'" + errors + "'; }");
    INFO(arguments << '\n' << result.output << test::readFile(errors));
    REQUIRE(result.status == 0);
    return result.output;
  };
  const std::string push = "push --device '" + test::deviceFile("tau-detailed.toml") +
                           "' --renderer impedance --device-damping 4 --duration 1.1 --json --plant ";
  const std::string now = stdoutOf(push + "imperfect-stiff");
  CHECK(test::readFile(errors).empty());
  CHECK(stdoutOf(push + "real-stiff") == now);
  CHECK(test::readFile(errors) ==
        "enamel: warning: --plant real-stiff: is now called imperfect-stiff; version 0.4 removes the old name\n");
  // Each one of a list; both files of the study have the present name.
  const std::string study = "study --device '" + test::deviceFile("tau-detailed.toml") +
                            "' --grid 1 --runs 1 --scenario 1 --renderers position-control --no-convergence --plant ";
  (void)stdoutOf(study + "real --output '" + (folder / "study") + "'");
  CHECK_THAT(test::readFile(errors), ContainsSubstring("--plant real: is now called imperfect"));
  CHECK(nlohmann::json::parse(test::readFile(folder / "study/study.json")).at("plant") == "imperfect");
  const auto refused = test::run(push + "realistic");
  CHECK(refused.status == 2);
  CHECK_THAT(refused.output,
             ContainsSubstring("unknown plant \"realistic\": must be closed-form") && !ContainsSubstring("real,"));
}

}  // namespace enamel::test_old_names
