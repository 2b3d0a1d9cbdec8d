// A person at the viewer: real keys, clicks, drags and dropped files in a window under Xvfb, through GLFW's callbacks.
// The viewer's report lists what was shown.
#include <algorithm>
#include <fstream>
#include <sstream>

#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "viewer/running_viewer.hpp"

namespace enamel::test_person {

namespace {

using nlohmann::json;

// A person at a viewer in its window. Each function returns after the viewer has processed and drawn its effect.
class Person {
 public:
  Person(const test::TemporaryFolder& folder, const std::string& arguments, const std::string& environment = "")
      : server_(folder),
        environment_(server_.environment()),
        viewer_(folder, test::kFewPictures + arguments,
                environment_ + "HOME='" + folder / "" + "' XDG_STATE_HOME='" + folder / "state' " + environment) {
    std::string found;
    REQUIRE(test::eventually([&] {
      found = test::runCommand(environment_ + "xdotool search --onlyvisible --name '^Enamel$' 2>/dev/null").output;
      return !found.empty() && found[0] >= '0' && found[0] <= '9';  // "Error: Can't open display" is another output
    }));
    environment_ += "window=" + found.substr(0, found.find('\n')) + " ";
    does("xdotool windowfocus --sync $window");
    viewer_.untilDrawn(2);
  }

  // Run a shell command; $window is the window.
  void does(const std::string& command) const {
    const auto result = test::runCommand("export " + environment_ + "; " + command);
    INFO(command << ": " << result.output);
    REQUIRE(result.status == 0);
  }
  void key(std::initializer_list<const char*> keys) {
    for (const char* key : keys) {
      does(std::string("xdotool key --window 0 ") + key);
      viewer_.untilDrawn(2);
    }
  }
  void type(const std::string& text) {
    does("xdotool type " + text);
    viewer_.untilDrawn(1);
  }
  void at(int x, int y) {
    does("xdotool mousemove --window $window " + std::to_string(x) + " " + std::to_string(y));
    viewer_.untilDrawn(1);
  }
  // Move to a control named in the report.
  void at(const json& place) { at(place[0].get<int>(), place[1].get<int>()); }
  void click() {
    does("xdotool click 1");
    viewer_.untilDrawn(2);
  }
  // Turn the wheel with Ctrl by notches into the wall; release() turns it back.
  void press(int notches) { turn(4, notches); }
  void release(int notches) { turn(5, notches); }
  // Drag with a button down, in steps.
  void drag(int x, int y, int button = 1, int steps = 8) {
    const std::string step = " mousemove_relative -- " + std::to_string(x) + " " + std::to_string(y);
    does("xdotool mousedown " + std::to_string(button));
    for (int i = 0; i < steps; ++i) {
      does("xdotool" + step);
      viewer_.untilDrawn(1);
    }
    does("xdotool mouseup " + std::to_string(button));
    viewer_.untilDrawn(1);
  }
  void drop(const std::string& file) {
    does("'" ENAMEL_DROP "' $window '" + file + "'");
    viewer_.untilDrawn(1);
  }

  test::RunningViewer& viewer() { return viewer_; }
  // End the viewer and return its last report.
  json quits() {
    does("xdotool key --window 0 ctrl+q");
    status_ = viewer_.wait();
    return viewer_.lastReport();
  }
  int status() const { return status_; }

 private:
  void turn(int button, int notches) {
    does("xdotool keydown ctrl click --repeat " + std::to_string(notches) + " --delay 20 " + std::to_string(button) +
         " keyup ctrl");
    viewer_.untilDrawn(1);
  }

  test::XServer server_;
  std::string environment_;
  test::RunningViewer viewer_;
  int status_ = -1;
};

bool isAmong(const json& list, const std::string& text) { return test::RunningViewer::isAmong(list, text); }

// Make a home in which the viewer has been started before: no tour.
void leaveMark(const test::TemporaryFolder& folder) {
  std::filesystem::create_directories(folder / "state/enamel");
  test::writeFile(folder / "state/enamel/viewer-was-started", "");
}

bool havePerson() { return test::haveXvfb() && test::runCommand("command -v xdotool").status == 0; }

}  // namespace

TEST_CASE("a person takes the tour, presses, swaps, types, slides, drops a scan and goes to the edge", "[viewer]") {
  if (!havePerson()) return test::skipTest("Xvfb or xdotool is missing");
  const test::TemporaryFolder folder;
  const std::string data = ENAMEL_SOURCE_DIR "/data/";
  test::writeFile(folder / "torn.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  test::writeFile(folder / "talk.txt", "no mesh\n");
  Person person(folder, "");
  test::RunningViewer& viewer = person.viewer();

  // Wait for the first start's tour, end it if it is running, then show one tool.
  viewer.until("the tour", [](const json& report) {
    return report.at("touring").get<bool>() || isAmong(report.at("shown").at("notices"), "You now control the hand");
  });
  person.key({"Escape"});
  viewer.untilShown("notices", "You now control the hand");
  person.key({"v"});

  person.at(560, 300);
  person.press(15);  // 6 N
  const json before = viewer.untilShown("renderers", "position-control").at("controls");
  person.key({"Tab"});
  const json controls = viewer.untilShown("renderers", "impedance").at("controls");

  // Type a valid and an invalid stiffness.
  const auto typeStiffness = [&](const char* value) {
    person.at(controls.at("stiffness"));
    person.click();
    viewer.until("typing", [](const json& report) { return report.at("typing") == "stiffness"; });
    person.type(value);
    person.key({"Return"});
  };
  typeStiffness("7500");
  viewer.untilShown("stiffnesses", "7.50 kN/m");
  typeStiffness("99999");
  viewer.untilShown("notices", "stiffness is 99999, must be in 200 to 20000 N/m");

  // With delay, it rings. The control remains under the mouse, although the settings of the renderer change.
  person.at(controls.at("3"));
  viewer.untilShown("tips", "Delay between a measurement and the torque that answers it");
  person.click();
  const json late =
      viewer.until("a delay", [](const json& report) { return report.at("shown").at("delay [ticks]") == 3; });
  CHECK(late.at("controls").at("3") == controls.at("3"));
  CHECK(before.at("3") == controls.at("3"));
  person.key({"Tab", "Tab"});
  person.at(560, 300);
  person.press(15);
  viewer.untilShown("badges", "unstable");
  // A stop by the guard is in the read-outs, not the force of before.
  const json stopped =
      viewer.until("a stop", [](const json& report) { return isAmong(report.at("readouts"), "stopped by the guard"); });
  CHECK(isAmong(stopped.at("readouts"), "0.0 N: stopped by the guard"));
  viewer.until("a press", [](const json& report) { return report.at("shown").at("deepest [m]") > 0.8e-3; });

  // Backspace also resets the settings.
  person.key({"BackSpace"});
  const json start = viewer.untilShown("notices", "have been reset").at("shown");
  CHECK(start.at("delay [ticks]") == 0);
  CHECK(start.at("stiffness [N/m]") == 6000.0);

  person.drop(data + "scenes/cusps.toml");
  viewer.untilShown("scenes", "cusps");
  person.key({"5"});
  person.at(560, 300);
  person.press(20);
  person.does("xdotool keydown shift");
  viewer.until("a slip", [&](const json& report) {
    if (isAmong(report.at("shown").at("badges"), "slipped")) return true;
    person.drag(12, 6);
    person.drag(-12, -6);
    return false;
  });
  person.does("xdotool keyup shift");
  person.release(40);

  person.drop(folder / "torn.ply");
  viewer.untilShown("notices", "torn.ply");  // with the reason
  person.drop(folder / "talk.txt");
  viewer.untilShown("notices", "talk.txt");
  person.drop(data + "meshes/molar.ply");
  viewer.untilShown("notices", "molar.ply: 11.0 x 10.0 x 9.4 mm, unit mm");
  viewer.untilShown("scenes", "molar");

  person.does("xdotool windowsize $window 640 480");
  viewer.until("a smaller window", [](const json& report) { return report.at("size") == json{640, 480}; });
  person.does("xdotool keydown d");
  viewer.untilShown("badges", "edge of workspace");
  person.does("xdotool keyup d");
  person.key({"h", "Escape"});
  viewer.untilShown("notices", "Ctrl+Q ends the viewer");  // Esc does not end it
  person.key({"ctrl+p"});
  viewer.untilSaid("./enamel-001.png\n");
  // It may be closed in contact.
  person.press(40);
  viewer.until("contact", [](const json& report) { return report.at("contact").get<bool>(); });
  const json report = person.quits();
  WARN("it took " << report.at("seconds") << " s, " << report.at("frames_per_second") << " pictures a second");
  CHECK(person.status() == 0);
  CHECK(viewer.said() == "./enamel-001.png\n");  // without errors
  CHECK(report.at("opengl_errors") == 0);
  CHECK(test::Pixels(folder / "enamel-001.png").size() == glm::ivec2(640, 480));
}

TEST_CASE("a person turns, shifts and zooms the view, drags the tool, presses with the slider, and closes what is open",
          "[viewer]") {
  if (!havePerson()) return test::skipTest("Xvfb or xdotool is missing");
  const test::TemporaryFolder folder;
  leaveMark(folder);
  Person person(folder, "--size 800x600");
  test::RunningViewer& viewer = person.viewer();
  const json first = viewer.report();
  const auto differs = [](const json& a, const json& b, const char* what) { return a.at(what) != b.at(what); };
  const auto untilMoved = [&](const char* what, const json& from, const char* name) {
    return viewer.until(what,
                        [&](const json& report) { return differs(report.at("camera"), from.at("camera"), name); });
  };
  // The background: left drag turns, middle drag shifts, the wheel zooms; the hand stays.
  person.at(330, 150);
  person.drag(24, 16, 1, 2);
  const json turned = untilMoved("a turned view", first, "azimuth");
  CHECK_FALSE(differs(turned.at("camera"), first.at("camera"), "distance"));
  person.at(330, 150);
  person.drag(16, 8, 2, 2);
  const json shifted = untilMoved("a shifted view", turned, "focus");
  CHECK_FALSE(differs(shifted.at("camera"), turned.at("camera"), "azimuth"));
  person.does("xdotool click --repeat 2 --delay 20 4");
  const json near = untilMoved("a nearer view", shifted, "distance");
  CHECK(near.at("camera").at("distance") < shifted.at("camera").at("distance"));
  CHECK(near.at("hand") == first.at("hand"));
  // The tool: a drag moves the hand, and the view stays.
  person.key({"1"});
  const json field = viewer.report();
  CHECK(field.at("camera") == first.at("camera"));
  person.at(field.at("tool"));
  person.drag(8, -8, 1, 2);
  const json moved = viewer.until("a moved hand", [&](const json& report) { return differs(report, first, "hand"); });
  CHECK(moved.at("camera") == first.at("camera"));
  person.key({"h"});
  // The slider presses; the read-outs are smooth until a pause.
  person.at(field.at("controls").at("press"));
  person.click();
  const json pressed = viewer.until("contact", [](const json& report) { return report.at("contact").get<bool>(); });
  CHECK(isAmong(pressed.at("readouts"), "smoothed over 0.1 s"));
  person.key({"space"});
  viewer.until("single ticks", [](const json& report) { return isAmong(report.at("readouts"), "in this tick"); });
  person.key({"space"});
  // Escape closes each, the last one first.
  const auto untilOpen = [&](const json& what) {
    viewer.until("open: " + what.dump(), [&](const json& report) { return report.at("open") == what; });
  };
  person.key({"F3"});
  untilOpen({"timing"});
  person.at(field.at("controls").at("scene"));
  person.click();
  untilOpen({"list", "timing"});
  person.key({"F1"});
  untilOpen({"help", "list", "timing"});
  for (const json& left : {json{"list", "timing"}, json{"timing"}, json::array()}) {
    person.key({"Escape"});
    untilOpen(left);
  }
  CHECK_FALSE(isAmong(viewer.report().at("shown").at("notices"), "Ctrl+Q"));
  person.at(field.at("controls").at("press"));
  viewer.untilShown("tips", "Force of the hand into the nearest wall, N");
  // A scan in three actions: drop, press, save. It can be turned.
  person.key({"x"});
  viewer.untilShown("notices", "Available only for a scan");
  person.drop(ENAMEL_SOURCE_DIR "/data/meshes/molar.ply");
  const json scan = viewer.untilShown("notices", "molar.ply: 11.0 x 10.0 x 9.4 mm, unit mm, guessed from the size.");
  CHECK_FALSE(differs(scan.at("camera"), field.at("camera"), "azimuth"));
  person.at(scan.at("controls").at("press"));
  person.click();
  viewer.until("contact", [](const json& report) { return report.at("contact").get<bool>(); });
  person.key({"x"});
  viewer.untilShown("notices", "molar.ply: 11.0 x 9.4 x 10.0 mm");
  person.key({"ctrl+s"});
  viewer.untilShown("notices", "./molar-001.toml: saved.");
  CHECK(std::filesystem::exists(folder / "molar-001.toml"));
  person.quits();
  CHECK(person.status() == 0);
  CHECK(viewer.said().empty());
}

TEST_CASE("a person presses with a plugin, records it, makes a clip and plays the recording", "[viewer]") {
  if (!havePerson()) return test::skipTest("Xvfb or xdotool is missing");
  const test::TemporaryFolder folder;
  leaveMark(folder);
  // Replaces ffmpeg: writes its arguments.
  std::filesystem::create_directories(folder / "bin");
  test::writeFile(folder / "bin/ffmpeg", "#!/bin/sh\nfor last; do :; done\necho \"$*\" > \"$last\"\n");
  std::filesystem::permissions(folder / "bin/ffmpeg", std::filesystem::perms::owner_all);
  json shown;
  {
    Person person(folder, "--renderer template --set stiffness=3000", "PATH='" + folder / "bin':$PATH ");
    test::RunningViewer& viewer = person.viewer();
    viewer.untilShown("renderers", "template");
    person.at(300, 560);
    viewer.untilShown("tips", "Depth of the tool's lowest point in the nearest wall");
    person.at(1000, 60);
    viewer.untilShown("tips", "Penetration of the last 3 s");
    person.at(560, 300);
    person.key({"F3", "ctrl+r", "ctrl+m"});
    person.press(15);
    viewer.until("a press", [](const json& report) { return report.at("shown").at("deepest [m]") > 0.7e-3; });  // 6 N
    person.key({"ctrl+p"});
    viewer.untilSaid("./enamel-001.png\n");
    const std::string ninth = folder / "clip-001/00008.png";
    viewer.until("a clip", [&](const json&) { return std::filesystem::exists(ninth); });
    person.release(30);
    person.key({"ctrl+r", "ctrl+m"});
    viewer.untilShown("notices", "./enamel-001.rec: ");
    viewer.untilShown("notices", "./clip-001.mp4");
    person.key({"p"});
    viewer.until("a test push", [](const json& report) { return report.at("test_pushes").size() == 1; });
    person.key({"h", "ctrl+r"});
    viewer.until("no contact", [](const json& report) { return !report.at("contact").get<bool>(); });
    const json report = person.quits();
    INFO(report.dump(1) << viewer.said());
    CHECK(person.status() == 0);
    shown = report.at("shown");
    CHECK(shown.at("deepest [m]") > 1.5e-3);  // the test push, on 3 kN/m
    REQUIRE(report.at("test_pushes").size() == 1);
    CHECK(report["test_pushes"][0].at("renderer") == "template");
    CHECK(report["test_pushes"][0].at("first impact") == "measured");
    CHECK(report.at("opengl_errors") == 0);
    // The second recording was running at the end: it is complete as well.
    CHECK(viewer.said().find("./enamel-002.rec: ") != std::string::npos);
  }
  // The clip lasts as long as the scene, whatever the frame rate.
  const std::string asked = test::readFile(folder / "clip-001.mp4");
  CHECK(asked.find("-framerate 25 -i ./clip-001/%05d.png") != std::string::npos);
  for (int i = 0; i < 9; ++i)
    CHECK(test::Pixels(folder / ("clip-001/0000" + std::to_string(i) + ".png")).size() == glm::ivec2(1280, 720));
  // Two histograms in the card at the left of the scene: dark on white, with at most half its width.
  const test::Pixels picture(folder / "enamel-001.png");
  int bars = 0;
  for (int x = 270; x < 560; ++x)
    for (int y = 100; y < 260; ++y) bars += picture.at(x, y) == glm::ivec3(0x3D, 0x49, 0x57);
  CHECK(bars > 100);

  // Play the press until it is seen, without the later test push.
  Person person(folder, "--play '" + folder / "enamel-001.rec'");
  person.viewer().until("the press", [&](const json& report) {
    if (report.at("paused").get<bool>()) person.key({"space"});  // start again from the beginning
    return report.at("shown").at("deepest [m]") > 0.7e-3;
  });
  person.key({"ctrl+Left", "Right", "Right", "F3"});
  // A dropped scene replaces the recording, and a dropped recording the scene.
  person.drop(ENAMEL_SOURCE_DIR "/data/scenes/box.toml");
  person.viewer().until("the scene", [](const json& report) { return report.at("shown").at("scenes") == json{"box"}; });
  person.drop(folder / "enamel-001.rec");
  person.viewer().until("the recording",
                        [](const json& report) { return report.at("shown").at("scenes") == json{"flat wall"}; });
  person.key({"ctrl+Right"});
  const json played = person.quits();
  CHECK(person.status() == 0);
  CHECK(person.viewer().said().empty());
  CHECK(played.at("opengl_errors") == 0);
  CHECK(played.at("shown").at("deepest [m]") < shown.at("deepest [m]"));
}

TEST_CASE("a person plays a recording, drags its bar and steps", "[viewer]") {
  if (!havePerson()) return test::skipTest("Xvfb or xdotool is missing");
  const test::TemporaryFolder folder;
  const auto push = test::runCommand("'" ENAMEL_TOOL "' push --device '" ENAMEL_SOURCE_DIR
                                     "/data/devices/tau-nominal.toml' --scenario 2 --renderer impedance "
                                     "--device-damping 4 --record '" +
                                     folder / "push.rec'");
  INFO(push.output);
  REQUIRE(push.status == 0);
  Person person(folder, "--play '" + folder / "push.rec'");
  person.key({"space", "space"});
  person.at(500, 685);
  person.drag(6, 0);
  person.key({"Right", "ctrl+Right", "v", "ctrl+p"});
  person.viewer().untilSaid("./enamel-001.png\n");
  const json report = person.quits();
  CHECK(person.status() == 0);
  CHECK(person.viewer().said() == "./enamel-001.png\n");
  CHECK(isAmong(report.at("shown").at("notices"), "A recording cannot be changed."));
  CHECK(report.at("shown").at("deepest [m]") > 0.0);
  CHECK(test::Pixels(folder / "enamel-001.png").size() == glm::ivec2(1280, 720));
}

namespace {

// Return random actions of a person, for `seconds`, as shell commands.
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
  if (!havePerson()) return test::skipTest("Xvfb or xdotool is missing");
  const double seconds = test::count(8, 1800);
  const std::uint64_t seed = 703;
  INFO("seed " << seed);
  test::Random random(seed);
  const test::TemporaryFolder folder;
  leaveMark(folder);
  Person person(folder, "", "LP_NUM_THREADS=0");  // one thread, as in soak.cpp
  test::RunningViewer& viewer = person.viewer();
  // Compare memory in one state: in the wall, where the transparent tool is drawn both times.
  const auto level = [&] {
    person.does("xdotool mouseup 1 mouseup 3 windowsize $window 1280 720");
    viewer.until("the first size", [](const json& report) { return report.at("size") == json{1280, 720}; });
    person.key({"Escape", "Escape", "BackSpace"});
    person.drop(ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml");
    person.at(560, 300);
    person.key({"Tab"});
    person.press(15);
    viewer.until("contact", [](const json& report) { return report.at("contact").get<bool>(); });
    viewer.untilDrawn(10);
    std::vector<double> heap;
    for (int i = 0; i < 15; ++i) heap.push_back(viewer.report().at("heap_in_use_kB").back().get<double>() / 1024.0);
    std::sort(heap.begin(), heap.end());
    return heap[heap.size() / 2];
  };
  double levels[2];
  for (double& one : levels) {
    test::writeFile(folder / "playing.sh", playing(random, 0.5 * seconds));
    person.does("sh '" + folder / "playing.sh'");
    one = level();
  }
  person.key({"BackSpace"});
  viewer.until("no contact", [](const json& report) { return !report.at("contact").get<bool>(); });
  const json report = person.quits();
  CHECK(person.status() == 0);
  CHECK(report.at("opengl_errors") == 0);
  CHECK(report.at("size") == json{1280, 720});
  WARN("heap in use " << levels[0] << " MB, then " << levels[1] << " MB after " << report.at("seconds").get<double>()
                      << " s and " << report.at("shown").at("scenes").size() << " scenes");
  CHECK(levels[1] < levels[0] + 14.0);  // as in soak.cpp
}

}  // namespace enamel::test_person
