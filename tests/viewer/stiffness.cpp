// The viewer, `enamel push` and `enamel study` show the same stiffness for the same push, or the same reason for its
// absence.
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>

#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "viewer/support.hpp"

namespace enamel::test_stiffness {

namespace {

const std::vector<std::string> kRenderers = {"position-control", "impedance", "hold", "passivity"};

// Result of a push: a status if the device was lost, otherwise a verdict, with the stiffness if it was measured.
struct Said {
  std::string status, verdict;
  std::optional<double> stiffness;  // N/m
};
using Answers = std::map<std::string, Said>;  // by renderer

std::string joined() {
  std::string text;
  for (const std::string& renderer : kRenderers) text += (text.empty() ? "" : ",") + renderer;
  return text;
}

struct Push {
  std::string scene;
  int delay;
  bool encoders;  // encoder counts, and their differences as rates
};

std::string optionsOf(const Push& push) {
  return std::string(push.delay == 0 ? "" : " --delay constant:" + std::to_string(push.delay)) +
         (push.encoders ? " --encoders" : "");
}

Answers viewerSays(const test::TemporaryFolder& folder, const std::string& device, const Push& push) {
  std::ostringstream script;
  script << "0 set tool-damping 0\n0 set tremor 0.5\n0 set delay " << push.delay << "\n0 set encoders " << push.encoders
         << "\n0 set rates " << push.encoders << '\n';
  double time = 0.0;
  for (const std::string& renderer : kRenderers) {
    script << time << " home\n" << time << " renderer " << renderer << '\n' << time + 0.5 << " push\n";
    time += 5.0;
  }
  script << time << " end\n";
  test::writeFile(folder / "push.txt", script.str());
  const auto result = test::viewer(test::shippedScene(push.scene) + " --device '" + device + "' --headless --script '" +
                                   folder / "push.txt' --overwrite --report '" + folder / "push.json'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  Answers answers;
  const auto report = nlohmann::json::parse(test::readFile(folder / "push.json"));
  for (const auto& test : report.at("test_pushes")) {
    Said& said = answers[test.at("renderer")];
    said.status = test.at("status");
    if (!test.at("first impact").is_null()) said.verdict = test.at("first impact");
    if (!test.at("K_z1 [N/m]").is_null()) said.stiffness = test.at("K_z1 [N/m]");
    // Text for a person: the number, or the same words.
    const std::string shown = test.at("shown");
    if (said.stiffness) {
      const double unit = shown.find("MN/m") != std::string::npos ? 1e6 : 1e3;
      CHECK(unit * std::strtod(shown.c_str(), nullptr) == Approx(*said.stiffness).epsilon(0.01));
    } else {
      CHECK(shown.find(said.verdict.empty() ? "left the workspace" : said.verdict) == 0);
    }
  }
  return answers;
}

Answers commandSays(const std::string& device, const Push& push) {
  Answers answers;
  for (const std::string& renderer : kRenderers) {
    const auto result =
        test::runCommand("'" ENAMEL_TOOL "' push --json --force 12 --preload 0.5 --device '" + device + "' --scene " +
                         test::shippedScene(push.scene) + " --renderer " + renderer + optionsOf(push));
    Said& said = answers[renderer];
    const std::size_t begin = result.output.find('{'), end = result.output.rfind('}');  // between messages
    if (begin == std::string::npos) {
      CHECK(result.status != 0);
      continue;
    }
    const auto json = nlohmann::json::parse(result.output.substr(begin, end + 1 - begin)).at(renderer);
    said.verdict = json.at("first impact");
    if (!json.at("K_z1 [N/m]").is_null()) said.stiffness = json.at("K_z1 [N/m]");
  }
  return answers;
}

Answers studySays(const test::TemporaryFolder& folder, const std::string& device, const Push& push) {
  const auto result =
      test::runCommand("'" ENAMEL_TOOL
                       "' study --scenario 1 --grid 1 --runs 1 --force 12,12 --preload 0.5 --threads 1 "
                       "--device-damping 0 --release --no-convergence --renderers " +
                       joined() + " --device '" + device + "' --scene " + test::shippedScene(push.scene) +
                       optionsOf(push) + " --output '" + folder / ("study-" + push.scene + optionsOf(push)) + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  std::istringstream file(test::readFile(folder / ("study-" + push.scene + optionsOf(push) + "/runs.csv")));
  std::vector<std::string> names;
  Answers answers;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    std::map<std::string, std::string> row;
    std::size_t i = 0;
    for (std::string cell; std::getline(cells, cell, ','); ++i) {
      if (answers.empty() && names.size() == i) names.push_back(cell);
      row[names.at(i)] = cell;
    }
    if (row["renderer"] == "renderer") continue;
    Said& said = answers[row["renderer"]];
    said.status = row["status"];
    said.verdict = row["first impact"];
    if (!row["K_z1 [N/m]"].empty()) said.stiffness = std::strtod(row["K_z1 [N/m]"].c_str(), nullptr);
  }
  return answers;
}

}  // namespace

TEST_CASE("viewer, command and study show one stiffness to 1 %, or one reason", "[viewer]") {
  const test::TemporaryFolder folder;
  // Damped along every axis, as the viewer damps the tool; the option of the command damps z only.
  std::string text = test::readFile(test::deviceFile("tau-nominal.toml"));
  const std::string head = "[platform] ";
  const std::size_t at = text.find(head);
  REQUIRE(at != std::string::npos);
  text.replace(at, head.size(), "[platform]\ndamping = [4.0, 4.0, 4.0, 0.0, 0.0, 0.0]\n");
  const std::string device = folder / "damped.toml";
  test::writeFile(device, text);

  std::vector<Push> pushes = {
      {"flat-wall.toml", 0, true}, {"corner.toml", 0, false}, {"molar.toml", 1, true}, {"molar.toml", 3, false}};
  if (test::longRun()) {
    pushes.clear();
    for (const char* scene : {"flat-wall.toml", "corner.toml", "molar.toml"})
      for (const int delay : {0, 1, 2, 3})
        for (const bool encoders : {false, true}) pushes.push_back({scene, delay, encoders});
  }
  int measured = 0, reasons = 0;
  double largest = 0.0;
  for (const Push& push : pushes) {
    const Answers shown = viewerSays(folder, device, push), printed = commandSays(device, push),
                  studied = studySays(folder, device, push);
    for (const std::string& renderer : kRenderers) {
      INFO(push.scene << ", delay " << push.delay << (push.encoders ? ", encoders" : "") << ", " << renderer);
      REQUIRE(shown.count(renderer) == 1);
      REQUIRE(studied.count(renderer) == 1);
      const Said &a = shown.at(renderer), &b = printed.at(renderer), &c = studied.at(renderer);
      CHECK(a.status == c.status);
      CHECK(a.verdict == b.verdict);
      CHECK(a.verdict == c.verdict);
      REQUIRE(a.stiffness.has_value() == b.stiffness.has_value());
      REQUIRE(a.stiffness.has_value() == c.stiffness.has_value());
      if (!a.stiffness) {
        ++reasons;
        continue;
      }
      ++measured;
      CHECK(*a.stiffness == Approx(*b.stiffness).epsilon(0.01));
      CHECK(*a.stiffness == Approx(*c.stiffness).epsilon(0.01));
      largest =
          std::max({largest, std::abs(*a.stiffness / *b.stiffness - 1.0), std::abs(*b.stiffness / *c.stiffness - 1.0)});
    }
  }
  WARN(measured << " stiffnesses, " << reasons << " reasons; largest difference " << largest);
  CHECK(measured > 3);
  CHECK(reasons > 1);
}

TEST_CASE("as the viewer begins, it shows what the command prints with the paper's damping", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "push.txt", "0 renderer impedance\n0.2 push\n4.5 end\n");
  const auto result = test::viewer(test::shippedScene("flat-wall.toml") + " --headless --script '" +
                                   folder / "push.txt' --report '" + folder / "push.json'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto pushes = nlohmann::json::parse(test::readFile(folder / "push.json")).at("test_pushes");
  REQUIRE(pushes.size() == 1);
  const auto printed = test::runCommand("'" ENAMEL_TOOL
                                        "' push --json --preload 0.5 --noise 0 --encoders --rates exact "
                                        "--device-damping 4 --renderer impedance --device '" +
                                        test::deviceFile("tau-nominal.toml") + "'");
  REQUIRE(printed.status == 0);
  const auto json = nlohmann::json::parse(printed.output.substr(printed.output.find('{'))).at("impedance");
  CHECK(pushes[0].at("K_z1 [N/m]").get<double>() == Approx(json.at("K_z1 [N/m]").get<double>()).epsilon(0.01));
}

}  // namespace enamel::test_stiffness
