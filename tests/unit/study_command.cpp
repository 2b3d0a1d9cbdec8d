// `enamel study` as a user runs it. ENAMEL_LONG=1: the whole wall.
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"
#include "support/skip.hpp"
#include "support/text.hpp"
#include "support/xml.hpp"

namespace enamel::test_study_command {

namespace {

using test::captures;
using test::ContainsSubstring;
using test::occurrences;
using test::run;

const bool kLong = std::getenv("ENAMEL_LONG") != nullptr;

std::string study(const test::TemporaryFolder& folder, const std::string& name, const std::string& arguments) {
  return "study --no-convergence --force 8,15 --output '" + (folder / name) + "' " + arguments;
}
std::string convergingStudy(const test::TemporaryFolder& folder, const std::string& name,
                            const std::string& arguments) {
  return "study --force 8,15 --output '" + (folder / name) + "' " + arguments;
}

std::string file(const test::TemporaryFolder& folder, const std::string& name, const std::string& which) {
  return test::readFile(folder / (name + "/" + which));
}

// A complete study in the folder's "all": run once.
struct WholeStudy {
  test::TemporaryFolder folder;
  test::CommandResult result = run(convergingStudy(folder, "all", kLong ? "--grid 11 --runs 20" : "--grid 3 --runs 3"));
};
const WholeStudy& wholeStudy() {
  static const WholeStudy study;
  return study;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
  return cells;
}

// Return the text of a page without its scripts.
std::string textOf(const std::string& page) { return page.substr(0, page.find("<script")); }

// Return a page as one reads it: spaces are spaces, subscripts are "_".
std::string readable(const std::string& whole) {
  std::string page = textOf(whole);
  page = std::regex_replace(page, std::regex("<sub>([a-z0-9]*)</sub>"), "_$1");
  return std::regex_replace(page, std::regex("\u00a0"), " ");
}

// Small, but with more runs than run concurrently.
const std::string kSmall =
    "--renderers position-control --scenario 1 --grid 2 --runs 5 --preload 2 --inside-tick --encoders ";

// Run it, and send a signal when runs.csv has more than `bytes`.
test::CommandResult interrupted(const std::string& arguments, const std::string& csv, int bytes, const char* signal) {
  return test::runCommand("('" ENAMEL_TOOL "' " + arguments + " & tool=$!; while kill -0 $tool 2>/dev/null; do " +
                          "size=$(cat '" + csv + "' 2>/dev/null | wc -c); if [ $size -gt " + std::to_string(bytes) +
                          " ]; then kill -" + signal + " $tool; break; fi; sleep 0.02; done; wait $tool)");
}

}  // namespace

TEST_CASE("study: the same bytes with one thread and two, interrupted and killed", "[study_command]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(study(folder, "one", kSmall + "--threads 1")).status == 0);
  CHECK_FALSE(std::filesystem::exists(folder / "one/convergence.csv"));
  CHECK(file(folder, "one", "report.html").find("Speed against error") == std::string::npos);
  const std::string runs = file(folder, "one", "runs.csv");
  CHECK(std::count(runs.begin(), runs.end(), '\n') == 1 + 4 * 5);
  const auto same = [&](const std::string& name) {
    CHECK(file(folder, name, "runs.csv") == runs);
    CHECK(file(folder, name, "points.csv") == file(folder, "one", "points.csv"));
    CHECK(file(folder, name, "summary.json") == file(folder, "one", "summary.json"));
  };
  REQUIRE(run(study(folder, "two", kSmall + "--threads 2")).status == 0);
  same("two");
  REQUIRE(run(study(folder, "other", kSmall + "--seed 2")).status == 0);
  CHECK(file(folder, "other", "runs.csv") != runs);

  for (const char* signal : {"INT", "TERM", "KILL"}) {
    const std::string name = std::string("cut-") + signal;
    test::CommandResult cut;
    std::string left;
    for (int attempt = 0; attempt < 20; ++attempt) {  // until the signal comes before the end
      std::filesystem::remove_all(folder / name);
      cut = interrupted(study(folder, name, kSmall + "--threads 2"), folder / (name + "/runs.csv"), 2000, signal);
      left = file(folder, name, "runs.csv");
      if (left.size() < runs.size()) break;
    }
    INFO(cut.output);
    REQUIRE(left.size() < runs.size());
    CHECK(left == runs.substr(0, left.size()));
    CHECK_FALSE(std::filesystem::exists(folder / (name + "/report.html")));
    if (signal != std::string("KILL")) {
      CHECK(cut.status == (signal == std::string("INT") ? 130 : 143));
      CHECK(cut.output.find("--resume") != std::string::npos);
      CHECK(left.back() == '\n');
    }
    // Without --resume, nothing is discarded.
    const auto forgotten = run(study(folder, name, kSmall));
    CHECK(forgotten.status == 1);
    CHECK(forgotten.output.find("runs.csv: exists; --resume continues it, --overwrite replaces it") !=
          std::string::npos);
    CHECK(file(folder, name, "runs.csv") == left);
    // Another study cannot continue in its place.
    const auto mixed = run(study(folder, name, kSmall + "--resume --seed 9"));
    CHECK(mixed.status == 1);
    CHECK(mixed.output.find("holds another study: its seed is 1, here it is 9") != std::string::npos);
    CHECK(file(folder, name, "runs.csv") == left);
    // A torn line is removed.
    test::writeFile(folder / (name + "/runs.csv"), left + "1,position-con");
    REQUIRE(run(study(folder, name, kSmall + "--resume --threads 1")).status == 0);
    CHECK(file(folder, name, "runs.csv") == runs);
    CHECK(std::filesystem::exists(folder / (name + "/report.html")));
  }
  // A finished study can be resumed, or repeated on request.
  REQUIRE(run(study(folder, "two", kSmall + "--resume")).status == 0);
  same("two");
  REQUIRE(run(study(folder, "two", kSmall + "--overwrite")).status == 0);
  same("two");
}

TEST_CASE("study: the paper's ordering holds, nothing is infinite", "[study_command]") {
  const test::TemporaryFolder& folder = wholeStudy().folder;
  const test::CommandResult& result = wholeStudy().result;
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto summary = test::parseJson(file(folder, "all", "summary.json"));
  REQUIRE(summary.at("claims").size() == 10);
  for (const auto& claim : summary.at("claims")) {
    INFO(claim.dump());
    CHECK(claim.at("verdict") == "holds");
  }
  REQUIRE(summary.at("walls").size() == 6);
  for (const auto& wall : summary.at("walls")) {
    CHECK(wall.at("runs that left the workspace") == 0);
    CHECK(wall.at("lowest K_z1 [N/m]").is_null() == (wall.at("scenario") == 2));
    CHECK(wall.at("runs without K_z1") ==
          nlohmann::json(
              {{"rings", 0}, {"slipped", 0}, {"never returned", 0}, {"began off the wall", 0}, {"unstable", 0}}));
    // Only the paper's baseline has 4 N s/m.
    CHECK(wall.at("plant's damping along z [N s/m]") == (wall.at("renderer") == "impedance" ? 4.0 : 0.0));
    if (wall.at("renderer") == "impedance") {
      CHECK(wall.at("points with K_zs unresolved") == 0);
      CHECK(wall.at("lowest K_zs [N/m]").at("value").get<double>() == Approx(6000.0).epsilon(0.02));
    }
  }
  for (const char* name : {"runs.csv", "points.csv"}) {
    const std::string text = file(folder, "all", name);
    CHECK(text.find("inf") == std::string::npos);
    CHECK(text.find("nan") == std::string::npos);
  }
  // The report is self-contained.
  const std::string page = file(folder, "all", "report.html"), report = readable(page);
  for (const char* request : {"<link", "<script src", "@import", "<img", "<iframe"})
    CHECK_THAT(page, !ContainsSubstring(request));
  CHECK_THAT(report, !ContainsSubstring("http"));
  // It begins with the answer: which is stiffer, by how much, and on what that rests.
  const std::string first = report.substr(0, report.find("<h2>"));
  for (const char* part :
       {"times as stiff</b> as impedance, and stiffer at all 9 query points", "no hardware was involved",
        "4 N s/m of damping for impedance", "seed 1, device file with CRC-32 ", "download=\"points.csv\""})
    CHECK_THAT(first, ContainsSubstring(part));
  CHECK_THAT(first, ContainsSubstring("enamel study --runs 3 --grid 3") ||
                        ContainsSubstring("enamel study --runs 20 --grid 11"));
  CHECK(report.find("17 174") != std::string::npos);
  CHECK(report.find("not met") != std::string::npos);
  CHECK(report.find("Speed against error") != std::string::npos);
  CHECK(report.find("the study uses it by default") != std::string::npos);
  CHECK(report.find("the depth of the first reversal of the continuous motion (also between ticks)") !=
        std::string::npos);
  CHECK(report.find("<h1>On a stiff wall: position control, hold, impedance</h1>") != std::string::npos);
  // A metric has the same name everywhere.
  const std::string runs = file(folder, "all", "runs.csv"), points = file(folder, "all", "points.csv");
  const std::string runHead = runs.substr(0, runs.find('\n')), pointHead = points.substr(0, points.find('\n'));
  for (const Metric& metric : allMetrics()) {
    INFO(metric.symbol);
    CHECK(runHead.find(',' + keyOf(metric) + ',') != std::string::npos);
    CHECK(pointHead.find(",mean " + keyOf(metric) + ",deviation " + keyOf(metric) + ',') != std::string::npos);
    CHECK(file(folder, "all", "convergence.csv").find(std::string(",") + metric.symbol + " error") !=
          std::string::npos);
  }
  const std::string summaryText = summary.dump();
  for (const char* symbol : {"K_z1", "largest depth", "chatter", "saturated share", "tangential force", "drift",
                             "share of limit", "bounce"}) {
    const auto metric = std::find_if(allMetrics().begin(), allMetrics().end(),
                                     [symbol](const Metric& m) { return m.symbol == std::string(symbol); });
    REQUIRE(metric != allMetrics().end());
    CHECK(summaryText.find(keyOf(*metric) + '"') != std::string::npos);
    if (symbol != std::string("K_z1") && symbol != std::string("share of limit"))
      CHECK(report.find(std::string(symbol) + ", " + metric->displayUnit) != std::string::npos);
  }
}

TEST_CASE("study: by default it also pushes with the forces of crown preparations", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string tiny = "study --no-convergence --renderers impedance --scenario 1 --grid 1 --runs 2 ",
                    output = "--output '" + (folder / "both") + "' ";
  const auto result = run(tiny + output);
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto settings = [&](const std::string& name) { return test::parseJson(file(folder, name, "study.json")); };
  CHECK(settings("both").at("F_c [N]") == std::vector<double>{8.0, 15.0});
  CHECK(settings("both").at("noise [N]") == 0.5);
  CHECK(settings("both/dental").at("F_c [N]") == std::vector<double>{0.1, 4.9});
  CHECK(settings("both/dental").at("noise [N]") == 0.1);
  CHECK(std::filesystem::exists(folder / "both/dental/report.html"));
  CHECK(run("study --verify '" + (folder / "both/dental") + "'").status == 0);
  std::filesystem::remove_all(folder / "both/dental");  // interrupted between both
  const std::string runs = file(folder, "both", "runs.csv");
  REQUIRE(run(tiny + output + "--resume").status == 0);
  CHECK(file(folder, "both", "runs.csv") == runs);
  CHECK(std::filesystem::exists(folder / "both/dental/report.html"));
  REQUIRE(run(study(folder, "one", "--renderers impedance --scenario 1 --grid 1 --runs 2")).status == 0);
  CHECK_FALSE(std::filesystem::exists(folder / "one/dental"));
  CHECK(file(folder, "one", "runs.csv") == runs);
}

TEST_CASE("study: damping is the plant's, whatever the renderer", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string tiny = "--scenario 1 --grid 1 --runs 2 --renderers ";
  const auto both = [&](const std::string& name, const std::string& arguments) {
    const auto result = run(study(folder, name, tiny + "position-control,impedance " + arguments));
    INFO(result.output);
    REQUIRE(result.status == 0);
    return test::parseJson(file(folder, name, "summary.json"));
  };
  const auto dampings = [](const nlohmann::json& summary) {
    std::vector<double> list;
    for (const auto& wall : summary.at("walls"))
      list.push_back(wall.at("plant's damping along z [N s/m]").get<double>());
    return list;
  };
  const auto lines = [&](const std::string& name, const std::string& renderer) {
    std::istringstream text(file(folder, name, "runs.csv"));
    std::string all;
    for (std::string line; std::getline(text, line);)
      if (line.find("," + renderer + ",") != std::string::npos) all += line + '\n';
    REQUIRE_FALSE(all.empty());
    return all;
  };
  CHECK(dampings(both("default", "")) == std::vector<double>{0.0, 4.0});
  CHECK(dampings(both("said", "--device-damping impedance=4")) == std::vector<double>{0.0, 4.0});
  CHECK(file(folder, "said", "study.json") == file(folder, "default", "study.json"));
  CHECK(file(folder, "said", "runs.csv") == file(folder, "default", "runs.csv"));
  CHECK(dampings(both("all", "--device-damping 4")) == std::vector<double>{4.0, 4.0});
  CHECK(lines("all", "impedance") == lines("default", "impedance"));
  CHECK(lines("all", "position-control") != lines("default", "position-control"));
  CHECK(dampings(both("other", "--device-damping position-control=2.5,impedance=6")) == std::vector<double>{2.5, 6.0});
  CHECK(file(folder, "other", "report.html").find("<td>2.5</td>") != std::string::npos);
  // Without it the wall violates eq. 16: the terminal and the report say so.
  const auto none = run(study(folder, "none", tiny + "impedance --device-damping 0"));
  CHECK(none.status == 0);
  CHECK(none.output.find("need more than 3 N s/m of device damping") != std::string::npos);
  CHECK(lines("none", "impedance") != lines("default", "impedance"));
  CHECK_THAT(readable(file(folder, "none", "report.html")),
             ContainsSubstring("needs more than 3 N s/m (eq. 16); its plant has 0 N s/m"));
  // The default's name may be missing in --renderers; a given name may not.
  CHECK(run(study(folder, "alone", tiny + "position-control")).status == 0);
}

TEST_CASE("study: a given gain is the one that is used", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string tiny = "--scenario 1 --grid 1 --runs 2 --renderers hold ";
  // The reference design is from another author and agrees with ours to 1e-9 or better.
  auto servo = test::parseJson(test::readFile(ENAMEL_SOURCE_DIR "/data/reference/servo-nominal.json"));
  const auto firstStiffness = [&](const std::string& name, const std::string& arguments) {
    const auto result = run(study(folder, name, tiny + arguments));
    INFO(result.output);
    REQUIRE(result.status == 0);
    return test::parseJson(file(folder, name, "summary.json"))
        .at("walls")[0]
        .at("lowest K_z1 [N/m]")
        .at("value")
        .get<double>();
  };
  const auto gainFile = [&](const std::string& name) {
    test::writeFile(folder / name, servo.dump());
    return "--gain '" + (folder / name) + "'";
  };
  const double designed = firstStiffness("designed", "");
  servo["period"] = 1e-3;
  CHECK(firstStiffness("same", gainFile("same.json")) == Approx(designed).epsilon(1e-6));
  CHECK(file(folder, "same", "report.html").find("The servo of hold from --gain") != std::string::npos);
  const auto whole = servo;
  for (auto& row : servo["K"])
    for (auto& k : row) k = 0.5 * k.get<double>();
  CHECK(firstStiffness("half", gainFile("half.json")) < 0.8 * designed);
  CHECK(file(folder, "half", "study.json") != file(folder, "same", "study.json"));
  // Another gain makes another study.
  const auto mixed = run(study(folder, "half", tiny + gainFile("half.json") + " --resume --seed 1"));
  CHECK(mixed.status == 0);
  CHECK(run(study(folder, "half", tiny + "--resume")).output.find("holds another study") != std::string::npos);

  const auto refused = [&](const std::string& name, const std::string& message) {
    const auto result = run(study(folder, "refused", tiny + gainFile(name)));
    INFO(result.output);
    CHECK(result.status == 1);
    CHECK(result.output.find(message) != std::string::npos);
    CHECK_FALSE(std::filesystem::exists(folder / "refused"));
  };
  servo = whole;
  servo["period"] = 2e-3;
  refused("slow.json", "the servo is for ticks of 0.002 s, the period here is 0.001 s");
  servo = whole;
  servo["K"] = nlohmann::json::array();
  for (int i = 0; i < 3; ++i) servo["K"].push_back(std::vector<double>(9, 1.0));
  refused("three.json", "the servo is for 3 joints, the device has 6");
  CHECK(run("study --renderers impedance --grid 1 --runs 1 --output '" + (folder / "spring") + "' --gain '" +
            (folder / "same.json") + "'")
            .output.find("same.json: is an LQR design for hold, but --renderers does not name hold") !=
        std::string::npos);
}

TEST_CASE("study: a tool that touches 60 mm from the TCP has less mass behind it", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string tiny = "--scenario 1 --grid 1 --runs 2 --renderers position-control --encoders --preload 1 ";
  const auto lowest = [&](const std::string& name, const std::string& more) {
    const auto result = test::run(study(folder, name, tiny + more));
    INFO(result.output);
    REQUIRE(result.status == 0);
    const auto summary = test::parseJson(file(folder, name, "summary.json"));
    CHECK(test::parseJson(file(folder, name, "study.json")).at("tip [mm]").size() == 3);
    return summary.at("walls").at(0).at("lowest K_z1 [N/m]").at("value").get<double>();
  };
  const double here = lowest("here", ""), there = lowest("there", "--tip 60,0,0");
  CHECK(there < 0.6 * here);
  CHECK(there > 30e3);
}

TEST_CASE("study: a plugin is called a plugin, and does what the linked renderer does", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string plugin = ENAMEL_PLUGINS "/enamel_impedance.so";
  const std::string tiny = "--scenario 1 --grid 1 --runs 2 --renderers ";
  REQUIRE(run(study(folder, "both", tiny + "'impedance," + plugin + "' --set stiffness=6000")).status == 0);
  std::string linked, plugged;
  std::istringstream text(file(folder, "both", "runs.csv"));
  for (std::string line; std::getline(text, line);) {
    if (const auto at = line.find("impedance (plugin),"); at != std::string::npos)
      plugged += line.substr(at + std::string("impedance (plugin),").size()) + '\n';
    else if (const auto here = line.find("impedance,"); here != std::string::npos)
      linked += line.substr(here + std::string("impedance,").size()) + '\n';
  }
  REQUIRE_FALSE(linked.empty());
  CHECK(plugged == linked);
  // A plugin is never a linked renderer, even if it has the name "position-control".
  const std::string servo = ENAMEL_PLUGINS "/enamel_position_control.so";
  REQUIRE(run(study(folder, "servo", tiny + "'" + servo + "'")).status == 0);
  const std::string report = file(folder, "servo", "report.html");
  CHECK(report.find("<h1>On a stiff wall: position-control (plugin)</h1>") != std::string::npos);
  CHECK(report.find("position control<") == std::string::npos);
  CHECK(test::parseJson(file(folder, "servo", "summary.json")).at("claims").empty());
  // One value per --set: it does not consume the next argument.
  CHECK(run(study(folder, "set", tiny + "'" + plugin + "' --set stiffness=6000 --set damping=1")).status == 0);
  const auto eaten = run(study(folder, "eaten", tiny + "'" + plugin + "' --set stiffness=6000 damping=1"));
  CHECK(eaten.status == 2);
  CHECK(eaten.output.find("damping=1") != std::string::npos);
}

TEST_CASE("study: a device of three joints", "[study_command]") {
  const test::TemporaryFolder folder;
  const auto result = run(
      study(folder, "delta",
            "--device '" + test::deviceFile("delta.toml") + (kLong ? "' --grid 3 --runs 3" : "' --grid 2 --runs 2")));
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto summary = test::parseJson(file(folder, "delta", "summary.json"));
  REQUIRE(summary.at("walls").size() == 6);
  for (const auto& wall : summary.at("walls")) {
    INFO(wall.dump());
    CHECK(wall.at("runs that left the workspace") == 0);
    CHECK(wall.at("faults") == 0);
  }
  const std::string report = file(folder, "delta", "report.html");
  CHECK(report.find("Requirements on the servo") != std::string::npos);
  CHECK(textOf(report).find("joint 6") == std::string::npos);
}

TEST_CASE("study: encoders, delay and a design on another device make other studies", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string tiny = "--renderers hold --scenario 1 --grid 1 --runs 2 ";
  REQUIRE(run(study(folder, "plain", tiny)).status == 0);
  const std::string detailed = test::deviceFile("tau-detailed.toml");
  for (const std::string& other :
       {std::string("--encoders"), std::string("--delay constant:1"), std::string("--preload 2"),
        std::string("--inside-tick"), "--design-device '" + detailed + "'", "--device '" + detailed + "'"}) {
    const std::string name = "other" + std::to_string(other.size());
    INFO(other);
    REQUIRE(run(study(folder, name, tiny + other)).status == 0);
    CHECK(file(folder, name, "runs.csv") != file(folder, "plain", "runs.csv"));
    CHECK(file(folder, name, "study.json") != file(folder, "plain", "study.json"));
  }
  // The built-in device is the shipped one.
  REQUIRE(run(study(folder, "named", tiny + "--device '" + test::deviceFile("tau-nominal.toml") + "'")).status == 0);
  CHECK(file(folder, "named", "runs.csv") == file(folder, "plain", "runs.csv"));
}

TEST_CASE("study: runs that the plant cannot finish are lost, not numbers", "[study_command]") {
  const test::TemporaryFolder folder;
  // The paper's gains are unstable at a constant delay of 8 ticks.
  const auto result = run(study(folder, "late", "--renderers hold --scenario 1 --grid 1 --runs 2 --delay constant:8"));
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto summary = test::parseJson(file(folder, "late", "summary.json"));
  for (const auto& claim : summary.at("claims")) CHECK(claim.at("verdict") != "holds");
  // Values that no run could measure are not zero.
  for (const auto& wall : summary.at("walls"))
    if (wall.at("runs that left the workspace") == 2) {
      CHECK(wall.at("largest depth [m]").is_null());
      CHECK(wall.at("largest mean chatter [N m]").is_null());
    }
  const std::string points = file(folder, "late", "points.csv");
  CHECK(points.find("inf") == std::string::npos);
  CHECK(points.find("nan") == std::string::npos);
}

TEST_CASE("study: errors are one line, before any run", "[study_command]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "broken.toml", "name = \"x\"\n[[chain]]\nbase = 3\n");
  test::writeFile(folder / "plain-file", "");
  const std::string output = "--output '" + (folder / "never") + "' ";
  for (const std::string& arguments : {output + "--renderers rubber",
                                       output + "--renderers impedance,impedance",
                                       output + "--grid 0",
                                       output + "--grid 500",
                                       output + "--runs 0",
                                       output + "--scenario 3",
                                       output + "--scenario 1,1",
                                       output + "--threads -1",
                                       output + "--threads 1000",
                                       output + "--delay often",
                                       output + "--delay constant:99",
                                       output + "--delay constant:9",
                                       output + "--preload -1",
                                       output + "--seed x",
                                       output + "--device-damping much",
                                       output + "--device-damping=-1",
                                       output + "--device-damping impedance=4,rubber=2",
                                       output + "--device-damping impedance=4,impedance=5",
                                       output + "--device-damping 4,impedance=5",
                                       output + "--device-damping =4",
                                       output + "--convergence --no-convergence",
                                       output + "--gain none.json",
                                       output + "--device none.toml",
                                       output + "--device '" + (folder / "broken.toml") + "'",
                                       output + "--design-device '" + (folder / "broken.toml") + "'",
                                       std::string("--grid 3"),
                                       "--output '" + (folder / "plain-file") + "'",
                                       "--output '" + (folder / "plain-file") + "/below'",
                                       std::string("--output /proc/no-such-folder")}) {
    const auto result = run("study " + arguments);
    INFO(arguments << "\n" << result.output);
    CHECK(result.status != 0);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
    CHECK(result.output.rfind("enamel: ", 0) == 0);
    CHECK_FALSE(std::filesystem::exists(folder / "never/runs.csv"));
  }
  if (geteuid() != 0) {  // root may write anywhere
    std::filesystem::create_directory(folder / "locked");
    std::filesystem::permissions(folder / "locked", std::filesystem::perms::owner_read);
    CHECK(run(study(folder, "locked", kSmall)).output.find("cannot write into the folder") != std::string::npos);
  }
}

TEST_CASE("study: a full disk ends it with one line, and it can go on", "[study_command]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(study(folder, "whole", kSmall)).status == 0);
  // A limit on the size of files simulates a full disk: 8 blocks of 512 bytes, or of 1024 if sh is bash.
  const auto full = test::runCommand("ulimit -f 8; '" ENAMEL_TOOL "' " + study(folder, "full", kSmall));
  INFO(full.output);
  CHECK(full.status == 1);
  CHECK(full.output.find("runs.csv: cannot write the file: ") != std::string::npos);
  const std::string left = file(folder, "full", "runs.csv"), whole = file(folder, "whole", "runs.csv");
  CHECK(left.size() <= 8192);
  CHECK(left == whole.substr(0, left.size()));
  REQUIRE(run(study(folder, "full", kSmall + "--resume")).status == 0);
  CHECK(file(folder, "full", "runs.csv") == whole);
}

TEST_CASE("study: figures have the data, on equal axes", "[study_command]") {
  const test::TemporaryFolder& folder = wholeStudy().folder;
  const test::CommandResult& result = wholeStudy().result;
  INFO(result.output);
  REQUIRE(result.status == 0);
  const std::string report = file(folder, "all", "report.html");
  CHECK(test::xmlProblem(report) == "");
  if (report.find("built without Vega") != std::string::npos) return test::skipTest("Vega is not installed");
  std::map<std::string, nlohmann::json> figures;
  for (const std::string& name : captures(textOf(report), "<div class=\"plot\" id=\"([^\"]*)\"")) {
    const std::string head = "id=\"" + name + "-data\">";
    const std::size_t at = report.find(head) + head.size();
    figures[name] = test::parseJson(report.substr(at, report.find("</script>", at) - at));
  }
  std::set<std::string> names;
  for (const auto& [name, figure] : figures) names.insert(name);
  CHECK(names == std::set<std::string>{"stiffness", "fig06-device", "fig08-response-1", "fig09-response-2",
                                       "fig10-first-impact", "fig11-torque", "fig12-steady-1", "fig13-steady-2",
                                       "impedance-stability", "convergence"});
  CHECK_THAT(report, ContainsSubstring("Figure 10. ") && !ContainsSubstring("Figure 11. "));
  const auto layersOf = [](const nlohmann::json& panel, const char* type) {
    std::vector<nlohmann::json> layers;
    for (const auto& layer : panel.at("layers"))
      if (layer.at("type") == type) layers.push_back(layer);
    return layers;
  };

  // The query points; one tick per point; one mark per method with a finite error.
  CHECK(layersOf(figures["fig06-device"].at("panels")[0], "points").at(1).at("x").size() == 9);
  for (const char* name : {"fig08-response-1", "fig09-response-2"}) {
    INFO(name);
    const nlohmann::json panels = figures[name].at("panels");
    REQUIRE(panels.size() == 5);
    for (std::size_t p = 0; p < 5; ++p) {
      const auto lines = layersOf(panels[p], "line");
      CHECK(lines.size() == (p < 4 ? 1u : 3u));
      for (const auto& line : lines) CHECK(line.at("y").size() == 2100);  // 0.9 s to 3 s at 1 kHz
    }
    // Position control, hold and impedance have one scale, also in the close-up of the step.
    for (std::size_t p = 1; p < 4; ++p) CHECK(panels[p].at("y").at("share") == "z");
    CHECK(panels[4].at("y").contains("share") == (name == std::string("fig08-response-1")));
    CHECK_FALSE(panels[0].at("y").contains("share"));
  }
  std::size_t finite = 0, marks = 0;
  std::istringstream table(file(folder, "all", "convergence.csv"));
  for (std::string line; std::getline(table, line);)
    finite += std::isdigit(static_cast<unsigned char>(line.back())) != 0 && line.find("inf") == std::string::npos;
  CHECK(finite > 6);
  for (const auto& panel : figures["convergence"].at("panels"))
    for (const auto& line : layersOf(panel, "line")) marks += line.at("y").size();
  CHECK(marks == 2 * finite);

  // Maps: every point's mean and interval as in points.csv.
  std::istringstream points(file(folder, "all", "points.csv"));
  std::string line;
  std::getline(points, line);
  const std::vector<std::string> head = split(line);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(head.begin(), head.end(), name) - head.begin());
  };
  std::vector<std::vector<std::string>> first, second;
  while (std::getline(points, line)) (line[0] == '1' ? first : second).push_back(split(line));
  REQUIRE(first.size() == 27);
  const auto cellsOf = [&](const std::string& name) {
    std::vector<nlohmann::json> cells;
    for (const auto& panel : figures[name].at("panels")) {
      const nlohmann::json layer = layersOf(panel, "cells").at(0);
      for (const auto& cell : layer.at("cells")) cells.push_back(cell);
    }
    return cells;
  };
  const auto map = cellsOf("fig10-first-impact");
  REQUIRE(map.size() == first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    double x = 0.0, y = 0.0, mean = 0.0, half = 0.0;
    const std::string text = map[i].at("text");
    INFO(text);
    REQUIRE(std::sscanf(text.c_str(), "(%lf, %lf) mm: %lf ± %lf kN/m", &x, &y, &mean, &half) == 4);
    CHECK(x == Approx(1e3 * std::stod(first[i][column("x [m]")])).margin(1e-9));
    CHECK(y == Approx(1e3 * std::stod(first[i][column("y [m]")])).margin(1e-9));
    CHECK(0.5 * (map[i].at("x0").get<double>() + map[i].at("x1").get<double>()) == Approx(x).margin(1e-9));
    // Student's t for two degrees of freedom.
    const double exact = 1e-3 * 4.30265 / std::sqrt(3.0) * std::stod(first[i][column("deviation K_z1 [N/m]")]);
    CHECK(half == Approx(exact).epsilon(0.05));
    CHECK(mean == Approx(1e-3 * std::stod(first[i][column("mean K_z1 [N/m]")])).margin(0.05 * half));
    CHECK(map[i].at("value").get<double>() == Approx(mean).margin(0.05 * half + 1e-4 * mean));
  }
  for (const char* name : {"fig10-first-impact", "fig12-steady-1", "fig13-steady-2", "impedance-stability"})
    for (const char* axis : {"x", "y"}) {
      INFO(name);
      std::set<std::pair<double, double>> ranges;
      for (const auto& panel : figures[name].at("panels"))
        ranges.emplace(panel.at(axis).at("low"), panel.at(axis).at("high"));
      CHECK(ranges.size() == 1);
    }
  std::ptrdiff_t unresolved = 0;
  for (const auto& row : second) unresolved += row[column("K_zs [N/m]")] == "unresolved";
  const auto steady = cellsOf("fig13-steady-2");
  CHECK(std::count_if(steady.begin(), steady.end(), [](const auto& cell) { return cell.at("value").is_null(); }) ==
        unresolved);

  // One renderer has nothing to compare.
  REQUIRE(run(study(folder, "point", "--renderers position-control --scenario 1 --grid 1 --runs 2")).status == 0);
  const std::string point = file(folder, "point", "report.html");
  CHECK_THAT(point, ContainsSubstring("there is nothing to compare"));
  CHECK(test::xmlProblem(point) == "");
}

TEST_CASE("study: numbers of the report are rounded to their intervals, and no line breaks inside", "[study_command]") {
  REQUIRE(wholeStudy().result.status == 0);
  const std::string report = textOf(file(wholeStudy().folder, "all", "report.html"));
  const std::string tables = report.substr(report.find("<table>"));
  const std::regex pair("([0-9\u00a0]+)(\\.([0-9]+))?\u00a0±\u00a0([0-9\u00a0]+)(\\.([0-9]+))?");
  int pairs = 0;
  for (std::sregex_iterator it(tables.begin(), tables.end(), pair), end; it != end; ++it, ++pairs) {
    INFO(it->str());
    CHECK((*it)[3].length() == (*it)[6].length());
    std::string digits;
    for (const char c : (*it)[4].str() + (*it)[6].str())
      if (std::isdigit(static_cast<unsigned char>(c)) != 0 && (c != '0' || !digits.empty())) digits += c;
    CHECK(digits.size() >= 2);
    CHECK(digits.find_first_not_of('0', 2) == std::string::npos);
  }
  const std::regex ratio("[0-9.\u00a0]+ \\([0-9.\u00a0]+ to [0-9.\u00a0]+");
  const auto ratios = std::distance(std::sregex_iterator(tables.begin(), tables.end(), ratio), std::sregex_iterator());
  CHECK(pairs + ratios > 20);
  // Outside of tags and settings, breaking spaces are not allowed between digits, before a unit or beside a sign.
  std::string text;
  bool tag = false;
  const std::size_t body = report.find("<body>");
  for (const char c : report.substr(body, report.find("<h2>Settings") - body)) {
    tag = tag || c == '<';
    text += tag ? '|' : c;
    tag = tag && c != '>';
  }
  for (const char* bad : {"[0-9] [0-9]", "[0-9] (N|mm|s|ms|kN/m|N/m|%)[^a-zA-Z]", "± ", " ±", "[^a-z]N (m|s/m)",
                          "[^0-9a-zA-Z-]-[0-9]", "[KDCF]_"}) {
    INFO(bad);
    std::smatch found;
    const bool has = std::regex_search(text, found, std::regex(bad));
    INFO((has ? std::string(found.prefix()).substr(std::max<std::ptrdiff_t>(0, found.position() - 40)) + found.str()
              : ""));
    CHECK_FALSE(has);
  }
  // Terms are defined before the tables and figures that use them.
  for (const auto& [term, use] : {std::pair("<dt>First impact", "Figure 2."), std::pair("<dt>Scenario 2", "Figure 2."),
                                  std::pair("query points</b>", "<table>")})
    CHECK(report.find(term) < report.find(use));
  CHECK(report.find("<dt>First impact") != std::string::npos);
}

TEST_CASE("study: --verify repeats runs, and finds a changed bit, a changed table and a changed device",
          "[study_command]") {
  const test::TemporaryFolder folder;
  std::filesystem::copy_file(test::deviceFile("tau-nominal.toml"), folder / "device.toml");
  REQUIRE(run(study(folder, "out", kSmall + "--device '" + (folder / "device.toml") + "' --threads 2")).status == 0);
  const std::string verify = "study --verify '" + (folder / "out") + "'";
  const auto good = run(verify);
  INFO(good.output);
  CHECK(good.status == 0);
  CHECK_THAT(good.output, ContainsSubstring("verified: 20 of 20 runs are repeated to the last bit"));
  const auto refused = [&](const std::string& name, const std::string& text, const std::string& why) {
    const std::string before = test::readFile(folder / name);
    test::writeFile(folder / name, text);
    const auto result = run(verify);
    INFO(result.output);
    CHECK(result.status == 1);
    CHECK_THAT(result.output, ContainsSubstring(why));
    test::writeFile(folder / name, before);
  };
  std::string runs = file(folder, "out", "runs.csv");
  const std::size_t digit = runs.find_last_of("123456789", runs.rfind(','));  // of the last run, not its last number
  runs[digit] = runs[digit] == '9' ? '8' : static_cast<char>(runs[digit] + 1);
  refused("out/runs.csv", runs, "runs.csv: run 20 differs when repeated");
  refused("out/points.csv", file(folder, "out", "points.csv") + "x", "points.csv: does not follow from runs.csv");
  std::string device = test::readFile(folder / "device.toml");
  refused("device.toml", device + "# changed\n", "study.json: holds another study: its device is");
  refused("out/command.json", "{}", "command.json: must be a list of texts");
  CHECK_THAT(run("study --verify '" + (folder / "none") + "'").output, ContainsSubstring("none/command.json"));
}

TEST_CASE("study: convergence finds the default", "[study_command]") {
  const test::TemporaryFolder folder;
  const auto result = run(convergingStudy(
      folder, "speed", "--convergence --renderers hold,impedance --grid " + std::string(kLong ? "3" : "1")));
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK(result.output.find("is Runge-Kutta 4 with 1 step a tick") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(folder / "speed/runs.csv"));
  const std::string table = file(folder, "speed", "convergence.csv");
  CHECK(std::count(table.begin(), table.end(), '\n') == 1 + 3 * 4);
  CHECK(file(folder, "speed", "convergence.html").find("Speed against error") != std::string::npos);
}

TEST_CASE("study: parts in any order, also interrupted, give the bytes of the whole", "[study_command]") {
  const test::TemporaryFolder folder;
  const std::string small = "--renderers impedance,hold --scenario 1,2 --grid 2 --runs 3 --delay random:0..2 ";
  REQUIRE(run(study(folder, "whole", small)).status == 0);
  for (const int part : {3, 1}) {
    const auto result = run(study(folder, "parts", small + "--part " + std::to_string(part) + "/3"));
    REQUIRE(result.status == 0);
    CHECK_THAT(result.output, ContainsSubstring("part " + std::to_string(part) + " of 3 is done"));
    CHECK_FALSE(std::filesystem::exists(folder / "parts/runs.csv"));
  }
  // A killed process leaves a part of a line.
  const std::string first = folder / "parts/runs-1-of-3.csv";
  const std::string lines = test::readFile(first);
  test::writeFile(first, lines.substr(0, lines.size() / 2));
  CHECK_THAT(run(study(folder, "parts", small + "--part 2/3")).output, ContainsSubstring("part 2 of 3 is done"));
  CHECK_FALSE(std::filesystem::exists(folder / "parts/runs.csv"));
  REQUIRE(run(study(folder, "parts", small + "--part 1/3")).status == 0);
  CHECK(test::readFile(first) == lines);
  for (const char* which : {"runs.csv", "points.csv", "summary.json", "study.json", "report.html"})
    CHECK(file(folder, "parts", which) == file(folder, "whole", which));

  CHECK_THAT(run(study(folder, "parts", small + "--seed 2 --part 1/3")).output, ContainsSubstring("another study"));
  for (const char* bad : {"0/3", "4/3", "1", "1/3x"})
    CHECK_THAT(run(study(folder, "bad", small + "--part " + bad)).output, ContainsSubstring("--part"));
  // Under Open MPI a process performs the part of its rank.
  const auto ranked = test::runCommand("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=1 '" ENAMEL_TOOL "' " +
                                       study(folder, "ranked", small));
  CHECK_THAT(ranked.output, ContainsSubstring("part 2 of 2 is done"));
}

}  // namespace enamel::test_study_command
