// `enamel` with invalid files and streams: one line reports it, and nothing is lost.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_file_command {

using test::ContainsSubstring;

namespace {

const std::string kTool = "'" ENAMEL_TOOL "' ";
const std::string kDevice = "--device '" + test::deviceFile("tau-nominal.toml") + "' ";
const std::string kPush = "push " + kDevice + "--renderer impedance --device-damping 4 --duration 1.1 ";

// Run a shell command that must fail with one line of the tool.
void refused(const std::string& command, const std::string& reason, int status = 1) {
  const auto result = test::runCommand(command);
  INFO(command << "\n" << result.output.substr(0, 3000));
  CHECK(result.status == status);
  CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
  CHECK(result.output.rfind("enamel: ", 0) == 0);
  CHECK_THAT(result.output, ContainsSubstring(reason));
  for (const char c : result.output) REQUIRE((c == '\n' || !std::iscntrl(static_cast<unsigned char>(c))));
}

std::size_t filesIn(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

}  // namespace

TEST_CASE("a full disk is told, and what was there stays", "[file_command]") {
  const test::TemporaryFolder folder;
  for (const std::string& command :
       {std::string("mesh '" ENAMEL_SOURCE_DIR "/data/meshes/molar.ply'"), std::string("design --help"),
        std::string("plugins"), kPush, "design " + kDevice + "--output '" + (folder / "servo.json") + "'"})
    refused("{ " + kTool + command + " >/dev/full; }", "cannot write to the standard output: No space left on device");

  test::writeFile(
      folder / "rows.json", "[" + [] {
        std::string rows = "{\"q\": [0, 0, 0, 0, 0, 0]}";
        for (int i = 0; i < 40; ++i) rows += ", {\"q\": [0, 0, 0, 0, 0, 0]}";
        return rows;
      }() + "]");
  const std::string evaluate = "evaluate " + kDevice + "--input '" + (folder / "rows.json") + "' ";
  std::filesystem::create_directory(folder / "out");
  const std::string out = folder / "out/old";
  for (const std::string& command :
       {evaluate + "--overwrite --output ", "design " + kDevice + "--overwrite --output ",
        "design " + kDevice + "--overwrite --impedance-map ",
        std::string("mesh --generate molar --overwrite --output "), kPush + "--overwrite --output "}) {
    test::writeFile(out, "old");
    // A limit on the size of files simulates a full disk.
    refused("ulimit -f 1; " + kTool + command + "'" + out + "'", out + ": cannot write the file: File too large");
    CHECK(test::readFile(out) == "old");
    CHECK(filesIn(folder / "out") == 1);
    refused(kTool + command + "/dev/full", "/dev/full: cannot write the file: No space left on device");
    refused(kTool + command + "'" + (folder / "no/such/file") + "'", "No such file or directory");
  }
}

TEST_CASE("what a killed process left under the same number does not stop the next one", "[file_command]") {
  const test::TemporaryFolder folder;
  const std::string out = folder / "k.json";
  const auto result =
      test::runCommand("sh -c 'echo x >" + out + ".$$-0.part; exec \"" ENAMEL_TOOL "\" design --device \"" +
                       test::deviceFile("tau-nominal.toml") + "\" --output " + out + "'");
  INFO(result.output);
  CHECK(result.status == 0);
  CHECK(test::readFile(out).find("\"K\"") != std::string::npos);
  CHECK(filesIn(folder / "") == 2);
}

TEST_CASE("what is no plain file is not read", "[file_command]") {
  const test::TemporaryFolder folder;
  REQUIRE(mkfifo((folder / "pipe.ply").c_str(), 0600) == 0);
  const std::string pipe = "'" + (folder / "pipe.ply") + "' ";
  const std::string timely = "timeout 3000 " + kTool;
  for (const std::string& file : {pipe, std::string("/dev/zero ")}) {
    const std::string reason = "is a pipe or a device, must be a regular file";
    refused(timely + "push --device " + file, reason);
    refused(timely + "push " + kDevice + "--scene " + file, reason);
    refused(timely + "push " + kDevice + "--renderer hold --gain " + file, reason);
    refused(timely + "design --device " + file, reason);
    refused(timely + "mesh " + file, reason);
    refused(timely + "evaluate " + kDevice + "--output /dev/null --input " + file, reason);
    refused(timely + "study --output '" + (folder / "s") + "' --device " + file, reason);
    refused(timely + "check-plugin " + file, "no such file");
  }
  refused(kTool + "evaluate " + kDevice + "--output /dev/null --input /", "/: is a folder, not a file");
  test::writeFile(folder / "bad.json", "[\n{\"q\": [0, }]\n");
  refused(kTool + "evaluate " + kDevice + "--output /dev/null --input '" + (folder / "bad.json") + "'",
          "bad.json:2: is not valid JSON");
  test::writeFile(folder / "huge.json", "[{\"q\": [1e999, 0, 0, 0, 0, 0]}]");
  refused(kTool + "evaluate " + kDevice + "--output /dev/null --input '" + (folder / "huge.json") + "'",
          "outside the range of double precision");
}

TEST_CASE("nothing that a file or a command line holds reaches the terminal as it is", "[file_command]") {
  const test::TemporaryFolder folder;
  const std::string escape = "\x1b[2J\x07";
  const auto file = [&](const std::string& name, const std::string& text) {
    test::writeFile(folder / name, text);
    return "'" + (folder / name) + "' ";
  };
  refused(kTool + "push --device " + file("a.toml", "name = \"" + escape + "\"\n"), "a.toml:1");
  refused(kTool + "push --device " + file("b.toml", "name = \"x\"\n\"\\u001b[2J\" = 1\n"), "b.toml");
  refused(kTool + "push --device " + file("c.toml", "name = \"" + std::string(100000, 'x') + "\"\n"), "c.toml:1: name");
  refused(kTool + "push --device '" + escape + "'", "\\x1b[2J\\x07: cannot open the file");
  refused(kTool + "push " + kDevice + "--renderer '" + escape + "'", "unknown plugin \"\\x1b[2J\\x07\"");
  refused(kTool + "push " + kDevice + "'" + escape + "'", "\\x1b[2J", 2);
  refused(kTool + "push " + kDevice + "--force '" + escape + "'", "\\x1b[2J", 2);
  refused(kTool + "mesh " + file("d.obj", "v 1 2 " + escape + "\n"), "\\x1b[2J");
  refused(kTool + "mesh " + file("e.ply", "ply\nelement " + std::string(5000000, 'y') + " 5\nend_header\n\n"), "e.ply");
  refused(kTool + "push " + kDevice + "--scene " + file("f.toml", "name = 3\n" + std::string(200000, '[')), "f.toml:2");
  // A name that is not UTF-8 must still give valid JSON.
  std::filesystem::copy_file(test::deviceFile("tau-nominal.toml"), folder / "\xff.toml");
  CHECK(test::run("design --device '" + (folder / "\xff.toml") + "' --output '" + (folder / "k.json") + "'").status ==
        0);
}

TEST_CASE("options that are empty, too large or no numbers", "[file_command]") {
  for (const char* option : {"--force ''", "--force nan", "--force inf", "--seed ''", "--seed -1", "--x ''",
                             "--scenario -", "--substeps ''", "--duration 1e999", "--stiffness ' 1'", "--low-pass nan"})
    refused(kTool + kPush + option, "is not", 2);
  for (const char* option :
       {"--delay constant:4294967297", "--delay ''", "--delay constant:", "--delay random:0..4294967297"})
    refused(kTool + kPush + option, "--delay is \"");
  refused(kTool + "design " + kDevice + "--delay 4294967297", "--delay: Value 4294967297 not in range 0 to 3", 2);
  refused(kTool + "study --output /dev/null/x --grid 4294967297", "", 2);
}

TEST_CASE("study: streams that were closed do not become its files", "[file_command]") {
  const test::TemporaryFolder folder;
  const std::string small = "study --no-convergence --renderers impedance --scenario 1 --grid 1 --runs 4 --output ";
  const auto runs = [&](const std::string& name, const std::string& streams) {
    const auto result = test::runCommand("{ " + kTool + small + "'" + (folder / name) + "' " + streams + "; }");
    INFO(result.output);
    CHECK(result.status == 0);
    return test::readFile(folder / (name + "/runs.csv"));
  };
  const std::string whole = runs("whole", "");
  CHECK(std::count(whole.begin(), whole.end(), '\n') == 5);
  CHECK(runs("noError", "2>&-") == whole);
  CHECK(runs("none", "0<&- 1>&- 2>&-") == whole);

  // Files of others are never overwritten.
  const std::string path = folder / "whole/", again = kTool + small + "'" + path + "'";
  const std::string manifest = test::readFile(path + "study.json");
  const std::string exists = "runs.csv: exists; --resume continues it, --overwrite replaces it";
  for (const std::string& broken :
       {std::string(), std::string("{"), std::string("[]"), std::string("{\"runs\": \"x\", \"grid\": 1}"),
        std::string(200000, '['), manifest.substr(0, manifest.size() / 2)}) {
    test::writeFile(path + "study.json", broken);
    refused(again, exists);
    refused(again + " --resume", "study.json");
    CHECK(test::readFile(path + "runs.csv") == whole);
    CHECK(test::readFile(path + "study.json") == broken);
  }
  std::filesystem::remove(path + "study.json");
  refused(again + " --resume", "so the study of runs.csv is unknown");
  test::writeFile(path + "study.json", manifest);
  for (const std::string& foreign : {std::string("my,own\n1,2\n"), whole + whole}) {
    test::writeFile(path + "runs.csv", foreign);
    refused(again, exists);
    refused(again + " --resume", "runs.csv:");
    CHECK(test::readFile(path + "runs.csv") == foreign);
  }
  // A resumed study accepts only rows that it would have written.
  const std::size_t end = whole.size() - 1, comma = whole.rfind(',');
  for (const std::string& last : {std::string("-1"), std::string("nan"), std::string("1e300"), std::string("0.5"),
                                  std::string("00"), std::string("0 ")}) {
    test::writeFile(path + "runs.csv", whole.substr(0, comma + 1) + last + whole.substr(end));
    refused(again + " --resume", "runs.csv:5: ");
  }
  std::string depth = whole;
  const std::size_t first = whole.find("measured,") + 9;
  for (const char* value : {"nan", "inf", "-inf", "1e999", "+1"}) {
    depth = whole;
    depth.replace(first, whole.find(',', first) - first, value);
    test::writeFile(path + "runs.csv", depth);
    refused(again + " --resume", "runs.csv:2: ");
  }
  std::filesystem::remove(path + "runs.csv");
  REQUIRE(mkfifo((path + "runs.csv").c_str(), 0600) == 0);
  refused("timeout 3000 " + again, exists);
  refused("timeout 3000 " + again + " --resume", "runs.csv: ");
  std::filesystem::remove(path + "runs.csv");

  // Parts are rejected beside the runs of a process without --part. --overwrite removes parts, but no other file.
  test::writeFile(path + "runs.csv", whole.substr(0, whole.find('\n', whole.find('\n') + 1) + 1));
  refused(again + " --part 1/2", "runs.csv: has 1 of 4 runs");
  for (const char* name : {"runs-notes.txt", "runs-1-of-2.csv.bak", "runs-1-of-2.csv"})
    test::writeFile(path + name, "mine");
  CHECK(test::runCommand(again + " --overwrite").status == 0);
  CHECK(test::readFile(path + "runs-notes.txt") == "mine");
  CHECK(test::readFile(path + "runs-1-of-2.csv.bak") == "mine");
  CHECK_FALSE(std::filesystem::exists(path + "runs-1-of-2.csv"));

  // One study at a time: this test represents the other one.
  test::writeFile(path + "runs.csv", whole);
  const int lock = open(path.c_str(), O_RDONLY | O_DIRECTORY);
  REQUIRE(flock(lock, LOCK_EX) == 0);
  refused(again, "another study writes into the folder");
  CHECK(test::readFile(path + "runs.csv") == whole);
  close(lock);
  CHECK(test::runCommand(again + " --overwrite").status == 0);
  CHECK(test::readFile(path + "runs.csv") == whole);
}

TEST_CASE("meshes whose faces are more than their bytes", "[file_command]") {
  const test::TemporaryFolder folder;
  std::string off = "OFF\n9 2000 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 0\n1 0 1\n0 1 1\n1 1 1\n2 2 2\n", face = "255";
  for (int i = 0; i < 255; ++i) face += " " + std::to_string(i % 9);
  for (int i = 0; i < 2000; ++i) off += face + "\n";
  test::writeFile(folder / "fans.off", off);
  refused("timeout 3000 " + kTool + "mesh '" + (folder / "fans.off") + "'", "one for every 6 bytes");
}

}  // namespace enamel::test_file_command
