// The command line from a user's view.
#include <filesystem>
#include <map>
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

std::string device() { return "--device '" + test::deviceFile("tau-nominal.toml") + "' "; }

// Return the contents of all files in a folder, by name.
std::map<std::string, std::string> contentOf(const std::string& folder) {
  std::map<std::string, std::string> content;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) content[entry.path().string()] = test::readFile(entry.path().string());
  return content;
}

// Return K_z1 of position control with encoders, N/m; nothing if it is undefined.
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

TEST_CASE("case 08: a study writes into a folder with results only with --resume or --overwrite", "[cases]") {
  const test::TemporaryFolder folder;
  const std::string study =
      "study --renderers impedance --scenario 1 --grid 1 --no-convergence --threads 1 --output '" + (folder / "out") +
      "' ";
  const test::CommandResult first = run(study + "--runs 2");
  INFO(first.output);
  REQUIRE(first.status == 0);
  const auto before = contentOf(folder / "out");
  CHECK(before.count(folder / "out/runs.csv") == 1);
  const auto refused = [&](const std::string& options, const std::string& reason) {
    const test::CommandResult result = run(study + options);
    INFO(options << ": " << result.output);
    CHECK(result.status == 1);
    CHECK(result.output.find('\n') == result.output.size() - 1);
    CHECK(holds(result.output, reason));
    CHECK(contentOf(folder / "out") == before);
  };
  const std::string exists = "out/runs.csv: exists; --resume continues it, --overwrite replaces it";
  refused("--runs 3", exists);
  refused("--runs 2 --seed 9", exists);
  refused("--runs 2", exists);
  refused("--runs 3 --resume", "out/study.json: holds another study: its runs is 2, here it is 3");
  refused("--runs 3 --part 1/2", "out/study.json: holds another study: its runs is 2, here it is 3");
  refused("--runs 3 --overwrite --resume", "--overwrite starts again and excludes --resume and --part");
  refused("--runs 3 --overwrite --part 1/2", "--overwrite starts again and excludes --resume and --part");
  for (const char* again : {"--runs 2 --resume", "--runs 2 --overwrite"}) {  // the same study gives the same bytes
    CHECK(run(study + again).status == 0);
    CHECK(contentOf(folder / "out") == before);
  }
  CHECK(run(study + "--runs 3 --overwrite").status == 0);
  CHECK(contentOf(folder / "out").at(folder / "out/runs.csv") != before.at(folder / "out/runs.csv"));
  CHECK(contentOf(folder / "out").at(folder / "out/report.html") != before.at(folder / "out/report.html"));
  // Every other result is protected too, even without study.json.
  std::filesystem::remove(folder / "out/study.json");
  std::filesystem::remove(folder / "out/runs.csv");
  for (const char* options : {"--runs 3", "--runs 3 --resume", "--runs 3 --part 1/2"})
    CHECK(holds(run(study + options).output, "out/points.csv: exists; --overwrite replaces it"));
}

TEST_CASE("case 08: unfinished parts of a study are not lost to another one", "[cases]") {
  const test::TemporaryFolder folder;
  const std::string study =
      "study --renderers impedance --scenario 1 --grid 1 --no-convergence --threads 1 --output '" + (folder / "out") +
      "' ";
  REQUIRE(run(study + "--runs 2 --part 1/2").status == 0);
  const auto before = contentOf(folder / "out");
  for (const char* options : {"--runs 3", "--runs 3 --resume", "--runs 3 --part 2/2"}) {
    const test::CommandResult other = run(study + options);
    INFO(options << ": " << other.output);
    CHECK(other.status == 1);
    CHECK(holds(other.output, "out/study.json: holds another study: its runs is 2, here it is 3"));
    CHECK(contentOf(folder / "out") == before);
  }
  CHECK(run(study + "--runs 2 --overwrite").status == 0);
  CHECK(contentOf(folder / "out").count(folder / "out/runs-1-of-2.csv") == 0);
}

TEST_CASE("case 08: no command overwrites a result unasked", "[cases]") {
  const test::TemporaryFolder folder;
  const std::string push = "push " + device() + "--renderer impedance --device-damping 4 --duration 1.1 ";
  const std::string recording = "'" + (folder / "push.rec") + "' ", rows = folder / "rows.json";
  test::writeFile(rows, "[{\"q\": [0, 0, 0, 0, 0, 0]}]");
  struct Writer {
    std::string command, file;
  };
  const Writer writers[] = {
      {push + "--record ", "push.rec"},
      {push + "--output ", "push.csv"},
      {"replay " + recording + "--html ", "page.html"},
      {"export " + recording + "--csv ", "export.csv"},
      {"design " + device() + "--output ", "servo.json"},
      {"design " + device() + "--impedance-map ", "map.csv"},
      {"evaluate " + device() + "--input '" + rows + "' --output ", "evaluate.json"},
      {"mesh --generate molar --output ", "molar.ply"},
      {"bench --filter device --scale 0.01 --report ", "bench.md"},
      {"fmu " + device() + "--output ", "unit.fmu"},
  };
  for (const auto& [command, name] : writers) {
    INFO(command << name);
    const std::string file = folder / name, to = "'" + file + "'";
    const test::CommandResult first = run(command + to);
    if (holds(first.output, "not expected") || holds(first.output, "built without three.js")) continue;  // not built in
    INFO(first.output);
    REQUIRE(first.status == 0);
    const bool isRecording = name == "push.rec";
    if (!isRecording) test::writeFile(file, "mine");
    const std::string before = test::readFile(file);
    const test::CommandResult second = run(command + to);
    CHECK(second.status == 1);
    CHECK(second.output == "enamel: " + file + ": exists; --overwrite replaces it\n");
    CHECK(test::readFile(file) == before);
    CHECK(run(command + to + " --overwrite").status == 0);
    CHECK(test::readFile(file).size() > (isRecording ? 1000u : 4u));
    test::writeFile(file, "");  // an empty file is not a result
    CHECK(run(command + to).status == 0);
    CHECK(test::readFile(file).size() > 4);
  }
  // The standard output is not our file, wherever it leads.
  test::writeFile(folder / "all.csv", "mine\n");
  CHECK(test::runCommand("{ '" ENAMEL_TOOL "' export " + recording + "--csv /dev/stdout >> '" + (folder / "all.csv") +
                         "'; }")
            .status == 0);
  const bool isAppended = test::readFile(folder / "all.csv") == "mine\n" + test::readFile(folder / "export.csv");
  CHECK(isAppended);
  // Neither a link nor its target is removed.
  std::filesystem::create_symlink(folder / "push.rec", folder / "link.rec");
  const std::string recorded = test::readFile(folder / "push.rec");
  CHECK(holds(run(push + "--overwrite --record '" + (folder / "link.rec") + "'").output, "cannot make the recording"));
  CHECK(std::filesystem::is_symlink(folder / "link.rec"));
  CHECK(test::readFile(folder / "push.rec") == recorded);
  // Each renderer of a push has its own file.
  test::writeFile(folder / "two-hold.csv", "mine");
  const test::CommandResult two =
      run("push " + device() + "--renderer impedance,hold --output '" + (folder / "two.csv") + "'");
  CHECK(two.output == "enamel: " + (folder / "two-hold.csv") + ": exists; --overwrite replaces it\n");
  CHECK_FALSE(std::filesystem::exists(folder / "two-impedance.csv"));
  // compare has its own files, and the folders of its pushes.
  const std::string compare =
      "compare " + device() +
      "--renderers impedance --tasks ramp --runs 1 --plants closed-form --delays none --output '" +
      (folder / "compare") + "' ";
  REQUIRE(run(compare).status == 0);
  const auto before = contentOf(folder / "compare");
  CHECK(holds(run(compare + "--seed 2").output, "compare/tasks.csv: exists; --overwrite replaces it"));
  CHECK(holds(run(compare + "--resume").output, "compare/tasks.csv: exists; --overwrite replaces it"));
  CHECK(contentOf(folder / "compare") == before);
  CHECK(run(compare + "--seed 2 --overwrite").status == 0);
  CHECK(contentOf(folder / "compare") != before);
}

TEST_CASE("case 08: a recording with a damaged chunk is damaged, not equal", "[cases]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "push.rec";
  REQUIRE(run("push " + device() + "--renderer impedance --device-damping 4 --duration 1.1 --record '" + file + "'")
              .status == 0);
  const std::string whole = test::readFile(file);
  CHECK(holds(run("replay '" + file + "'").output, "equal, bit for bit"));
  std::string flipped = whole;
  flipped[whole.size() / 2] = static_cast<char>(flipped[whole.size() / 2] ^ 1);
  for (const std::string& bytes : {flipped, whole.substr(0, whole.size() - 1000), whole + "more"}) {
    test::writeFile(file, bytes);
    const test::CommandResult result = run("replay '" + file + "'");
    INFO(result.output);
    CHECK(result.status == 1);
    CHECK(holds(result.output, "push.rec: damaged"));
    CHECK_FALSE(holds(result.output, "equal"));
  }
}

TEST_CASE("case 14: under encoders and a preload the stiffness is that of the wall", "[cases]") {
  const auto preloaded = stiffness("--preload 1");
  REQUIRE(preloaded);
  CHECK(*preloaded > 1e5);
  const auto plain = stiffness("");
  CHECK((!plain || *plain > 0.0));
}

TEST_CASE("case 14: without a preload the stiffness does not count free flight", "[cases]") {
  const auto plain = stiffness(""), preloaded = stiffness("--preload 1");
  CAPTURE(plain.value_or(0.0), preloaded.value_or(0.0));
  CHECK((!plain || *plain > 0.4 * preloaded.value_or(0.0)));
}

}  // namespace enamel::test_commands
