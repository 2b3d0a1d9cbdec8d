// The command line as a user meets it.
#include <filesystem>
#include <optional>

#include "enamel/plugin/host.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"

namespace enamel::test_commands {

using test::run;

namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string failingPlugin(const std::string& way) { return ENAMEL_FAILING_PLUGINS "/" + way + "_plugin.so"; }

struct Failure {
  std::string way, reason;
};
const Failure kFailures[] = {{"throwing", "enamel_plugin() threw: thrown while it was loaded"},
                             {"crashing", "loading it ended in a crash (Aborted)"},
                             {"loading", "loading it ended in a crash (Aborted)"},
                             {"exiting", "loading it ended the process with exit status 0"},
                             {"hanging", "loading it did not end in 0.9 s"}};

struct TwoStudies {
  test::CommandResult first, second;
  std::string before, after;  // the first one's runs
};

// A study of two runs, and another one of three runs into the same folder.
TwoStudies studyTwice() {
  const test::TemporaryFolder folder;
  const std::string study =
      "study --renderers impedance --scenario 1 --grid 1 --no-convergence --threads 1 --output '" + (folder / "out") +
      "' --runs ";
  TwoStudies studies;
  studies.first = run(study + "2");
  studies.before = test::readFile(folder / "out/runs.csv");
  studies.second = run(study + "3");
  studies.after = test::readFile(folder / "out/runs.csv");
  return studies;
}

// K_z1 of position control under encoders, N/m; none where it is undefined.
std::optional<double> stiffness(const std::string& options) {
  const test::CommandResult result =
      run("push --device '" + test::deviceFile("tau-nominal.toml") + "' --encoders --json " + options);
  if (result.status != 0) return -1.0;
  const auto value = test::parseJson(result.output).at("position-control").at("K_z1 [N/m]");
  if (value.is_null()) return std::nullopt;
  return value.get<double>();
}

}  // namespace

TEST_CASE("case 07: plugins that fail are refused with their reason, and the good ones among them are listed",
          "[cases]") {
  const test::TemporaryFolder folder;
  for (const char* name : {"a.so", "n.so", "z.so"})
    std::filesystem::copy(ENAMEL_PLUGINS "/enamel_template.so", folder / name);
  for (const Failure& failure : kFailures)
    std::filesystem::copy(failingPlugin(failure.way), folder / (failure.way + ".so"));
  const test::CommandResult result = run("plugins --time-limit 0.3 '" + (folder / ".") + "'");
  INFO(result.output);
  CHECK(result.status == 0);
  for (const char* name : {"a.so", "n.so", "z.so"})
    CHECK(holds(result.output, "  " + (folder / ".") + "/" + name + "\n"));
  for (const Failure& failure : kFailures)
    CHECK(holds(result.output, "refused: " + (folder / ".") + "/" + failure.way + ".so: " + failure.reason + "\n"));
}

TEST_CASE("case 07: check-plugin reports a plugin that fails in one line", "[cases]") {
  for (const Failure& failure : kFailures) {
    const test::CommandResult result = run("check-plugin --time-limit 0.3 '" + failingPlugin(failure.way) + "'");
    INFO(result.output);
    CHECK(result.status == 1);
    CHECK(result.output.rfind("enamel: " + failingPlugin(failure.way) + ": ", 0) == 0);
    CHECK(result.output.find('\n') == result.output.size() - 1);
    CHECK(holds(result.output, failure.reason.substr(failure.reason.find("it ") + 3)));
  }
}

TEST_CASE("case 07: a renderer is found by its name beside plugins that fail", "[cases]") {
  const test::TemporaryFolder folder;
  std::filesystem::copy(failingPlugin("crashing"), folder / "a.so");
  std::filesystem::copy(ENAMEL_PLUGINS "/enamel_template.so", folder / "enamel_template.so");
  CHECK(findPlugin("template", folder / ".")->description().name == std::string("template"));
}

TEST_CASE("case 08: a study writes its runs", "[cases]") {
  const TwoStudies studies = studyTwice();
  INFO(studies.first.output);
  CHECK(studies.first.status == 0);
  CHECK_FALSE(studies.before.empty());
  CHECK_FALSE(studies.after.empty());
}

TEST_CASE(
    "case 08: another study does not overwrite the runs in its folder "
    "(expected failure until the hardening)",
    "[!shouldfail][cases]") {
  const TwoStudies studies = studyTwice();
  CAPTURE(studies.second.output);
  CHECK(studies.after == studies.before);
}

TEST_CASE("case 14: under encoders and a preload the stiffness is that of the wall", "[cases]") {
  const auto preloaded = stiffness("--preload 1");
  REQUIRE(preloaded);
  CHECK(*preloaded > 1e5);
  const auto plain = stiffness("");
  CHECK((!plain || *plain > 0.0));
}

TEST_CASE(
    "case 14: without a preload the stiffness does not count free flight "
    "(expected failure until the hardening)",
    "[!shouldfail][cases]") {
  const auto plain = stiffness(""), preloaded = stiffness("--preload 1");
  CAPTURE(plain.value_or(0.0), preloaded.value_or(0.0));
  CHECK((!plain || *plain > 0.4 * preloaded.value_or(0.0)));
}

}  // namespace enamel::test_commands
