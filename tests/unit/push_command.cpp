// `enamel push` as a user runs it.
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/reference.hpp"

namespace enamel::test_push_command {

using test::run;

namespace {

std::string push(const std::string& arguments) {
  return "push --device '" + test::deviceFile("tau-nominal.toml") + "' " + arguments;
}

// One column of a CSV file by its name.
std::vector<std::string> column(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string line, cell;
  std::getline(lines, line);
  int wanted = -1, index = 0;
  for (std::istringstream cells(line); std::getline(cells, cell, ','); ++index)
    if (cell == name) wanted = index;
  REQUIRE(wanted >= 0);
  std::vector<std::string> values;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (int i = 0; i <= wanted; ++i) std::getline(cells, cell, ',');
    values.push_back(cell);
  }
  return values;
}

}  // namespace

TEST_CASE("push reproduces the reference runs, with a gain designed from the device file", "[push_command]") {
  const test::TemporaryFolder folder;
  for (const auto& reference : test::referenceFile("runs-nominal.json").at("rows")) {
    const std::string renderer = reference.at("controller") == "pc" ? "position-control" : "impedance";
    const auto result = run(push("--renderer " + renderer +
                                 " --release off --guide off --noise 0 --force 12 --duration 1.3 --output '" +
                                 (folder / "run.csv") + "'"));
    INFO(result.output);
    REQUIRE(result.status == 0);
    const std::string csv = test::readFile(folder / "run.csv");
    CHECK(csv.rfind("t [s],x [m],y [m],z [m],", 0) == 0);
    const auto z = column(csv, "z [m]"), t = column(csv, "t [s]");
    REQUIRE(z.size() == reference.at("z").size());
    CHECK(std::stod(t[1001]) == Approx(1.001).epsilon(1e-15));
    double worst = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i)
      worst = std::max(worst, std::abs(std::stod(z[i]) - reference.at("z")[i].get<double>()));
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("push: metrics as a table and as JSON, both renderers beside each other", "[push_command]") {
  const test::TemporaryFolder folder;
  const auto table =
      run(push("--renderer position-control,impedance --noise 0 --output '" + (folder / "run.csv") + "'"));
  REQUIRE(table.status == 0);
  CHECK(table.output.find("first impact stiffness K_z1 [kN/m]") != std::string::npos);
  CHECK(table.output.find("lowest 17.2") != std::string::npos);
  CHECK(std::filesystem::exists(folder / "run-position-control.csv"));
  CHECK(std::filesystem::exists(folder / "run-impedance.csv"));
  const auto json = run(push("--renderer position-control,impedance --noise 0 --json"));
  REQUIRE(json.status == 0);
  const auto metrics = nlohmann::json::parse(json.output);
  CHECK(metrics.at("position-control").at("K_z1 [N/m]").get<double>() == Approx(27e3).epsilon(0.05));
  CHECK(metrics.at("impedance").at("K_z1 [N/m]").get<double>() == Approx(3.06e3).epsilon(0.01));
  CHECK(
      nlohmann::json::parse(run(push("--scenario 2 --json")).output).at("position-control").at("K_z1 [N/m]").is_null());
}

TEST_CASE("push: the same seed gives the same file, eq. 16 is warned about", "[push_command]") {
  const test::TemporaryFolder folder;
  const std::string options = "--duration 1.5 --delay random:0..1 --encoders --rates low-pass --output '";
  REQUIRE(run(push(options + (folder / "a.csv") + "' --seed 3")).status == 0);
  REQUIRE(run(push(options + (folder / "b.csv") + "' --seed 3")).status == 0);
  REQUIRE(run(push(options + (folder / "c.csv") + "' --seed 4")).status == 0);
  CHECK(test::readFile(folder / "a.csv") == test::readFile(folder / "b.csv"));
  CHECK(test::readFile(folder / "a.csv") != test::readFile(folder / "c.csv"));
  const auto warned = run(push("--renderer impedance --stiffness 9000 --duration 1.1"));
  CHECK(warned.status == 0);
  CHECK(warned.output.find("eq. 16") != std::string::npos);
  CHECK(run(push("--renderer impedance --duration 1.1")).output.find("eq. 16") == std::string::npos);
}

TEST_CASE("push: errors are one line and the status is not 0", "[push_command]") {
  for (const char* arguments :
       {"--renderer rubber", "--scenario 3", "--force -1", "--noise nan", "--duration -1", "--delay constant:99",
        "--delay random:2..1", "--delay often", "--substeps 0", "--x 500", "--release maybe",
        "--renderer impedance --stiffness -5", "--output /no/such/folder/run.csv", "--mode surface", "--low-pass 0"}) {
    const auto result = run(push(arguments));
    INFO(arguments << "\n" << result.output);
    CHECK(result.status != 0);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
    CHECK(result.output.rfind("enamel: ", 0) == 0);
  }
  CHECK(run("push --device none.toml").status != 0);
}

}  // namespace enamel::test_push_command
