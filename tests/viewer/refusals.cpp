// Invalid input: one clear line and a status other than zero.
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "viewer/running_viewer.hpp"

namespace enamel::test_refusals {

namespace {

void requireRefused(const test::CommandResult& result, int status, const std::string& message) {
  INFO(result.output);
  CHECK(result.status == status);
  CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
  CHECK(result.output.rfind("enamel-viewer: ", 0) == 0);
  CHECK(result.output.find(message) != std::string::npos);
}

}  // namespace

TEST_CASE("scenes, devices and scripts that cannot be read", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "good.txt", "0 end\n");
  const std::string headless = "--headless --script '" + folder / "good.txt" + "' ";
  requireRefused(test::viewer(headless + "/no/such/scene.toml"), 1, "/no/such/scene.toml: cannot open the file");
  test::writeFile(folder / "broken.toml", "name = \"a\"\nstart = [0, 0,\n");
  requireRefused(test::viewer(headless + "'" + folder / "broken.toml'"), 1, "not valid TOML");
  test::writeFile(folder / "unknown.toml",
                  "name = \"a\"\nstart = [0, 0, 0]\ncolour = 1\n[[obstacle]]\nname = \"w\"\n"
                  "shape = \"half_space\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n");
  requireRefused(test::viewer(headless + "'" + folder / "unknown.toml'"), 1,
                 "unknown.toml:3: colour: is not a known key");
  requireRefused(test::viewer(headless + "--device /no/such/device.toml"), 1, "/no/such/device.toml: cannot open");
  requireRefused(test::viewer("--headless --script /no/such/script"), 1, "/no/such/script: cannot open the file");
  requireRefused(test::viewer("--headless"), 1, "--headless needs --script FILE");
  requireRefused(test::viewer(headless + "--renderer granite"), 1, "granite");
  for (const char* scale : {"nan", "inf", "''", "0x2", "-1", "1e999"})
    requireRefused(test::viewer(headless + "--scale " + scale), 2, "--scale: ");
  for (const char* rate : {"0", "nan", "-1", "1e999"})
    requireRefused(test::viewer("--script '" + folder / "good.txt' --frame-rate " + rate), 2, "--frame-rate: ");
  requireRefused(test::viewer(headless + "--frame-rate 30"), 2, "--headless excludes --frame-rate");
  REQUIRE(mkfifo((folder / "pipe").c_str(), 0600) == 0);
  requireRefused(test::viewer("--headless --script '" + folder / "pipe'"), 1,
                 "is a pipe or a device, must be a regular file");
  requireRefused(test::viewer("--headless --script /dev/zero"), 1, "is a pipe or a device, must be a regular file");
  test::writeFile(folder / "long.txt", std::string(2000000, 'x'));
  requireRefused(test::viewer("--headless --script '" + folder / "long.txt'"), 1, "at most 1048576 are read");
  test::writeFile(folder / "escape.txt", "0 \x1b[2J\n0 end\n");
  requireRefused(test::viewer("--headless --script '" + folder / "escape.txt'"), 1, "\\x1b[2J: is not a known command");
  requireRefused(test::viewer(headless + "--report /dev/full"), 1, "/dev/full: cannot write the file: No space left");
  test::writeFile(folder / "report.json", "mine");
  requireRefused(test::viewer(headless + "--report '" + folder / "report.json'"), 1,
                 "report.json: exists; --overwrite replaces it");
  CHECK(test::readFile(folder / "report.json") == "mine");
  for (const char* name : {"a", "frame-00000"}) {
    const test::TemporaryFolder out;
    const std::string picture = out / (name + std::string(".png"));
    test::writeFile(picture, "mine");
    test::writeFile(folder / "pictures.txt", "0 frames 60\n0.1 picture a\n0.1 picture a\n0.1 end\n");
    const std::string arguments = "--headless --script '" + folder / "pictures.txt' --record '" + out / "'";
    requireRefused(test::viewer(arguments), 1, picture + ": exists; --overwrite replaces it");
    CHECK(test::readFile(picture) == "mine");
    CHECK(test::viewer(arguments + " --overwrite").status == 0);
    CHECK(test::readFile(picture) != "mine");
  }
  requireRefused(test::viewer(headless + "--size huge"), 2, "--size is \"huge\", must be WIDTHxHEIGHT");
  requireRefused(test::viewer(headless + "--record /proc/nowhere"), 1,
                 "/proc/nowhere: cannot create the folder for pictures");
  const auto script = [&](const std::string& text, const std::string& message) {
    test::writeFile(folder / "bad.txt", text);
    requireRefused(test::viewer("--headless --script '" + folder / "bad.txt'"), 1, message);
  };
  script("0 jump\n0 end\n", "bad.txt:1: jump: is not a known command");
  script("# remark\n1 pause\n0.5 end\n", "bad.txt:3: time: is earlier than that of the previous step");
  script("0 hand 1 2\n1 end\n", "bad.txt:1: hand: is missing");
  script("0 hand 1 2 nan\n1 end\n", "bad.txt:1: hand: is \"nan\", must be a number");
  script("0 spin fast\n1 end\n", "bad.txt:1: spin: must be on or off");
  script("0 view 0 0 0 30 89 100\n1 end\n", "bad.txt:1: elevation: is 89, must be in -88 to 88");
  script("0 slow 0\n1 end\n", "bad.txt:1: slow: is 0, must be in 1 to 1000");
  script("0 set colour 1\n1 end\n", "bad.txt:1: set: \"colour\" is not a known setting");
  script("0 set delay 1.5\n1 end\n", "bad.txt:1: delay: must be a whole number");
  script("0 set delay 9\n1 end\n", "bad.txt:1: delay: is 9, must be in 0 to 8");
  script("0 picture ../x\n1 end\n", "bad.txt:1: picture: is \"../x\", must have only letters");
  script("0 size 10x10\n1 end\n", "bad.txt:1: size: is \"10x10\", must be WIDTHxHEIGHT");
  script("0 pause\n", "bad.txt:1: end: is missing");
  script("0 end\n1 pause\n", "bad.txt:2: comes after the end");
  script("0 pause now\n1 end\n", "bad.txt:1: now: is not expected here");
  script("0 renderer granite\n1 end\n",
         "bad.txt:1: renderer: is \"granite\", must be position-control, impedance, hold or passivity");
}

TEST_CASE("plugins and gains: what is asked of what is not there", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "good.txt", "0 end\n");
  const std::string headless = "--headless --script '" + folder / "good.txt" + "' ";
  requireRefused(test::viewer(headless + "--set stiffness=1"), 1,
                 "--set is for plugins only, but --renderer does not name a plugin");
  // A parameter does not consume the following argument.
  requireRefused(test::viewer(headless + "--renderer template --set stiffness=3000 /no/such/scene.toml"), 1,
                 "/no/such/scene.toml: cannot open the file");
  requireRefused(test::viewer(headless + "--renderer template --set stiffness"), 1, "must be KEY=VALUE");
  requireRefused(test::viewer(headless + "--gain /no/such/servo.json"), 1, "/no/such/servo.json: cannot open");
  test::writeFile(folder / "slow.json", "{\"model\": \"m\", \"period\": 0.002, \"K\": [[1, 2, 3]]}");
  requireRefused(test::viewer(headless + "--gain '" + folder / "slow.json'"), 1,
                 "slow.json: period: is 0.002 s, must be 0.001 s");
  test::writeFile(folder / "neither.json", "{\"model\": \"m\", \"period\": 0.001}");
  requireRefused(test::viewer(headless + "--gain '" + folder / "neither.json'"), 1, "neither.json: K: is missing");
  test::writeFile(folder / "surface.json", "{\"kind\": \"surface\"}");
  requireRefused(test::viewer(headless + "--gain '" + folder / "surface.json'"), 1,
                 "surface.json: kind: is \"surface\": position control");
  // A plugin is added to the linked renderers, or replaces the one with its name.
  test::writeFile(folder / "own.txt", "0 renderer position-control\n0 renderer hold\n0 renderer template\n0 end\n");
  CHECK(test::viewer("--headless --renderer template --script '" + folder / "own.txt'").status == 0);
  requireRefused(test::viewer("--headless --script '" + folder / "own.txt'"), 1,
                 "renderer: is \"template\", must be position-control, impedance, hold or passivity");
}

TEST_CASE("recordings that cannot be played, and what cannot be done with one", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "good.txt", "0 end\n");
  const std::string headless = "--headless --script '" + folder / "good.txt" + "' ";
  requireRefused(test::viewer(headless + "--play /no/such.rec"), 1, "/no/such.rec: cannot open the file");
  requireRefused(test::viewer(headless + "--play '" + folder / "good.txt'"), 1, "good.txt: ");
  test::writeFile(folder / "wedge.obj",
                  "v -20 -20 0\nv 20 -20 0\nv 0 20 0\nv 0 0 -20\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n");
  test::writeFile(folder / "mesh.toml",
                  "name = \"a\"\nstart = [0, 0, 0.008]\n[[obstacle]]\nname = \"m\"\nshape = \"mesh\"\n"
                  "file = \"wedge.obj\"\nunit = \"mm\"\n");
  const auto push = test::run("push --device '" ENAMEL_SOURCE_DIR
                              "/data/devices/tau-nominal.toml' --device-damping 4 --scenario 2 --scene '" +
                              folder / "mesh.toml' --renderer impedance --record '" + folder / "mesh.rec'");
  INFO(push.output);
  REQUIRE(push.status == 0);
  const std::string play = "--headless --play '" + folder / "mesh.rec' ";
  CHECK(test::viewer(play + "--script '" + folder / "good.txt'").status == 0);
  for (const char* option : {"--device x", "--renderer hold", "--gain x", "--set a=1", "scene.toml"})
    requireRefused(test::viewer(headless + "--play x " + option), 2, "--play");
  const auto script = [&](const std::string& line, const std::string& arguments, const std::string& message) {
    test::writeFile(folder / "bad.txt", line + "\n1 end\n");
    requireRefused(test::viewer(arguments + "--script '" + folder / "bad.txt'"), 1, "bad.txt:1: " + message);
  };
  for (const char* word : {"hand", "spin", "renderer", "set", "scene", "push", "swap", "undo"})
    script(std::string("0 ") + word, play, std::string(word) + ": is not available for a recording");
  for (const char* word : {"seek", "next-event", "step-back"})
    script(std::string("0 ") + word, "--headless ", std::string(word) + ": is for recordings only: give --play");
  script("0 seek -1", play, "seek: is -1, must be in 0 to 1e+09");
  std::filesystem::remove(folder / "wedge.obj");
  requireRefused(test::viewer(headless + "--play '" + folder / "mesh.rec'"), 1, "wedge.obj: cannot open the file");
}

TEST_CASE("a signal ends the viewer with its report written, another one only asks for a report", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "long.txt", "0 hand 0 0 -20 over 0.3\n7000 end\n");
  const std::string script = "--script '" + folder / "long.txt' ";
  const auto requireReports = [&](const std::string& arguments, const std::string& environment, int number) {
    test::RunningViewer viewer(folder, script + arguments, environment);
    const double first = viewer.report().at("seconds"), second = viewer.report().at("seconds");
    CHECK(second > first);
    viewer.signal(number);
    CHECK(viewer.wait() == 128 + number);
    CHECK(viewer.said().empty());
    CHECK(viewer.lastReport().at("seconds").get<double>() > second);
  };
  const std::string alone = "-u DISPLAY -u WAYLAND_DISPLAY ";
  requireReports("--headless", alone, SIGINT);
  requireReports("--headless", alone, SIGTERM);
  if (!test::haveXvfb()) {
    WARN("Xvfb is missing: windows are not tested");
    return;
  }
  const test::XServer server(folder);
  requireReports(test::kFewPictures, server.environment(), SIGTERM);
}

TEST_CASE("no display, no OpenGL, closed in contact", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "good.txt", "0 end\n");
  const std::string script = "--script '" + folder / "good.txt'";
  requireRefused(test::viewer(script), 1, "cannot open a window, no display");
  requireRefused(test::viewer("--headless " + script, "env __EGL_VENDOR_LIBRARY_DIRS=/nonexistent"), 1,
                 "no OpenGL without a display");
  if (!test::haveXvfb()) return test::skipTest("Xvfb is missing");
  requireRefused(test::viewer(script, test::underXvfb("-screen 0 1280x720x24 -extension GLX")), 1,
                 "cannot open a window");
  for (const char* renderer : {"position-control", "impedance"}) {
    test::writeFile(folder / "close.txt", "0 hand 0 0 -20 over 0.3\n2.5 quit\n60 end\n");
    const auto closed =
        test::viewer("--script '" + folder / "close.txt' --renderer " + renderer + test::kByPictures, test::kXvfb);
    CHECK(closed.status == 0);
    CHECK(closed.output.empty());
  }
  test::writeFile(folder / "close.txt", "0.5 quit\n60 end\n");
  CHECK(test::viewer("--script '" + folder / "close.txt'" + test::kByPictures, test::kXvfb).status == 0);
}

}  // namespace enamel::test_refusals
