// The command line as a user meets it.
#include <filesystem>
#include <optional>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"

namespace enamel::test_commands {

using test::run;

namespace {

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Lists a folder with a good plugin and, before and after it by name, one that fails.
test::CommandResult listBeside(const std::string& failing) {
  const test::TemporaryFolder folder;
  std::filesystem::copy(ENAMEL_PLUGINS "/enamel_template.so", folder / "good.so");
  if (!failing.empty())
    for (const char* name : {"a.so", "z.so"}) std::filesystem::copy(failing, folder / name);
  return run("plugins '" + (folder / "") + "'");
}

bool listsAllThree(const test::CommandResult& result) {
  return holds(result.output, "good.so") && holds(result.output, "a.so") && holds(result.output, "z.so");
}

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

TEST_CASE("case 07: a plugin beside no other one is listed", "[cases]") {
  const test::CommandResult result = listBeside("");
  CHECK(result.status == 0);
  CHECK(holds(result.output, "good.so"));
  CHECK(std::filesystem::exists(ENAMEL_THROWING_PLUGIN));
  CHECK(std::filesystem::exists(ENAMEL_CRASHING_PLUGIN));
}

TEST_CASE(
    "case 07: a plugin that throws is named, and the others are listed "
    "(expected failure until the hardening)",
    "[!shouldfail][cases]") {
  const test::CommandResult result = listBeside(ENAMEL_THROWING_PLUGIN);
  CAPTURE(result.output);
  CHECK(listsAllThree(result));
}

TEST_CASE(
    "case 07: a plugin that crashes is named, and the others are listed "
    "(expected failure until the hardening)",
    "[!shouldfail][cases]") {
  const test::CommandResult result = listBeside(ENAMEL_CRASHING_PLUGIN);
  CAPTURE(result.output);
  CHECK(listsAllThree(result));
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
