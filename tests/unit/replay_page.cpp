// enamel replay --html: a tooth that is drilled during the recording, replayed, and played by a browser.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>

#include "enamel/collision/solid_file.hpp"
#include "enamel/core/file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "program/recorded.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/skip.hpp"

namespace enamel::test_replay_page {

namespace {

constexpr int kTicks = 1500, kFewTicks = 700;
constexpr int kEvery = 17;  // ticks between two pictures

const std::string kScene = R"(
name = "block"
start = [0.0, 0.0, 0.0006]
[[tool]]
from = [0.0, 0.0, 0.0]
radius = 0.0005
[bur]
wear = 0.1
[[obstacle]]
name = "block"
shape = "solid"
file = "block.obj"
unit = "mm"
cell = 0.0001
[[obstacle.layer]]
name = "force"
hardness = 0.6e9
)";  // same name as another row of the page

void writeBlock(const std::string& path) {
  std::ofstream file(path);
  for (int i = 0; i < 8; ++i)
    file << "v " << (i & 1 ? 3 : -3) << ' ' << (i & 2 ? 3 : -3) << ' ' << (i & 4 ? 0 : -3) << '\n';
  file
      << "f 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\nf 2 4 6\nf 4 8 6\n";
}

// Forces on the tool, N, removed volume, m^3, and what is left.
struct Run {
  std::vector<double> forces;
  double removed = 0.0;
  std::shared_ptr<const Solid> solid;
};

// A hand presses with 2 N; the bur spins from 0.2 s to 1.2 s.
Run record(const test::TemporaryFolder& folder, const std::string& path, int ticks = kTicks) {
  writeBlock(folder / "block.obj");
  RecordingHeader header;
  header.deviceFile = ENAMEL_SOURCE_DIR "/data/devices/tau-nominal.toml";
  header.deviceText = readFile(header.deviceFile);
  header.sceneFile = folder / "block.toml";
  header.sceneText = kScene;
  const auto device = app::recordedDevice(header);
  const SceneFile scene = app::recordedScene(header);
  header.start.position = scene.start;
  const std::map<std::string, std::string> parameters{{"mode", "surface"}};
  nameRenderer("position-control", "", parameters, scene.scene, header);
  const auto renderer = makeLinked("position-control", parameters, device, 1e-3);

  LoopSetup setup;
  setup.scene = scene.scene;
  setup.tool = scene.tool;
  setup.start = header.start;
  setup.encoders = {true, RateSource::difference};
  VirtualLoop loop(*device, *renderer, setup);
  Drill drill(scene.tool, scene.solids, *scene.bur);
  loop.attach(&drill);
  Recorder recorder(path, header, loop.hapticTick());
  Run run;
  TickRecord tick;
  for (int i = 0; i < ticks; ++i) {
    drill.spin(i >= 200 && i < 1200);
    const auto load = [&](double, const Pose& at, const Vec6& twist) {
      Vec6 wrench = guidingWrench(at, twist, header.start, Vec3::UnitZ());
      wrench[2] -= 2.0 + 3.0 * twist[2];
      return wrench;
    };
    REQUIRE(loop.tick(load, tick) == Status::ok);
    recorder.makeRoom();
    recorder.add(tick.tick, loop.measurement(), loop.hapticTick(), loop.command(), tick.status);
    const Kinematics& k = loop.frame().kinematics;
    run.forces.push_back(wrenchOf(k, loop.command().effort - k.gravity).head<3>().norm());
    for (const double volume : drill.removed()) run.removed += volume;
  }
  REQUIRE(recorder.close().ticks == static_cast<std::uint64_t>(ticks));
  run.solid = scene.solids[0];
  return run;
}

std::string attribute(const std::string& page, const std::string& name) {
  std::smatch found;
  return std::regex_search(page, found, std::regex("data-" + name + "=\"([^\"]*)\"")) ? found[1].str() : "";
}

}  // namespace

TEST_CASE("what a bur has cut while it was recorded is cut again, and a browser plays it", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string recording = folder / "drill.rec", page = folder / "drill.html";
  const Run run = record(folder, recording);
  REQUIRE(run.removed > 0.05e-9);

  const auto equal = test::run("replay '" + recording + "'");
  INFO(equal.output);
  REQUIRE(equal.status == 0);
  CHECK_THAT(equal.output, test::ContainsSubstring("1500 ticks compared, with the renderer's states"));

  const std::string solid = folder / "cut.solid";
  REQUIRE(test::run("replay '" + recording + "' --solid '" + solid + "'").status == 0);
  const Solid left = loadSolid(solid);
  REQUIRE(left.bricks() == run.solid->bricks());
  for (int brick = 0; brick < left.bricks(); ++brick) CHECK(left.samples(brick) == run.solid->samples(brick));
  const auto onto = test::run("replay '" + recording + "' --overwrite --solid '" + recording + "'");
  CHECK_THAT(onto.output, test::ContainsSubstring("--solid must be another file than the recording"));

  const auto made = test::run("replay '" + recording + "' --html '" + page + "'");
  INFO(made.output);
  if (made.output.find("was built without three.js") != std::string::npos)
    return test::skipTest("three.js is not installed");
  REQUIRE(made.status == 0);
  CHECK(std::filesystem::file_size(page) < 3000000);
  const std::string text = test::readFile(page);
  // The page requests nothing from anywhere.
  CHECK_FALSE(std::regex_search(text, std::regex("<link|<script[^>]+src|@import|<img|<iframe")));

  const auto over = test::run("replay '" + recording + "' --html '" + recording + "'");
  CHECK(over.status == 1);
  CHECK_THAT(over.output, test::ContainsSubstring("--html must be another file than the recording"));
  const auto nowhere = test::run("replay '" + recording + "' --html '" + (folder / "no/page.html") + "'");
  CHECK(nowhere.status == 1);
  CHECK_THAT(nowhere.output,
             test::ContainsSubstring("no/page.html: ") && test::ContainsSubstring("No such file or directory"));
  const auto alone = test::run("replay '" + recording + "' --beside '" + recording + "'");
  CHECK(alone.status == 1);
  CHECK_THAT(alone.output, test::ContainsSubstring("--beside needs --html"));
  const auto beside =
      test::run("replay '" + recording + "' --renderer impedance --html '" + (folder / "two.html") + "'");
  INFO(beside.output);
  CHECK_THAT(beside.output, test::ContainsSubstring("page: ") && test::ContainsSubstring(" ticks differ"));
  const std::string shorter = folder / "short.rec";
  record(folder, shorter, kFewTicks);
  REQUIRE(test::run("replay '" + recording + "' --beside '" + shorter + "' --html '" + (folder / "ends.html") + "'")
              .status == 0);

  if (std::system("command -v chromium > /dev/null 2>&1") != 0) return test::skipTest("chromium is not installed");
  const auto open = [&](const std::string& file, const std::string& at) {
    const auto result = test::runCommand(
        "timeout 600 chromium --headless --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader "
        "--user-data-dir='" +
        (folder / "profile") + "' --virtual-time-budget=3000 --dump-dom 'file://" + file + at + "' 2>/dev/null");
    REQUIRE(result.status == 0);
    CHECK(attribute(result.output, "error").empty());
    CHECK(attribute(result.output, "ready") == "yes");
    return result.output;
  };
  const std::string still = open(page, "#t=0.8");
  CHECK(attribute(still, "time") == "0.8000");
  const auto shown = static_cast<std::size_t>(800 / kEvery * kEvery);
  REQUIRE(run.forces[shown] > 0.1);
  // The page's numbers have single precision.
  CHECK(static_cast<float>(std::stod(attribute(still, "forces"))) == static_cast<float>(run.forces[shown]));
  char removed[32];
  std::snprintf(removed, sizeof(removed), "%.2f mm", 1e9 * run.removed);
  const std::string cut = open(page, "#t=1.49");
  CHECK_THAT(cut, test::ContainsSubstring(removed));
  CHECK_THAT(cut, !test::ContainsSubstring("<dd></dd>"));
  // It plays: Chromium without a window draws few pictures, sometimes only the first.
  double time = 0.0;
  for (int i = 0; i < 30 && !(time > 0.0); ++i) time = std::stod(attribute(open(page, ""), "time"));
  CHECK(time > 0.0);
  CHECK_THAT(attribute(open(folder / "two.html", "#t=0.8"), "forces"), test::ContainsSubstring(" "));
  // After the end of the shorter recording its side has no values.
  const std::string both = open(folder / "ends.html", "#t=0.6"), after = open(folder / "ends.html", "#t=0.8");
  CHECK_THAT(attribute(both, "forces"), !test::ContainsSubstring("NaN"));
  CHECK_THAT(attribute(after, "forces"), test::ContainsSubstring(" NaN"));
  CHECK_THAT(after, test::ContainsSubstring("ended at 0.70 s"));
}

}  // namespace enamel::test_replay_page
