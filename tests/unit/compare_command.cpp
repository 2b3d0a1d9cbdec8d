// `enamel compare` as a user runs it, and its former names.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/study/wall_design.hpp"
#include "enamel/study/wall_trials.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "support/text.hpp"
#include "support/xml.hpp"

namespace enamel::test_compare_command {

using test::ContainsSubstring;
using test::occurrences;
using test::run;

namespace {

const std::string kNominal = "--device '" + test::deviceFile("tau-nominal.toml") + "' ";

std::string servoFile(const std::string& name) { return ENAMEL_SOURCE_DIR "/data/servos/" + name; }

std::string file(const test::TemporaryFolder& folder, const std::string& name, const std::string& which) {
  return test::readFile(folder / (name + "/" + which));
}

// Return a small file of tuned parameters.
std::string tunedValues(const test::TemporaryFolder& folder) {
  const std::string path = folder / "tuned.json";
  test::writeFile(path, R"({"model": "tau", "controllers": [
    {"controller": "impedance", "delay": [0, 0], "stiffness": 10000, "damping": 100},
    {"controller": "hold-delay", "delay": [2, 2], "rate weight": 1, "position weight": 1000, "integral weight": 1e7},
    {"controller": "impedance", "delay": [2, 2], "stiffness": 800, "damping": 20},
    {"controller": "hold-delay", "delay": [0, 0], "rate weight": 1, "position weight": 1000, "integral weight": 1e7}]})");
  return path;
}

}  // namespace

TEST_CASE("compare: a table, a column a renderer, and what it refuses", "[compare_command]") {
  const std::string small = "compare " + kNominal + "--runs 1 ";
  const auto result =
      run(small + "--tasks release --renderers position-control,impedance,'" + servoFile("tau-hold-0.json") + "'");
  INFO(result.output);
  CHECK(result.status == 0);
  for (const char* part :
       {"position-control", " impedance", " tau-hold-0", "speed over the unavoidable", "plant closed-form"})
    CHECK_THAT(result.output, ContainsSubstring(part));
  CHECK_THAT(result.output, !ContainsSubstring("overload"));
  for (const auto& [arguments, message] :
       {std::pair{"--tasks wish", "no task matches --tasks wish: must be part of the name of a task: push, step, ramp"},
        {"--tasks push", "give --output"},
        {"--renderers wish", "wish"},
        {"--renderers missing.json", "missing.json"},
        {"--set a=b", "--set gives a, which is not a parameter of any plugin in --renderers"},
        {"--delays later", "--delay is \"later\""},
        {"--plants wish", "--plants"},
        {"--inertia 0", "the inertia is 0"},
        {"--plant imperfect", "--plant"}}) {
    INFO(arguments);
    const auto refused = run(small + arguments);
    CHECK(refused.status != 0);
    CHECK_THAT(refused.output, ContainsSubstring(message));
  }
}

TEST_CASE("compare: its tasks are the library's trials, to the last bit", "[compare_command]") {
  const test::TemporaryFolder folder;
  const auto result = run("compare " + kNominal +
                          "--tasks release,ramp --renderers impedance --stiffness 3000 --damping 2 --device-damping 4 "
                          "--plants closed-form --delays constant:1 --inertia 0.7 --noise 0.3 --seed 5 --runs 2 "
                          "--output '" +
                          (folder / "out") + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK_FALSE(std::filesystem::exists(folder / "out/compare.csv"));  // without a push
  DeviceParameters damped = loadDevice(test::deviceFile("tau-nominal.toml"));
  addDamping(damped, 4.0 * Vec6::Unit(2));
  WallTrialSetup setup;
  setup.plant = makeMechanism(damped);
  setup.model = withInertia(makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml"))), 0.7);
  setup.renderer = [] { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{3000.0, 2.0}); };
  setup.delay = {1, 1};
  setup.noise = 0.3;
  setup.seed = 5;
  setup.runs = 2;
  std::istringstream lines(file(folder, "out", "tasks.csv"));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "plant,delay,renderer,task,figure,unit,value,runs lost");
  for (const char* task : {"ramp", "release"})  // in the library's order
    for (const WallFigure& figure : runWallTrials(setup, task, 2)) {
      INFO(figure.figure);
      REQUIRE(std::getline(lines, line));
      CHECK_THAT(line,
                 ContainsSubstring("closed-form,constant:1,impedance," + figure.trial + "," + figure.figure + ","));
      const std::size_t end = line.rfind(','), begin = line.rfind(',', end - 1);
      CHECK(std::stod(line.substr(begin + 1, end - begin - 1)) == figure.value);
      CHECK(std::stoi(line.substr(end + 1)) == figure.lost);
    }
  CHECK_FALSE(std::getline(lines, line));
  const std::string page = file(folder, "out", "compare.html");
  CHECK_THAT(page, ContainsSubstring("release: pull"));
  CHECK(test::xmlProblem(page) == "");
}

TEST_CASE("the names of files and devices are text on every page", "[compare_command]") {
  const test::TemporaryFolder folder;
  const std::string name = "<b title=x>&lt;\xff", shown = "&lt;b title=x&gt;&amp;lt;\ufffd";
  const std::string servo = folder / (name + ".json"), device = folder / "device.toml";
  std::filesystem::copy_file(servoFile("tau-hold-0.json"), servo);
  std::string text = test::readFile(test::deviceFile("tau-nominal.toml"));
  text.replace(text.find("TAU nominal"), std::string("TAU nominal").size(), "<i>\\uFFFE</i>");
  test::writeFile(device, text);
  const std::string small =
      " --device '" + device + "' --grid 1 --runs 2 --renderers position-control,impedance,'" + servo + "' ";
  const auto compared = run("compare" + small + "--plants closed-form --delays none --tasks push,release --output '" +
                            (folder / "compared") + "'");
  const auto studied = run("study --no-convergence" + small + "--output '" + (folder / "studied") + "'");
  INFO(compared.output << studied.output);
  REQUIRE((compared.status == 0 && studied.status == 0));
  for (const std::string& page : {file(folder, "compared", "compare.html"), file(folder, "studied", "report.html")}) {
    CHECK(test::xmlProblem(page) == "");
    // The scripts after the texts have no names but in JSON, where "<" is escaped.
    CHECK(occurrences(page, "<b title") + occurrences(page.substr(0, page.find("<script")), "<i>") +
              occurrences(page, "\xff") + occurrences(page, "\ufffe") ==
          0);
    CHECK(occurrences(page, shown) > 3);
    CHECK_THAT(page, ContainsSubstring("&lt;i&gt;\ufffd&lt;/i&gt;"));
  }
  // In CSV files it could end a cell or a line.
  for (const char* bad : {"a\nb", "a\"b"}) {
    const std::string path = folder / (std::string(bad) + ".json");
    std::filesystem::copy_file(servoFile("tau-hold-0.json"), path);
    const auto refused = run("study --no-convergence --renderers '" + path + "' --output '" + (folder / "bad") + "'");
    CHECK(refused.status == 1);
    CHECK_THAT(refused.output, ContainsSubstring("must not contain a comma, quote or control character"));
  }
}

TEST_CASE("compare: a model with the wrong inertia reaches the pushes too", "[compare_command]") {
  const test::TemporaryFolder folder;
  const auto stiffness = [&](const std::string& name, const std::string& more) {
    const auto result = run("compare " + kNominal +
                            "--tasks push --renderers position-control --plants closed-form --delays none "
                            "--scenario 1 --grid 1 --runs 2 --output '" +
                            (folder / name) + "' " + more);
    INFO(result.output);
    REQUIRE(result.status == 0);
    const std::string study = file(folder, name, "closed-form-none/study.json");
    CHECK((study.find("inertia of the model") != std::string::npos) == !more.empty());
    return nlohmann::json::parse(file(folder, name, "closed-form-none/summary.json"))
        .at("walls")[0]
        .at("lowest K_z1 [N/m]")
        .at("value")
        .get<double>();
  };
  CHECK(stiffness("light", "--inertia 0.7") != stiffness("right", ""));
}

TEST_CASE("compare: a finger that rests carries its share of the push", "[compare_command]") {
  const test::TemporaryFolder folder;
  const auto stiffness = [&](const std::string& name, const std::string& more) {
    const auto result = run("compare " + kNominal +
                            "--tasks push --renderers impedance --plants closed-form --delays none --scenario 2 "
                            "--grid 1 --runs 2 --output '" +
                            (folder / name) + "' " + more);
    INFO(result.output);
    REQUIRE(result.status == 0);
    CHECK((file(folder, name, "closed-form-none/study.json").find("finger rest") != std::string::npos) ==
          !more.empty());
    return nlohmann::json::parse(file(folder, name, "closed-form-none/summary.json"))
        .at("walls")[0]
        .at("lowest K_zs [N/m]")
        .at("value")
        .get<double>();
  };
  // The wall has 6 kN/m, the finger 1 kN/m. The noise of the hand moves the tool by the sum.
  CHECK(stiffness("rest", "--finger-rest") / stiffness("free", "") == Approx(7.0 / 6.0).epsilon(0.03));
}

TEST_CASE("compare: ranks computed from the runs, the same bytes in parts", "[compare_command]") {
  const test::TemporaryFolder folder;
  const std::string small = "compare --device '" + test::deviceFile("tau-detailed.toml") + "' --tuned '" +
                            tunedValues(folder) + "' --delays none,constant:2 --grid 1 --runs 2 --scenario 1 " +
                            (test::longRun() ? "" : "--tasks push,release ") +  // otherwise all five
                            "--renderers position-control,tuned:impedance,tuned:hold-delay,impedance-edge,impedance ";
  const auto compare = [&](const std::string& name, const std::string& more) {
    return run(small + "--output '" + (folder / name) + "' " + more);
  };
  const auto whole = compare("whole", "--plants closed-form,imperfect-stiff");
  INFO(whole.output);
  REQUIRE(whole.status == 0);
  CHECK_THAT(whole.output, ContainsSubstring("On the ideal device: position control ranks first at 2 of 2 delays"));
  const std::string table = file(folder, "whole", "compare.csv"), page = file(folder, "whole", "compare.html");
  CHECK(std::count(table.begin(), table.end(), '\n') == 1 + 2 * 2 * 5);
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);
  double ranks = 0.0;
  while (std::getline(lines, line)) ranks += std::stod(line.substr(line.rfind(',') + 1));
  CHECK(ranks == Approx(2 * 2 * 15.0));  // 1 + 2 + 3 + 4 + 5 for every plant and delay, even with ties
  for (const char* part : {"Holm", "Table III", "hold that foresees the delay", "at the edge of eq. 16", "tuned"})
    CHECK_THAT(page, ContainsSubstring(part));
  CHECK_THAT(page, ContainsSubstring("Every other task"));
  const std::string text = page.substr(0, page.find("<script"));
  CHECK_THAT(text, !ContainsSubstring("nan") && !ContainsSubstring("inf,"));
  CHECK(test::xmlProblem(page) == "");
  // Two plants with three figures each: boxes of five renderers at two delays, on one scale for both plants.
  if (page.find("built without Vega") == std::string::npos) {
    std::vector<std::string> ranges;
    for (const char* name : {"stiffness", "depth"})
      for (const char* plant : {"closed-form", "imperfect-stiff"}) {
        const std::string id = std::string("id=\"") + name + "-" + plant + "-data\">";
        const std::size_t at = page.find(id) + id.size();
        const auto panel = nlohmann::json::parse(page.substr(at, page.find("</script>", at) - at)).at("panels").at(0);
        CHECK(panel.at("layers").at(0).at("boxes").size() == 2 * 5);
        ranges.push_back(panel.at("y").at("low").dump() + " " + panel.at("y").at("high").dump());
      }
    CHECK((ranges[0] == ranges[1] && ranges[2] == ranges[3] && ranges[0] != ranges[2]));
  }
  // The fastest plant.
  const std::string fast = "--plants closed-form ";
  REQUIRE(compare("one", fast).status == 0);
  REQUIRE(compare("parts", fast + "--part 2/2").status == 0);
  CHECK_FALSE(std::filesystem::exists(folder / "parts/compare.html"));
  REQUIRE(compare("parts", fast + "--part 1/2 --threads 1").status == 0);
  CHECK(file(folder, "parts", "compare.html") == file(folder, "one", "compare.html"));
  CHECK(file(folder, "parts", "compare.csv") == file(folder, "one", "compare.csv"));

  const auto refused = [&](const std::string& more, const std::string& why) {
    const auto result = compare("bad", more);
    CHECK(result.status != 0);
    CHECK_THAT(result.output, ContainsSubstring(why));
  };
  refused("--delays constant:1", "has no values of impedance for a delay of 1 to 1 ticks");
  refused("--device-damping impedance=4", "impedance-edge needs device damping");
}

TEST_CASE("compare searches the best spring for each delay", "[compare_command]") {
  const test::TemporaryFolder folder;
  const auto result =
      run("compare --device '" + test::deviceFile("cartesian-3.toml") +
          "' --renderers position-control,best-spring --device-damping 0 --tasks push --scenario 1 "
          "--plants closed-form --delays none,constant:2 --grid 1 --runs 4 --force 0.5,1 --preload 0.07 "
          "--noise 0.03 --output '" +
          (folder / "out") + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  std::vector<double> found;  // kN/m
  for (std::size_t at = 0; (at = result.output.find("best-spring: ", at)) != std::string::npos; ++at)
    found.push_back(std::stod(result.output.substr(at + 13)));
  REQUIRE(found.size() == 2);
  CHECK(found[0] > 2.0 * found[1]);
  for (const char* row : {"none,best-spring,4,0,", "constant:2,best-spring,4,0,"})  // four runs, none lost
    CHECK_THAT(file(folder, "out", "compare.csv"), ContainsSubstring(row));
  CHECK_THAT(file(folder, "out", "compare.html"), ContainsSubstring("best spring"));
  const auto study = nlohmann::json::parse(file(folder, "out/closed-form-none", "study.json"));
  CHECK(std::stod(study.at("servo gains").at("best-spring").get<std::string>()) ==
        Approx(1e3 * found[0]).epsilon(1e-3));
}

TEST_CASE("the names of version 0.2 do the same, with a warning that has the new ones", "[compare_command]") {
  const test::TemporaryFolder folder;
  // The first line is the warning. The rest must equal the output of the new names.
  const auto same = [](const std::string& old, const std::string& today) {
    INFO(old);
    const auto before = run(old), after = run(today);
    INFO(before.output);
    CHECK(before.status == 0);
    REQUIRE(after.status == 0);
    const std::size_t end = before.output.find('\n');
    REQUIRE(end != std::string::npos);
    CHECK_THAT(before.output.substr(0, end),
               ContainsSubstring("enamel: warning: an old name") &&
                   ContainsSubstring("write: enamel " + today.substr(0, today.find(' '))));
    CHECK(before.output.substr(end + 1) == after.output);
    CHECK_THAT(after.output, !ContainsSubstring("warning"));
  };
  const std::string servo = servoFile("tau-hold-1.json");
  same("trials " + kNominal + "--runs 1 --filter ramp --delay constant:1 --gain='" + servo + "' --renderers hold",
       "compare --release --device-damping 0 " + kNominal +
           "--runs 1 --tasks ramp --delays constant:1 --renderers hold,'" + servo + "'");
  same("trials " + kNominal + "--runs 1 --filter slide",
       "compare --release --device-damping 0 " + kNominal +
           "--runs 1 --tasks slide --renderers position-control,hold,impedance");
  const auto output = [&](const std::string& name) { return "--output '" + (folder / name) + "' "; };
  const std::string tiny = kNominal + "--plants closed-form --delays none --grid 1 --runs 1 --scenario 1 ",
                    spring = "--renderers tuned:impedance ", values = "'" + tunedValues(folder) + "' ";
  REQUIRE(run("study --judge --encoders " + tiny + spring + output("judge") + "--laws " + values).status == 0);
  REQUIRE(run("compare " + tiny + spring + output("compare") + "--tuned " + values).status == 0);
  for (const char* name : {"compare.csv", "tasks.csv", "compare.html", "closed-form-none/runs.csv"})
    CHECK(file(folder, "judge", name) == file(folder, "compare", name));
  const std::string study = "study --no-convergence --grid 1 --runs 1 --scenario 1 " + spring;
  const auto warned = run(study + output("old") + "--laws=" + values);
  CHECK(warned.status == 0);
  CHECK_THAT(warned.output, ContainsSubstring("--tuned=") && !ContainsSubstring("--laws"));
  REQUIRE(run(study + output("new") + "--tuned " + values).status == 0);
  CHECK(file(folder, "old", "runs.csv") == file(folder, "new", "runs.csv"));
  // If neither name is right, the message uses the new one.
  CHECK_THAT(run("trials --filter ramp").output, ContainsSubstring("--device is required"));
}

}  // namespace enamel::test_compare_command
