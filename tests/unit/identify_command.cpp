// `enamel identify` as a user runs it.
#include <filesystem>
#include <sstream>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_identify_command {

namespace {

// The commands of the page, in order.
std::vector<std::string> commandsOfPage() {
  std::istringstream lines(test::readFile(ENAMEL_SOURCE_DIR "/lib/docs/identify.md"));
  std::vector<std::string> commands;
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("enamel identify", 0) == 0) commands.push_back(line);
  return commands;
}

}  // namespace

TEST_CASE("the commands of the page plan, play and estimate", "[identify]") {
  const test::TemporaryFolder folder;
  const std::string shipped = test::readFile(test::deviceFile("cartesian-3.toml"));
  std::string wrong = shipped;
  wrong.replace(wrong.find("mass = 0.045"), 12, "mass = 0.080");
  test::writeFile(folder / "my-device.toml", wrong);
  std::filesystem::create_directory(folder / "devices");
  test::writeFile(folder / "devices/cartesian-3.toml", shipped);
  const auto runHere = [&](const std::string& rest) {
    return test::runCommand("cd '" + (folder / "") + "' && '" + ENAMEL_TOOL + "' " + rest);
  };
  const std::vector<std::string> commands = commandsOfPage();
  REQUIRE(commands.size() == 4);
  std::string output;
  for (const std::string& command : commands) {
    const bool plans = command.find("--plan ") != std::string::npos;
    if (command.find("--weighted ") != std::string::npos) {
      std::string heavier = shipped, again = commands[1];
      heavier.replace(heavier.find("mass = 0.045"), 12, "mass = 0.145");
      test::writeFile(folder / "devices/heavier.toml", heavier);
      again.replace(again.find("cartesian-3"), 11, "heavier").replace(again.find("run.rec"), 7, "heavy.rec");
      REQUIRE(runHere(again.substr(again.find(' ') + 1)).status == 0);
    }
    const auto result = runHere(command.substr(command.find(' ') + 1) + (plans ? " --duration 8" : ""));
    INFO(command << "\n" << result.output);
    REQUIRE(result.status == 0);
    if (plans) CHECK(result.output.find("platform.mass") != std::string::npos);
    output = result.output;
  }
  CHECK(output.find("loop delay: 2 ticks\n") != std::string::npos);
  const std::size_t scale = output.find("torque of all motors over the command");
  REQUIRE(scale != std::string::npos);
  CHECK(std::stod(output.substr(scale + std::string("torque of all motors over the command").size())) ==
        Approx(1.0).epsilon(0.02));
  const auto found = std::get<CartesianParameters>(loadDevice(folder / "identified.toml"));
  CHECK(found.mass == Approx(0.045).epsilon(0.01));  // the file said 0.080; the interval is about 0.1 %

  const std::string report = test::readFile(folder / "report.html");
  const bool hasFigures = report.find("built without Vega") == std::string::npos;
  for (const char* part : {"platform.mass", "2 (this loop)"}) CHECK(report.find(part) != std::string::npos);
  for (const char* part : {"axis z: 99.", "Spectra of the residuals"})
    if (hasFigures) CHECK(report.find(part) != std::string::npos);
  CHECK(report.substr(0, report.find("<script")).find("nan") == std::string::npos);

  const std::string device = "identify --device my-device.toml ";
  CHECK(runHere(device + "run.rec --weight 0.1 --output x.toml").output.find("--weighted") != std::string::npos);
  CHECK(runHere(device + "--plan").output.find("--output is needed") != std::string::npos);
  CHECK(runHere(device + "--output x.toml").output.find("give one of --plan, --run PLAN, or recordings") !=
        std::string::npos);
}

}  // namespace enamel::test_identify_command
