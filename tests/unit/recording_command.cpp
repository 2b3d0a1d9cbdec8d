// push --record, replay and export as a user runs them.
#include <csignal>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/run_length.hpp"

namespace enamel::test_recording_command {

namespace {

const std::string kPush = "push --device '" ENAMEL_SOURCE_DIR "/data/devices/tau-nominal.toml' ";

}  // namespace

TEST_CASE("a recorded push replays bit for bit, linked and as a plugin", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "a.rec";
  const std::string duration = test::longRun() ? "600" : "1.5";
  const auto push = [&](const std::string& options) {
    std::filesystem::remove(file);
    const auto result = test::run(kPush + "--duration " + duration + " --record '" + file + "' " + options);
    INFO(result.output);
    REQUIRE(result.status == 0);
    CHECK_THAT(result.output, test::ContainsSubstring("recording: " + file));
  };
  const auto replay = [&](const std::string& options) { return test::run("replay '" + file + "' " + options); };
  const std::string servo = "--renderer '" ENAMEL_PLUGINS "/enamel_position_control.so' ",
                    wall = "--renderer '" ENAMEL_PLUGINS "/enamel_impedance.so' ";
  const auto equal = [&](const std::string& options) {
    const auto result = replay(options);
    INFO(result.output);
    CHECK(result.status == 0);
    CHECK_THAT(result.output, test::ContainsSubstring("equal, bit for bit"));
  };

  push("--encoders --delay random:0..2 --scene '" ENAMEL_SOURCE_DIR "/data/scenes/corner.toml'");
  equal("");
  equal(servo);
  equal("--from 5");
  push("--renderer hold --anti-windup on");
  equal("");
  equal(servo);
  push(servo + "--set mode=hold --set release=off");
  equal("");
  equal("--renderer hold");
  push("--renderer impedance --stiffness 3000 --damping 1.5 --device-damping 4");
  equal("");
  equal(wall);

  const auto other = replay("--set stiffness=3001");
  CHECK(other.status == 1);
  CHECK_THAT(other.output, test::ContainsSubstring(" ticks differ, first tick ") &&
                               test::ContainsSubstring(": recorded ") && test::ContainsSubstring(", replayed "));
  CHECK(replay(servo).status == 1);
  for (const auto& [options, problem] :
       {std::pair{"--set stiffness=x", "parameter stiffness of impedance is \"x\", must be a number"},
        {"--from 1000000", "a.rec: has 12 chunks, chunk 1000000 does not exist"},
        {"--renderer nothing", "unknown plugin \"nothing\""}}) {
    const auto refused = replay(options);
    CHECK(refused.status == 1);
    CHECK_THAT(refused.output, test::ContainsSubstring(problem));
  }
}

TEST_CASE("what a recording cannot be, and disks that are full", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "a.rec";
  const std::string push = kPush + "--renderer impedance --device-damping 4 --duration 1.5 --record ";
  REQUIRE(test::run(push + "'" + file + "'").status == 0);
  const std::string before = test::readFile(file);
  const auto again = test::run(push + "'" + file + "'");
  CHECK(again.status == 1);
  CHECK_THAT(again.output, test::ContainsSubstring("a.rec: exists; --overwrite replaces it"));
  CHECK(test::readFile(file) == before);

  for (const char* csv : {"a.rec", "link.csv"}) {
    if (csv != std::string("a.rec")) std::filesystem::create_symlink(file, folder / csv);
    const auto itself = test::run("export '" + file + "' --csv '" + (folder / csv) + "'");
    CHECK(itself.status == 1);
    CHECK_THAT(itself.output, test::ContainsSubstring("is the recording itself"));
  }
  const auto twice = test::run(push + "'" + (folder / "b") + "' --output '" + (folder / "./b") + "'");
  CHECK(twice.status == 1);
  CHECK_THAT(twice.output, test::ContainsSubstring("--record and --output must be different files"));
  CHECK(test::readFile(file) == before);

  const std::string full = folder / "full.rec";
  const auto limited = test::runCommand("ulimit -f 300; '" ENAMEL_TOOL "' " + push + "'" + full + "'");
  CHECK(limited.status == 1);
  CHECK_THAT(limited.output, test::ContainsSubstring("File too large") && test::ContainsSubstring("ticks are lost"));
  const auto rest = test::run("replay '" + full + "'");
  CHECK(rest.status == 0);
  CHECK_THAT(rest.output,
             test::ContainsSubstring("the recording was not closed") && test::ContainsSubstring("equal, bit for bit"));
  // If it cannot be replaced, the old recording remains complete; if there is room, it is replaced.
  const auto kept = test::runCommand("ulimit -f 300; '" ENAMEL_TOOL "' " + push + "'" + file + "' --overwrite");
  CHECK(kept.status == 1);
  CHECK_THAT(kept.output, test::ContainsSubstring("a.rec") && test::ContainsSubstring("File too large"));
  CHECK(test::readFile(file) == before);
  REQUIRE(test::run(push + "'" + file + "' --seed 7 --overwrite").status == 0);
  CHECK(test::readFile(file) != before);
  CHECK(test::run("replay '" + file + "'").status == 0);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "")) CHECK(entry.path().extension() != ".part");
  const auto nowhere = test::run(push + "/dev/full");
  CHECK(nowhere.status == 1);
  CHECK_THAT(nowhere.output, test::ContainsSubstring("/dev/full: cannot write the recording: No space left"));

  test::writeFile(folder / "text", "kind = 1\n");
  for (const std::string& other : {folder / "text", folder / "missing", std::string("/dev/null"), folder / "."})
    for (const char* command : {"replay '", "export --csv /dev/null '"}) {
      const auto refused = test::run(command + other + "'");
      INFO(refused.output);
      CHECK(refused.status == 1);
      CHECK_THAT(refused.output, test::ContainsSubstring(other + ": "));
    }
}

TEST_CASE("a recording as CSV: a line a tick, as many cells as names", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "a.rec", csv = folder / "a.csv", ticks = folder / "ticks.csv";
  REQUIRE(test::run(kPush + "--duration 1.5 --encoders --record '" + file + "' --output '" + ticks + "'").status == 0);
  const auto result = test::run("export '" + file + "' --csv '" + csv + "'");
  CHECK(result.status == 0);
  CHECK_THAT(result.output, test::ContainsSubstring("1500 ticks, 0 lost\n"));
  const auto table = [](const std::string& path) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(test::readFile(path));
    for (std::string line; std::getline(lines, line);) {
      rows.emplace_back();
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  };
  const auto rows = table(csv), own = table(ticks);
  REQUIRE(rows.size() == 1501);
  REQUIRE(own.size() == 1501);
  const auto column = [](const auto& of, const std::string& name) {
    return static_cast<std::size_t>(std::find(of[0].begin(), of[0].end(), name) - of[0].begin());
  };
  std::size_t uneven = 0;
  for (const auto& row : rows) uneven += row.size() != rows[0].size();
  CHECK(uneven == 0);
  for (const char* name : {"t [s]", "q1 [rad]", "q6 [rad]", "mode", "status", "guard"}) {
    INFO(name);
    const std::size_t a = column(rows, name), b = column(own, name);
    REQUIRE(a < rows[0].size());
    REQUIRE(b < own[0].size());
    for (const std::size_t i : {1u, 700u, 1500u}) CHECK(rows[i][a] == own[i][b]);
  }
  // The measured pose equals the true one within an encoder count.
  for (const std::size_t i : {1u, 1200u, 1500u})
    CHECK(std::abs(std::stod(rows[i][column(rows, "z [m]")]) - std::stod(own[i][column(own, "z [m]")])) < 5e-5);
  CHECK(rows[0][column(rows, "rate2 [rad/s]")] == "rate2 [rad/s]");
  CHECK(rows[0][column(rows, "command6 [N m]")] == "command6 [N m]");
}

}  // namespace enamel::test_recording_command
