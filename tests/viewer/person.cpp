// A person at the viewer: real keys, clicks, drags and files dropped on a window under Xvfb, through GLFW's callbacks.
// What was shown then stands in the viewer's report.
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "viewer/support.hpp"

namespace enamel::test_person {

namespace {

constexpr const char* kNothing = "status 0\n./enamel-001.png\n";  // went wrong

bool isAmong(const nlohmann::json& list, const std::string& text) {
  return std::any_of(list.begin(), list.end(), [&text](const nlohmann::json& one) {
    return one.get<std::string>().find(text) != std::string::npos;
  });
}

// Starts the viewer as `arguments` say and does what a shell script says, with $window known, then waits for its end.
nlohmann::json person(const test::TemporaryFolder& folder, const std::string& arguments, const std::string& does,
                      int seconds = 100, const std::string& before = "") {
  test::writeFile(
      folder / "person.sh",
      "key() { for k in \"$@\"; do xdotool key --window 0 \"$k\"; sleep 0.3; done; }\n"
      "at() { xdotool mousemove --window $window \"$1\" \"$2\"; sleep 0.15; }\n"
      "press() { xdotool click --repeat \"$1\" --delay 20 4; sleep 0.6; }\n"
      "release() { xdotool click --repeat \"$1\" --delay 20 5; sleep 0.6; }\n"
      "drag() { xdotool mousedown 1; for i in 1 2 3 4 5 6 7 8; do xdotool mousemove_relative -- \"$1\" "
      "\"$2\"; sleep 0.06; done; xdotool mouseup 1; sleep 0.3; }\n"
      "cd '" +
          folder / "" + "'\n" +
          "mark() { echo $(($(date +%s%N) / 1000000 - start)) >> marks.txt; }\nstart=$(($(date +%s%N) / 1000000))\n" +
          before + "timeout " + std::to_string(seconds) + " '" ENAMEL_VIEWER "'" + test::kFewPictures + "--report '" +
          folder / "report.json' " + arguments +
          " > said.txt 2>&1 &\nviewer=$!\n"
          "window=$(timeout 40 xdotool search --sync --onlyvisible --name '^Enamel$' | head -n 1)\n"
          "xdotool windowfocus $window\nsleep 1\n" +
          does + "wait $viewer\necho status $?\ncat said.txt\n");
  const auto result = test::runCommand("env HOME='" + folder / "" + "' XDG_STATE_HOME='" + folder / "state' " +
                                       test::kXvfb + " sh '" + folder / "person.sh'");
  INFO(result.output);
  REQUIRE(result.output.find("status 0\n") != std::string::npos);
  auto report = nlohmann::json::parse(test::readFile(folder / "report.json"));
  report["said"] = result.output;
  return report;
}

std::string placeOf(const nlohmann::json& controls, const std::string& name) {
  REQUIRE(controls.contains(name));
  return std::to_string(controls[name][0].get<int>()) + " " + std::to_string(controls[name][1].get<int>());
}

bool havePerson() { return test::haveXvfb() && test::runCommand("command -v xdotool").status == 0; }

}  // namespace

TEST_CASE("a person takes the tour, presses, swaps, types, slides, drops a scan and goes to the edge", "[viewer]") {
  if (!havePerson()) return test::skipTest("xvfb-run, xauth or xdotool is missing");
  const test::TemporaryFolder folder;
  const std::string data = ENAMEL_SOURCE_DIR "/data/";
  // Where the panel has what the person clicks, at the same size.
  test::writeFile(folder / "look.txt", "0 renderer impedance\n0.2 picture panel\n0.3 end\n");
  REQUIRE(test::viewer("--headless --script '" + folder / "look.txt' --record '" + folder / "look' --report '" +
                       folder / "look.json'")
              .status == 0);
  const auto controls = nlohmann::json::parse(test::readFile(folder / "look.json")).at("controls");
  test::writeFile(folder / "torn.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  test::writeFile(folder / "talk.txt", "no mesh\n");

  std::string drop = "'" ENAMEL_DROP "' $window ";
  const std::string does =
      "sleep 1\nkey Escape v\n"                     // the first start's tour, then one tool
      "at 560 300\npress 15\nkey Tab\nsleep 0.5\n"  // 6 N, then on the spring
      "at " +
      placeOf(controls, "stiffness") +
      "\nxdotool click 1\nsleep 0.4\n"  // a value that it takes
      "xdotool type 7500\nkey Return\n"
      "at " +
      placeOf(controls, "stiffness") +
      "\nxdotool click 1\nsleep 0.4\n"  // one that it does not
      "xdotool type 99999\nkey Return\n"
      "at " +
      placeOf(controls, "3") +
      "\nsleep 0.6\nxdotool click 1\nsleep 1.5\n"  // late: it rings
      "at 560 300\npress 15\nsleep 1.5\n"
      "key BackSpace\nsleep 0.5\n" +
      drop + "'" + data +
      "scenes/cusps.toml' || echo not dropped\nsleep 1\n"
      "key 5\nat 560 300\npress 20\nxdotool keydown shift\ndrag 12 6\ndrag -12 -6\nxdotool keyup shift\nrelease 40\n" +
      drop + "'" + folder / "torn.ply' || echo not dropped\nsleep 0.5\n" + drop + "'" +
      folder / "talk.txt' || echo not dropped\nsleep 0.5\n" + drop + "'" + data +
      "meshes/molar.ply' || echo not dropped\nsleep 1\n"
      "xdotool windowsize --sync $window 640 480\nsleep 0.5\n"
      "xdotool keydown d\nsleep 3\nxdotool keyup d\n"  // to the edge
      "key h Escape ctrl+p\nsleep 0.7\nkey ctrl+q\n";
  const auto begin = std::chrono::steady_clock::now();
  const auto report = person(folder, "", does);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  WARN("it took " << seconds << " s, " << report.at("frames_per_second").get<double>() << " pictures a second");
  CHECK(seconds < 60.0);
  CHECK(report.at("said") == kNothing);
  const auto& shown = report.at("shown");
  INFO(shown.dump(1));
  CHECK(isAmong(shown.at("notices"), "The hand is yours"));
  CHECK(isAmong(shown.at("renderers"), "position-control"));
  CHECK(isAmong(shown.at("renderers"), "impedance"));
  CHECK(shown.at("deepest [m]") > 0.8e-3);  // 6 N on 6 kN/m, at least
  CHECK(isAmong(shown.at("notices"), "stiffness: 99999 is outside of 200 to 20000 N/m"));
  CHECK(isAmong(shown.at("stiffnesses"), "7.50 kN/m"));
  CHECK(isAmong(shown.at("tips"), "Between a measurement and the torque that answers it"));
  CHECK(isAmong(shown.at("badges"), "unstable"));
  CHECK(isAmong(shown.at("notices"), "are as at the start"));
  CHECK(shown.at("delay [ticks]") == 0);  // Backspace: also the settings
  CHECK(shown.at("stiffness [N/m]") == 6000.0);
  CHECK(isAmong(shown.at("scenes"), "cusps"));
  CHECK(isAmong(shown.at("badges"), "slipped"));
  CHECK(isAmong(shown.at("notices"), "torn.ply"));  // with the reason
  CHECK(isAmong(shown.at("notices"), "talk.txt"));
  CHECK(isAmong(shown.at("notices"), "molar.ply: 11.0 x 10.0 x"));
  CHECK(isAmong(shown.at("scenes"), "molar"));
  CHECK(isAmong(shown.at("badges"), "edge of workspace"));
  CHECK(isAmong(shown.at("notices"), "Ctrl+Q ends the viewer"));  // which Esc did not
  CHECK(report.at("size") == nlohmann::json{640, 480});
  CHECK(report.at("opengl_errors") == 0);
  const test::Pixels picture(folder / "enamel-001.png");
  CHECK(picture.size() == glm::ivec2(640, 480));
}

TEST_CASE("a person presses with a plugin, records it, makes a clip and plays the recording", "[viewer]") {
  if (!havePerson()) return test::skipTest("xvfb-run, xauth or xdotool is missing");
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "state/enamel");
  test::writeFile(folder / "state/enamel/viewer-was-started", "");
  // Stands for ffmpeg: writes what it was asked for.
  std::filesystem::create_directories(folder / "bin");
  test::writeFile(folder / "bin/ffmpeg", "#!/bin/sh\nfor last; do :; done\necho \"$*\" > \"$last\"\n");
  std::filesystem::permissions(folder / "bin/ffmpeg", std::filesystem::perms::owner_all);
  const auto report = person(folder, "--renderer template --set stiffness=3000",
                             "at 300 560\nsleep 0.8\nat 1000 60\nsleep 0.8\nat 560 300\nkey F3 ctrl+r ctrl+m\npress "
                             "15\nsleep 0.7\nkey ctrl+p\nsleep 0.7\nrelease 30\n"
                             "key ctrl+r ctrl+m\nsleep 1\nkey p\nsleep 4.5\nkey h ctrl+r\nsleep 0.8\nkey ctrl+q\n",
                             100, "PATH='" + folder / "bin':$PATH ");
  const auto& shown = report.at("shown");
  INFO(shown.dump(1));
  INFO(report.at("said").get<std::string>());
  CHECK(isAmong(shown.at("renderers"), "template"));
  CHECK(shown.at("deepest [m]") > 1.5e-3);  // 6 N on 3 kN/m
  CHECK(isAmong(shown.at("tips"), "How deep the tool's lowest point is in the wall"));
  CHECK(isAmong(shown.at("tips"), "Penetration of the last 3 s"));
  CHECK(isAmong(shown.at("notices"), "./enamel-001.rec: "));
  CHECK(isAmong(shown.at("notices"), "./clip-001.mp4"));
  REQUIRE(report.at("test_pushes").size() == 1);
  CHECK(report["test_pushes"][0].at("renderer") == "template");
  CHECK(report["test_pushes"][0].at("first impact") == "measured");
  CHECK(report.at("opengl_errors") == 0);
  // The clip is as long as it took, whatever the pictures a second.
  const std::string asked = test::readFile(folder / "clip-001.mp4");
  CHECK(asked.find("-framerate 25 -i ./clip-001/%05d.png") != std::string::npos);
  int pictures = 0;
  while (std::filesystem::exists(folder / ("clip-001/0000" + std::to_string(pictures) + ".png")) && pictures < 9)
    CHECK(test::Pixels(folder / ("clip-001/0000" + std::to_string(pictures++) + ".png")).size() ==
          glm::ivec2(1280, 720));
  CHECK(pictures == 9);
  // Two histograms in the card at the left of the scene: dark on white, over half its width at most.
  const test::Pixels picture(folder / "enamel-001.png");
  int bars = 0;
  for (int x = 270; x < 560; ++x)
    for (int y = 100; y < 260; ++y) bars += picture.at(x, y) == glm::ivec3(0x3D, 0x49, 0x57);
  CHECK(bars > 100);
  // The second recording was under way at the end: it is whole as well.
  CHECK(report.at("said").get<std::string>().find("./enamel-002.rec: ") != std::string::npos);

  const auto played = person(folder, "--play '" + folder / "enamel-001.rec'",
                             "key space\nsleep 6\nkey ctrl+Left Right Right F3\nsleep 0.5\nkey ctrl+q\n");
  CHECK(played.at("said") == "status 0\n");
  CHECK(played.at("opengl_errors") == 0);
  // The press, without the test push that came after it.
  CHECK(played.at("shown").at("deepest [m]") > 0.7e-3);
  CHECK(played.at("shown").at("deepest [m]") < shown.at("deepest [m]"));
}

TEST_CASE("a person plays a recording, drags its bar and steps", "[viewer]") {
  if (!havePerson()) return test::skipTest("xvfb-run, xauth or xdotool is missing");
  const test::TemporaryFolder folder;
  const auto push = test::runCommand("'" ENAMEL_TOOL "' push --device '" ENAMEL_SOURCE_DIR
                                     "/data/devices/tau-nominal.toml' --scenario 2 --renderer impedance "
                                     "--device-damping 4 --record '" +
                                     folder / "push.rec'");
  INFO(push.output);
  REQUIRE(push.status == 0);
  const auto report = person(folder, "--play '" + folder / "push.rec'",
                             "key space\nsleep 0.5\nkey space\n"
                             "at 500 685\ndrag 6 0\nkey Right ctrl+Right v ctrl+p\nsleep 0.7\nkey ctrl+q\n");
  CHECK(report.at("said") == kNothing);
  CHECK(isAmong(report.at("shown").at("notices"), "This is a recording: nothing in it can be changed."));
  CHECK(report.at("shown").at("deepest [m]") > 0.0);
  CHECK(test::Pixels(folder / "enamel-001.png").size() == glm::ivec2(1280, 720));
}

namespace {

// What somebody does who only plays about, for so many seconds, as shell commands.
std::string playing(test::Random& random, double seconds) {
  const auto pick = [&random](int count) { return static_cast<int>(random.uniform(0.0, count)); };
  const char* const keys[] = {"Tab",   "v",           "p",      "g",      "h",      "n",         "space",
                              "Right", "plus",        "minus",  "1",      "2",      "3",         "4",
                              "5",     "bracketleft", "ctrl+z", "Escape", "Return", "BackSpace", "f"};
  constexpr int keyCount = 21;
  std::ostringstream does;
  for (double time = 0.0; time < seconds; time += 0.15) {
    const int what = pick(10);
    const auto inScene = [&] {
      does << "xdotool mousemove --window $window " << 260 + pick(200) << ' ' << 80 + pick(280);
    };
    const auto drag = [&](int button) {
      does << " mousedown " << button << " mousemove_relative -- " << pick(80) - 40 << ' ' << pick(80) - 40
           << " mouseup " << button;
    };
    if (what < 3) inScene();
    if (what == 1) drag(1);
    if (what == 2) drag(3);
    if (what == 3) does << "xdotool click --repeat " << 1 + pick(8) << " --delay 5 " << 4 + pick(2);
    if (what == 4 || what == 5) does << "xdotool key --window 0 " << keys[pick(keyCount)];
    if (what == 6)
      does << "xdotool mousemove --window $window " << 20 + pick(200) << ' ' << 20 + pick(600) << " click 1";
    if (what == 7) does << "xdotool type --delay 5 " << pick(100000);
    if (what == 8) does << "xdotool windowsize $window " << 500 + pick(780) << ' ' << 380 + pick(340);
    if (what == 9) {
      does << "'" ENAMEL_DROP "' $window '" ENAMEL_SOURCE_DIR "/data/"
           << (pick(2) == 0 ? "meshes/molar.ply" : "scenes/corner.toml") << "' || true";
      time += 0.4;
    }
    does << "\nsleep 0.1\n";
  }
  return does.str();
}

}  // namespace

TEST_CASE("whatever somebody plays with, memory stays level", "[viewer]") {
  if (!havePerson()) return test::skipTest("xvfb-run, xauth or xdotool is missing");
  const double seconds = test::count(8, 1800), measured = 5.0;
  const std::uint64_t seed = 703;
  INFO("seed " << seed);
  test::Random random(seed);
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "state/enamel");
  test::writeFile(folder / "state/enamel/viewer-was-started", "");
  // In the wall, so that the tool that shines through is drawn both times; in one thread, as in soak.cpp.
  const std::string calm =
      "xdotool mouseup 1 mouseup 3 windowsize $window 1280 720\nsleep 0.5\nkey Escape Escape BackSpace\n'" ENAMEL_DROP
      "' $window '" ENAMEL_SOURCE_DIR
      "/data/scenes/flat-wall.toml' || true\nsleep 0.7\nat 560 300\nkey Tab\npress 15\nmark\nsleep 5\n";
  const std::string first = playing(random, 0.5 * seconds), second = playing(random, 0.5 * seconds);
  const auto report = person(folder, "", first + calm + second + calm + "key BackSpace\nsleep 0.5\nkey ctrl+q\n",
                             static_cast<int>(5.0 * seconds) + 90, "LP_NUM_THREADS=0 ");
  CHECK(report.at("opengl_errors") == 0);
  CHECK(report.at("size") == nlohmann::json{1280, 720});
  std::ifstream marks(folder / "marks.txt");
  std::vector<double> levels;
  for (double milliseconds = 0.0; marks >> milliseconds;) {
    std::vector<double> heap;
    for (std::size_t i = 0; i < report.at("memory_at_s").size(); ++i) {
      const double at = report["memory_at_s"][i].get<double>() - 1e-3 * milliseconds;
      if (at > 0.5 && at < measured) heap.push_back(report["heap_in_use_kB"][i].get<double>() / 1024.0);
    }
    REQUIRE(heap.size() >= 2);
    std::sort(heap.begin(), heap.end());
    levels.push_back(heap[heap.size() / 2]);
  }
  REQUIRE(levels.size() == 2);
  WARN("heap in use " << levels[0] << " MB, then " << levels[1] << " MB after " << report.at("seconds").get<double>()
                      << " s and " << report.at("shown").at("scenes").size() << " scenes");
  CHECK(levels[1] < levels[0] + 14.0);  // as in soak.cpp
}

}  // namespace enamel::test_person
