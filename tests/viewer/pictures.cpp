// Pictures of the viewer, in software GL without an X server, and in a window under Xvfb.
#include "camera.hpp"
#include "colours/palette.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/study/metrics.hpp"
#include "layout.hpp"
#include "support/devices.hpp"
#include "viewer/running_viewer.hpp"

namespace enamel::viewer::test_pictures {

using test::hasHue;
using test::Patch;
using test::patchOf;
using test::Pixels;

namespace {

const char* const kScript =
    "0.0 camera-device\n"
    "0.0 picture before\n"
    "0.1 hand 0 18 8 over 0.3\n"
    "1.5 picture moved\n"
    "1.6 hand 0 0 -20 over 0.5\n"
    "3.2 picture contact\n"
    "3.2 swap\n"  // after the picture, also in a window whose haptic loop continues meanwhile
    "4.2 picture swapped\n"
    "4.3 home\n"
    "5.6 picture after\n"
    "5.7 end\n";

// Return where a point of the platform is in the view of the whole device, pixels.
glm::dvec2 seen(const Pose& pose, const Vec3& inPlatform, const Layout& layout) {
  const Vec3 p = 1e3 * (pose.position + pose.rotation * inPlatform);
  const glm::dvec3 at =
      project(cameraPresets()[0].camera, {layout.scene.width, layout.scene.height}, {p.x(), p.y(), p.z()});
  return {layout.scene.x + at.x, layout.scene.y + at.y};
}

int distinctColours(const Pixels& pixels, const Rect& area) {
  std::vector<bool> seen(1 << 15, false);
  int count = 0;
  for (int y = static_cast<int>(area.y); y < static_cast<int>(area.y + area.height); ++y)
    for (int x = static_cast<int>(area.x); x < static_cast<int>(area.x + area.width); ++x) {
      const glm::ivec3 p = pixels.at(x, y) / 8;
      const std::size_t index = static_cast<std::size_t>(p.r << 10 | p.g << 5 | p.b);
      count += !seen[index];
      seen[index] = true;
    }
  return count;
}

// Count pixels of the force arrow near the tool, away from the text above.
int arrowPixels(const Pixels& pixels, const Layout& layout) {
  const glm::dvec2 tool = seen(Pose{}, Vec3(0.0, 0.0, 0.02), layout);
  const int reach = static_cast<int>(80.0f * layout.scale);
  return patchOf(pixels, kVermilion, glm::ivec2(tool) - reach, glm::ivec2(tool) + reach).count;
}

void checkPictures(const std::string& folder, const Layout& layout, bool exactPoses) {
  const Pixels before(folder + "/before.png"), moved(folder + "/moved.png"), contact(folder + "/contact.png"),
      swapped(folder + "/swapped.png"), after(folder + "/after.png");
  REQUIRE(before.size() == layout.size);

  // Not blank: a lit scene has hundreds of tones, an empty one has one.
  for (const Pixels* picture : {&before, &contact}) {
    CHECK(distinctColours(*picture, layout.scene) > 100);
    CHECK(distinctColours(*picture, layout.charts) > 20);
    CHECK(distinctColours(*picture, layout.panel) > 20);
  }

  // The tool is where the kinematics says: the handle's middle has the handle's colour there, and no longer after the
  // tool has moved away.
  Pose start, aside;
  start.position = {0.0, 0.0, 0.008};
  aside.position = {0.0, 0.018, 0.008};
  const Vec3 middle(0.0, 0.0, 0.060);
  const auto handleAt = [&](const Pixels& picture, const Pose& pose) {
    const glm::ivec2 at(seen(pose, middle, layout));
    const int reach = static_cast<int>(3 * layout.scale);
    const auto patch = patchOf(picture, kHandle, at - reach, at + reach + 1, 0.08);
    return static_cast<double>(patch.count) / ((2 * reach + 1) * (2 * reach + 1));
  };
  CHECK(handleAt(before, start) > 0.6);
  CHECK(handleAt(after, start) > 0.6);
  CHECK(handleAt(before, aside) < 0.2);
  if (exactPoses) {
    CHECK(handleAt(moved, aside) > 0.6);
    CHECK(handleAt(moved, start) < 0.2);
  }

  // The arrow appears on contact with either renderer, and disappears.
  CHECK(arrowPixels(before, layout) == 0);
  CHECK(arrowPixels(contact, layout) > 100);
  CHECK(arrowPixels(swapped, layout) > 100);
  CHECK(arrowPixels(after, layout) == 0);

  // The charts move: the force's line is at the bottom, then higher.
  const auto forceLine = [&](const Pixels& picture) {
    const Rect& a = layout.chart[1];
    const float s = layout.scale;
    return patchOf(picture, kVermilion, glm::ivec2(glm::vec2(a.x + 40 * s, a.y + kChartTitle * s)),
                   glm::ivec2(glm::vec2(a.x + a.width, a.y + a.height)));
  };
  REQUIRE(forceLine(before).count > 100);
  REQUIRE(forceLine(contact).count > 100);
  CHECK(forceLine(contact).centre.y < forceLine(before).centre.y - 8 * layout.scale);
}

}  // namespace

TEST_CASE("headless pictures show the scene, at both scales, and the same bytes every time", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", kScript);
  for (const int scale : {1, 2}) {
    const glm::ivec2 size = glm::ivec2(1280, 720) * scale;
    const std::string out = folder / ("scale" + std::to_string(scale));
    const std::string arguments = "--headless --script '" + folder / "script.txt" + "' --size " +
                                  std::to_string(size.x) + "x" + std::to_string(size.y) + " --scale " +
                                  std::to_string(scale);
    const auto result = test::viewer(arguments + " --record '" + out + "' --report '" + out + ".json'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    checkPictures(out, layOut(size, static_cast<float>(scale), true, true), true);
    CHECK(nlohmann::json::parse(test::readFile(out + ".json")).at("opengl_errors") == 0);
    if (scale == 2) continue;
    REQUIRE(test::viewer(arguments + " --record '" + out + "-again'").status == 0);
    for (const char* name : {"before", "moved", "contact", "swapped", "after"}) {
      const std::string first = test::readFile(out + "/" + name + ".png");
      REQUIRE(first.size() > 10000);
      CHECK(first == test::readFile(out + "-again/" + name + ".png"));
    }
  }
}

TEST_CASE("a window under Xvfb shows the same", "[viewer]") {
  if (!test::haveXvfb()) return test::skipTest("Xvfb is missing");
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", kScript);
  const std::string out = folder / "window";
  const auto result = test::viewer(
      "--script '" + folder / "script.txt" + "' --record '" + out + "' --report '" + out + ".json'" + test::kByPictures,
      test::kXvfb);
  INFO(result.output);
  REQUIRE(result.status == 0);
  // In real time a loaded machine may be late: do not check the tool in motion.
  checkPictures(out, layOut({1280, 720}, 1.0f, true, true), false);
  // At rest, the picture of the window is that of the headless viewer, apart from the time in the header.
  test::writeFile(folder / "still.txt", "0 pause\n0.5 picture still\n0.5 end\n");
  const std::string still = "--script '" + folder / "still.txt' --record '" + folder / "";
  REQUIRE(test::viewer(still + "a'" + test::kByPictures, test::kXvfb).status == 0);
  REQUIRE(test::viewer("--headless " + still + "b'").status == 0);
  const Pixels a(folder / "a/still.png"), b(folder / "b/still.png");
  int differing = 0;
  for (int y = 72; y < 720; ++y)
    for (int x = 0; x < 1280; ++x) differing += glm::distance(glm::dvec3(a.at(x, y)), glm::dvec3(b.at(x, y))) > 24.0;
  CHECK(differing < 0.001 * 1280 * 648);
  const auto report = nlohmann::json::parse(test::readFile(out + ".json"));
  CHECK(report.at("opengl_errors") == 0);
  CHECK(report.at("frames") == 70);  // the last one at 5.75 s
  WARN("first frame after " << report.at("first_frame_s").get<double>() << " s, "
                            << report.at("frames_per_second").get<double>() << " frames/s, haptics "
                            << report.at("haptics").dump());
}

TEST_CASE("every scene in contact: the walls are there, and the force", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", "0 camera-device\n0 hand -9 -4 -18 over 0.5\n1.5 picture contact\n1.6 end\n");
  const Layout layout = layOut({1280, 720}, 1.0f, true, true);
  const std::pair<std::string, const char*> cases[] = {
      {"flat-wall", "position-control"}, {"flat-wall", "impedance"},     {"flat-wall", "hold"},
      {"oblique-wall", "hold"},          {"corner", "position-control"}, {"box", "impedance"}};
  for (const auto& [name, renderer] : cases) {
    INFO(name << " " << renderer);
    const auto result =
        test::viewer(test::shippedScene(name + ".toml") + " --renderer " + renderer + " --headless --script '" +
                     folder / "script.txt" + "' --overwrite --record '" + folder / name + "'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    const Pixels picture(folder / name + "/contact.png");
    const glm::dvec2 tool = seen(Pose{}, Vec3(-0.005, 0.0, 0.0), layout);
    CHECK(patchOf(picture, kVermilion, glm::ivec2(tool) - 120, glm::ivec2(tool) + 120).count > 100);
    CHECK(patchOf(picture, kEnamel, glm::ivec2(tool) - 120, glm::ivec2(tool) + 120, 0.03).count > 1000);
  }
}

TEST_CASE("every device that is shipped is drawn, and touches", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt",
                  "0 camera-device\n0.1 picture before\n0.2 hand 0 0 -20 over 0.5\n2.0 picture contact\n2.1 end\n");
  const Layout layout = layOut({1280, 720}, 1.0f, true, true);
  int devices = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ENAMEL_SOURCE_DIR "/data/devices")) {
    if (entry.path().extension() != ".toml") continue;
    ++devices;
    INFO(entry.path());
    const std::string out = folder / entry.path().stem().string();
    // The spring pushes at every tick; the servo's force varies with the counts of coarse encoders.
    const auto result =
        test::viewer("--device '" + entry.path().string() + "' --renderer impedance --headless --script '" +
                     folder / "script.txt" + "' --record '" + out + "'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    const Pixels before(out + "/before.png"), contact(out + "/contact.png");
    Pose start;
    start.position = {0.0, 0.0, 0.008};
    const glm::ivec2 handle(seen(start, Vec3(0.0, 0.0, 0.060), layout));
    CHECK(patchOf(before, kHandle, handle - 3, handle + 4, 0.08).count > 30);  // of 49
    CHECK(arrowPixels(before, layout) == 0);
    CHECK(arrowPixels(contact, layout) > 100);
  }
  CHECK(devices >= 2);
}

namespace {

// Run a script of test pushes and return the report's entry.
nlohmann::json testPushes(const test::TemporaryFolder& folder, const std::string& script,
                          const std::string& arguments) {
  test::writeFile(folder / "push.txt", script);
  const auto result = test::viewer("--headless --script '" + folder / "push.txt" + "' --record '" + folder / "push" +
                                   "' --overwrite --report '" + folder / "push.json' " + arguments);
  INFO(result.output);
  REQUIRE(result.status == 0);
  return nlohmann::json::parse(test::readFile(folder / "push.json")).at("test_pushes");
}

}  // namespace

TEST_CASE("test pushes are reported by their renderers' names, with the study's names and the reason", "[viewer]") {
  const test::TemporaryFolder folder;
  std::string depth, stiffness;
  for (const Metric& metric : allMetrics()) {
    if (metric.symbol == std::string("D_z1")) depth = keyOf(metric);
    if (metric.symbol == std::string("K_z1")) stiffness = keyOf(metric);
  }
  const auto both = testPushes(
      folder, "0 picture title\n0.1 push\n4.2 renderer impedance\n4.3 push\n8.4 picture gauge\n8.4 end\n", "");
  const Pixels linkedTitle(folder / "push/title.png");
  REQUIRE(both.size() == 2);
  CHECK(both[0].at("renderer") == "position-control");
  CHECK(both[1].at("renderer") == "impedance");
  for (const auto& push : both) {
    CHECK(push.at("first impact") == "measured");
    // The step above the preload.
    CHECK(push.at(stiffness).get<double>() * push.at(depth).get<double>() == Approx(11.5).epsilon(1e-9));
  }
  CHECK(both[0].at(stiffness) > 150e3);
  CHECK(both[1].at(stiffness) < 6e3);

  // The gauge's dots are at their positions between 1 kN/m and 1 MN/m.
  const Layout layout = layOut({1280, 720}, 1.0f, true, true);
  const Rect& gauge = layout.gauge;
  const Pixels picture(folder / "push/gauge.png");
  const auto dotAt = [&](double value, unsigned colour) {
    const float left = gauge.x + 14, right = gauge.x + gauge.width - 14;
    const glm::ivec2 at(left + static_cast<float>(std::log10(value / 1e3) / 3.0) * (right - left),
                        gauge.y + 66 + 4 * kGaugeRow);
    return patchOf(picture, colour, at - 4, at + 5).count;  // of 81
  };
  CHECK(dotAt(both[0].at(stiffness), kBlue) > 60);
  CHECK(dotAt(both[1].at(stiffness), kPurple) > 60);
  CHECK(dotAt(0.5 * both[0].at(stiffness).get<double>(), kBlue) < 20);

  const auto late = testPushes(folder, "0 renderer impedance\n0 set delay 3\n0.1 push\n5.0 end\n", "");
  REQUIRE(late.size() == 1);
  CHECK(late[0].at("first impact") == "unstable");
  CHECK(late[0].at("shown") == "unstable: stopped by the guard");
  CHECK(late[0].at(stiffness).is_null());

  const auto plugin =
      testPushes(folder, "0 picture title\n0.1 push\n4.2 end\n", "--renderer template --set stiffness=3000");
  const Pixels pluginTitle(folder / "push/title.png");
  REQUIRE(plugin.size() == 1);
  CHECK(plugin[0].at("renderer") == "template");  // in addition to the linked ones
  CHECK(plugin[0].at("first impact") == "measured");
  CHECK(plugin[0].at(stiffness) < 4e3);
  // Nothing else in the header differs.
  int differing = 0;
  for (int y = 46; y < 66; ++y)
    for (int x = static_cast<int>(layout.scene.x) + 30; x < static_cast<int>(layout.scene.x) + 130; ++x)
      differing += pluginTitle.at(x, y) != linkedTitle.at(x, y);
  CHECK(differing > 100);
}

TEST_CASE(
    "settings of a script act: a delay of three ticks and the guard stops the spring, a soft one lets the tool in",
    "[viewer]") {
  const test::TemporaryFolder folder;
  const Layout layout = layOut({1280, 720}, 1.0f, true, true);
  const auto leanOn = [&](const std::string& name, const std::string& set) {
    test::writeFile(folder / (name + ".txt"), "0 camera-device\n0 renderer impedance\n0 " + set +
                                                  "\n0 hand 0 0 -20 over 0.5\n2.5 picture " + name + "\n2.6 end\n");
    const auto result =
        test::viewer("--headless --script '" + folder / (name + ".txt") + "' --record '" + folder / "out'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    return Pixels(folder / "out/" + name + ".png");
  };
  const Pixels plain = leanOn("plain", "set stiffness 6000"), soft = leanOn("soft", "set stiffness 1000"),
               late = leanOn("late", "set delay 3");
  // Pixels of the force's line and its height: 7.5 N on the stiff spring, 5.7 N on the soft one, with the same scale.
  const auto force = [&](const Pixels& picture) {
    const Rect& a = layout.chart[1];
    return patchOf(picture, kVermilion, glm::ivec2(glm::vec2(a.x + a.width / 2, a.y + kChartTitle)),
                   glm::ivec2(glm::vec2(a.x + a.width, a.y + a.height)));
  };
  CHECK(force(soft).count < 2 * force(plain).count);
  // The soft wall yields: 20 mm of the hand at 400 N/m give 5.7 mm against 1000 N/m, and 1.3 mm against 6000 N/m.
  const auto contact = [&](const Pixels& picture) {
    const glm::dvec2 at = seen(Pose{}, Vec3::Zero(), layout);
    return patchOf(picture, kVermilion, glm::ivec2(at) - 100, glm::ivec2(at) + 100).centre;
  };
  Pose in;
  in.position = {0.0, 0.0, -0.0044};
  const glm::dvec2 expected = seen(in, Vec3::Zero(), layout) - seen(Pose{}, Vec3::Zero(), layout);
  const glm::dvec2 moved = contact(soft) - contact(plain);
  CHECK(glm::dot(moved, expected) > 0.3 * glm::dot(expected, expected));
  CHECK(glm::dot(contact(late) - contact(plain), expected) > 2.0 * glm::dot(expected, expected));  // the full 20 mm
}

TEST_CASE("a recording is drawn as the run was, at any time, and played", "[viewer]") {
  const test::TemporaryFolder folder;
  const auto push =
      test::run("push --device '" + test::deviceFile("tau-nominal.toml") +
                "' --scenario 2 --renderer impedance --device-damping 4 --record '" + folder / "push.rec'");
  INFO(push.output);
  REQUIRE(push.status == 0);
  test::writeFile(
      folder / "script.txt",
      "0 camera-device\n0 seek 0.9\n0 picture before\n0.1 seek 2\n0.1 picture contact\n0.2 step-back\n0.3 step\n"
      "0.3 picture again\n0.4 seek 2.5\n0.4 previous-event\n0.4 picture event\n"
      "0.5 seek 0.5\n0.5 slow 2\n0.5 pause\n1.5 pause\n1.5 picture played\n1.6 end\n");
  const auto result = test::viewer("--headless --play '" + folder / "push.rec' --script '" + folder / "script.txt" +
                                   "' --record '" + folder / "out' --report '" + folder / "report.json'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK(nlohmann::json::parse(test::readFile(folder / "report.json")).at("opengl_errors") == 0);
  const Layout layout = layOut({1280, 720}, 1.0f, true, true, 0);
  const auto picture = [&](const std::string& name) { return Pixels(folder / "out/" + name + ".png"); };
  const Pixels before = picture("before"), contact = picture("contact");
  CHECK(arrowPixels(before, layout) == 0);
  CHECK(arrowPixels(contact, layout) > 100);
  CHECK(test::readFile(folder / "out/contact.png") == test::readFile(folder / "out/again.png"));
  // The time bar has contacts in its right part. Its position is at 0.9 s and 2 s, and at 1 s after one second at half
  // speed, of 2.999 s in all.
  const auto onBar = [&](const Pixels& pixels, unsigned colour, double from, double to) {
    const Rect& bar = layout.bar;
    return patchOf(pixels, colour, glm::ivec2(bar.x + from * bar.width, bar.y),
                   glm::ivec2(bar.x + to * bar.width, bar.y + 23));
  };
  CHECK(onBar(before, kVermilion, 0.4, 0.99).count > 1000);
  CHECK(onBar(before, kVermilion, 0.06, 0.16).count == 0);
  const auto placeOn = [&](const Pixels& pixels) {
    return (onBar(pixels, kBlue, 0.0, 1.0).centre.x - layout.bar.x) / layout.bar.width * 2.999;
  };
  CHECK(placeOn(before) == Approx(0.9).margin(0.01));
  CHECK(placeOn(contact) == Approx(2.0).margin(0.01));
  CHECK(placeOn(picture("played")) == Approx(1.0).margin(0.02));
  // An event: the wall's force begins there, in the middle of the charts.
  const Rect& force = layout.chart[1];
  const Pixels event = picture("event");
  const auto line = [&](float from, float to) {
    return patchOf(event, kVermilion, glm::ivec2(glm::vec2(force.x + from * force.width, force.y + kChartTitle)),
                   glm::ivec2(glm::vec2(force.x + to * force.width, force.y + force.height)))
        .centre.y;
  };
  CHECK(line(0.6f, 0.9f) < line(0.2f, 0.45f) - 20);
}

TEST_CASE("camera: unproject inverts project", "[viewer]") {
  test::Random random(603);
  for (int i = 0; i < 1000; ++i) {
    Camera camera = cameraPresets()[static_cast<std::size_t>(i % 3)].camera;
    const glm::dvec2 turn{random.uniform(-3.0, 3.0), random.uniform(-1.0, 1.0)};
    orbit(camera, turn.x, turn.y);
    const glm::dvec2 shift{random.uniform(-20.0, 20.0), random.uniform(-20.0, 20.0)};
    pan(camera, shift.x, shift.y);
    zoom(camera, random.uniform(0.7, 1.3));
    const glm::dvec2 size{random.uniform(200.0, 2000.0), random.uniform(200.0, 2000.0)};
    const Vec3 v = random.vector(30.0);
    const glm::dvec3 point(v.x(), v.y(), v.z()), seenAt = project(camera, size, point);
    // A depth range from 10 mm to 4 m keeps 1e-16 * 4000 / 10 of a point's distance.
    CHECK(glm::distance(unproject(camera, size, glm::dvec2(seenAt), point), point) < 1e-9);
  }
}

namespace {

// Return the depth of the mark that shows how deep a tool sank, by the inset's ruler, in its steps; negative: no mark.
double markOf(const Pixels& pixels, const Layout& layout, const Rect& inset, unsigned colour) {
  const double wall = inset.y + kWallShare * inset.height;
  const int x = static_cast<int>(inset.x + 0.5f * inset.width + 36 * layout.scale);  // beside the tool
  const Patch mark =
      patchOf(pixels, colour, {x, static_cast<int>(wall) - 3}, {x + 6, static_cast<int>(inset.y + inset.height)}, 0.05);
  return mark.count > 0 ? (mark.centre.y - wall) / rulerStep(layout) : -1.0;
}

}  // namespace

TEST_CASE("the split screen shows two tools under one hand: depths at one scale, both curves, one ratio", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(
      folder / "script.txt",
      "0 renderer position-control\n0 split\n0 right impedance\n0.1 picture before\n0.1 hand 0 0 -26 over "
      "0.7\n2.4 picture pressed\n2.5 swap\n2.6 home\n3.4 hand 0 0 -26 over 0.7\n5.4 picture swapped\n5.4 "
      "home\n6.4 push\n11 home\n11.5 picture kept\n11.6 split\n11.7 picture single\n11.8 split\n11.9 picture "
      "again\n11.9 end\n");
  for (const auto& [size, scale] : {std::pair{glm::ivec2(1280, 720), 1}, {{2560, 1440}, 2}, {{800, 600}, 1}}) {
    const std::string out = folder / (std::to_string(size.x) + "x" + std::to_string(size.y));
    const auto result = test::viewer("--headless --script '" + folder / "script.txt" + "' --size " +
                                     std::to_string(size.x) + "x" + std::to_string(size.y) + " --scale " +
                                     std::to_string(scale) + " --record '" + out + "' --report '" + out + ".json'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    CHECK(nlohmann::json::parse(test::readFile(out + ".json")).at("opengl_errors") == 0);
    const auto s = static_cast<float>(scale);
    const Layout layout = layOutSplit(size, s, true);
    const auto picture = [&out](const char* name) { return Pixels(out + "/" + name + ".png"); };
    const Pixels before = picture("before"), pressed = picture("pressed"), swapped = picture("swapped"),
                 kept = picture("kept"), single = picture("single");
    // Both panes show the scene.
    for (const Rect* pane : {&layout.scene, &layout.right}) CHECK(distinctColours(before, *pane) > 100);
    // 26 mm of the hand at 400 N/m against 6 kN/m; position control does not yield. Then the tools change sides.
    const double sunk = 26.0 * 400.0 / (400.0 + 6000.0);
    CHECK(markOf(before, layout, layout.rightInset, kPurple) < 0.0);
    CHECK(markOf(pressed, layout, layout.rightInset, kPurple) == Approx(sunk).margin(0.06));
    CHECK(std::abs(markOf(pressed, layout, layout.inset, kBlue)) < 0.06);
    CHECK(markOf(swapped, layout, layout.inset, kPurple) == Approx(sunk).margin(0.06));
    CHECK(std::abs(markOf(swapped, layout, layout.rightInset, kBlue)) < 0.06);
    // Curves of both tools: absent before, and kept after the hand has gone.
    const auto curves = [&](const Pixels& pixels, unsigned colour) {
      const Rect& a = layout.compare;
      return patchOf(pixels, colour, glm::ivec2(a.x + 0.4f * a.width, a.y + 30 * s),
                     glm::ivec2(a.x + 0.77f * a.width - 20 * s, a.y + a.height - 28 * s))
          .count;
    };
    if (size.x >= 1280) {
      CHECK(curves(before, kPurple) < 0.2 * curves(pressed, kPurple));
      CHECK(curves(pressed, kPurple) > 100);
      CHECK(curves(kept, kPurple) > 100);
      CHECK(curves(kept, kBlue) > 30);
    }
    // The ratio: large dark digits, absent before the test push.
    const auto figures = [&](const Pixels& pixels) {
      const Rect& a = layout.compare;
      int dark = 0;
      for (int y = static_cast<int>(a.y + 44 * s); y < static_cast<int>(a.y + 88 * s); ++y)
        for (int x = static_cast<int>(a.x + a.width - std::min(250 * s, 0.4f * a.width));
             x < static_cast<int>(a.x + a.width); ++x)
          dark += pixels.at(x, y).g < 60;
      return static_cast<float>(dark) / (s * s);
    };
    CHECK(figures(before) < 150);
    CHECK(figures(pressed) < 150);
    CHECK(figures(kept) > 600);
    // Shown again, both panes have the same light: at the same poses only their titles differ.
    const Pixels again = picture("again");
    int differing = 0, all = 0;
    for (int y = static_cast<int>(60 * s); y < static_cast<int>(layout.scene.height); ++y)
      for (int x = 4; x < static_cast<int>(layout.scene.width) - 4; ++x, ++all) {
        const glm::ivec3 left = again.at(static_cast<int>(layout.scene.x) + x, y),
                         right = again.at(static_cast<int>(layout.right.x) + x, y);
        differing += glm::distance(glm::dvec3(left), glm::dvec3(right)) > 24.0;
      }
    CHECK(differing < 0.02 * all);
    // Back in the single view with its charts.
    if (size.x >= 1280) CHECK(distinctColours(single, layOut(size, s, true, true).charts) > 20);
  }
}

TEST_CASE("the tour says three sentences, can be skipped, and runs by itself at the first start only", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt",
                  "0.1 tour\n0.9 picture before\n6.8 picture push\n10 picture slide\n17 picture let-go\n20.5 picture "
                  "end\n20.6 tour\n"
                  "27.3 picture again\n27.4 cancel\n27.5 picture skipped\n29 end\n");
  const auto result = test::viewer("--headless --script '" + folder / "script.txt" + "' --record '" + folder / "out" +
                                   "' --report '" + folder / "report.json'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  const Layout layout = layOutSplit({1280, 720}, 1.0f, true, true);
  // The sentence is white on a dark ground, above both panes.
  const auto sentenceBox = [&](const std::string& name) {
    const Pixels pixels(folder / ("out/" + name + ".png"));
    std::vector<bool> words;
    int dark = 0;
    for (int y = 4; y < 36; ++y)
      for (int x = static_cast<int>(layout.tour.x) + 10; x < static_cast<int>(layout.tour.x) + 700; ++x) {
        dark += pixels.at(x, y).g < 80;
        words.push_back(pixels.at(x, y).g > 180);
      }
    return dark > 15000 ? words : std::vector<bool>{};
  };
  const auto push = sentenceBox("push"), slide = sentenceBox("slide"), letGo = sentenceBox("let-go");
  REQUIRE_FALSE(push.empty());
  REQUIRE_FALSE(slide.empty());
  REQUIRE_FALSE(letGo.empty());
  CHECK(push != slide);
  CHECK(slide != letGo);
  CHECK(sentenceBox("end").empty());
  CHECK(sentenceBox("skipped").empty());
  // A scene with more than a wall has no tour.
  test::writeFile(folder / "other.txt", "0 tour\n0.5 end\n");
  for (const auto& [scene, tours] :
       {std::pair{"oblique-wall.toml", true}, {"corner.toml", false}, {"jaw.toml", false}}) {
    INFO(scene);
    REQUIRE(test::viewer(test::shippedScene(scene) + " --headless --script '" + folder / "other.txt" +
                         "' --overwrite --report '" + folder / "other.json'")
                .status == 0);
    CHECK(nlohmann::json::parse(test::readFile(folder / "other.json")).at("touring").get<bool>() == tours);
  }
  // The push and the slide, and no mark of a press before them.
  const auto mark = [&](const std::string& name, unsigned colour) {
    const Rect& inset = colour == kBlue ? layout.inset : layout.rightInset;
    return markOf(Pixels(folder / ("out/" + name + ".png")), layout, inset, colour);
  };
  CHECK(mark("before", kPurple) < 0.0);
  CHECK(mark("push", kPurple) == Approx(3.8).margin(0.1));
  CHECK(std::abs(mark("push", kBlue)) < 0.06);
  CHECK(mark("slide", kPurple) == Approx(12.0 / 6.4).margin(0.1));
  // The words agree with the picture, and both tours read the same.
  const auto headless = nlohmann::json::parse(test::readFile(folder / "report.json"));
  REQUIRE(headless.at("shown").at("ratios").size() == 1);
  const std::string ratio = headless.at("shown").at("ratios")[0];
  CHECK_THAT(ratio, test::ContainsSubstring("; test push of 12 N: 0.0") && test::ContainsSubstring(" mm and 3.8"));
  CHECK_FALSE(headless.at("contact").get<bool>());
  if (!test::haveXvfb()) return test::skipTest("Xvfb is missing");
  // Without a script in a new home: the start is remembered, and a person who closes the window during the tour gets no
  // warning. A second start has no tour.
  const auto tours = [&](bool waits) {
    const test::XServer server(folder);
    test::RunningViewer viewer(folder, test::kFewPictures,
                               server.environment() + "HOME='" + folder / "home' XDG_STATE_HOME= ");
    auto report = viewer.report();
    // In real time, at any rate of pictures, the push gives the same numbers.
    if (waits) report = viewer.untilShown("ratios", ratio);
    viewer.signal(SIGINT);
    CHECK(viewer.wait() == 128 + SIGINT);
    CHECK(viewer.said().empty());
    return report.at("touring").get<bool>() ||
           viewer.isAmong(report.at("shown").at("notices"),
                          "You now control the hand");  // already over on a slow machine
  };
  std::filesystem::create_directory(folder / "home");
  CHECK(tours(true));
  CHECK(std::filesystem::exists(folder / "home/.local/state/enamel/viewer-was-started"));
  CHECK_FALSE(tours(false));
}

TEST_CASE("the followed contact is in the middle, and links that hide it shine through", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt",
                  "0 panels\n0 charts\n0 camera-device\n0 picture first\n0.1 hand 16 12 -20 over 0.4\n0.1 follow\n2 "
                  "picture followed\n"
                  "2 hand -16 -12 -20 over 0.4\n4 picture elsewhere\n4.1 camera-side\n4.2 picture preset\n4.2 end\n");
  const auto result = test::viewer("--headless --script '" + folder / "script.txt" + "' --record '" + folder / "out'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  // In the view of the device, an arm of bluish steel is 26 to 44 pixels above the tool's tip. The warm wall must be
  // visible through it.
  const glm::ivec2 tip(project(cameraPresets()[0].camera, {1280, 720}, {0.0, 0.0, 8.0}));
  int steel = 0, all = 0;
  const Pixels first(folder / "out/first.png");
  for (int y = tip.y - 44; y < tip.y - 26; ++y)
    for (int x = tip.x; x < tip.x + 13; ++x, ++all) steel += first.at(x, y).z > first.at(x, y).x + 5;
  CHECK(steel < 0.1 * all);
  // The contact's mark and the foot of the arrow are in the middle, wherever the tool is.
  const auto marked = [&](const std::string& name) {
    return patchOf(Pixels(folder / ("out/" + name + ".png")), kVermilion, {600, 320}, {680, 400}).count;
  };
  CHECK(marked("followed") > 60);
  CHECK(marked("elsewhere") > 60);
  CHECK(marked("preset") < 20);
}

TEST_CASE("teeth are ivory with dark fissures, in pink gum; the tool slides over a molar's cusps", "[viewer]") {
  const test::TemporaryFolder folder;
  const auto run = [&](const std::string& scene, const std::string& script) {
    const auto result = test::viewer(test::shippedScene(scene) + " --headless --script '" + script +
                                     "' --overwrite --record '" + folder / "out' --report '" + folder / "report.json'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    return nlohmann::json::parse(test::readFile(folder / "report.json"));
  };
  // Count pixels of the scene between its text and the inset.
  const auto count = [&](const std::string& name, unsigned colour) {
    return patchOf(Pixels(folder / ("out/" + name + ".png")), colour, {480, 80}, {900, 460}, 0.025).count;
  };
  constexpr unsigned fissure = 0x8A7050;
  const auto shown = run("cusps.toml", ENAMEL_SOURCE_DIR "/data/scripts/explore.txt").at("shown");
  CHECK(shown.at("badges") == nlohmann::json{"slipped"});
  CHECK(shown.at("deepest [m]") < 20e-6);
  CHECK(count("explore-cusp", kEnamel) > 8000);
  CHECK(count("explore-cusp", kGum) > 20000);
  CHECK(count("explore-cusp", fissure) > 300);
  // The wall of flat-wall has neither colour.
  test::writeFile(folder / "flat.txt", "0 follow\n1 picture flat\n1 end\n");
  run("flat-wall.toml", folder / "flat.txt");
  CHECK(count("flat", kGum) < 200);
  // An arch: teeth and gum in one mesh.
  test::writeFile(folder / "jaw.txt", "0 panels\n0 charts\n0 view 0 0 -6 20 20 230\n0.1 picture jaw\n0.1 end\n");
  run("jaw.toml", folder / "jaw.txt");
  CHECK(count("jaw", kEnamel) > 3000);
  CHECK(count("jaw", kGum) > 3000);
}

TEST_CASE("guides are drawn", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "look.txt", "0 panels\n0 charts\n0.1 picture look\n0.1 end\n");
  const auto violet = [&](const std::string& scene) {
    const auto result = test::viewer(test::shippedScene(scene) + " --headless --script '" + folder / "look.txt" +
                                     "' --overwrite --record '" + folder / "out'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    return patchOf(Pixels(folder / "out/look.png"), kGuide, {0, 0}, {1280, 720}, 0.1).count;
  };
  CHECK(violet("guides.toml") > 300);
  CHECK(violet("flat-wall.toml") == 0);
}

TEST_CASE("own scenes stand beside the shipped ones, each once", "[viewer]") {
  const test::TemporaryFolder folder;
  const std::string wall =
      "name = \"a\"\nstart = [0, 0, 0.008]\n[[obstacle]]\nname = \"w\"\nshape = \"half_space\"\npoint = [0, 0, 0]\n"
      "normal = [0, 0, 1]\n";
  test::writeFile(folder / "own.toml", wall);
  test::writeFile(folder / "another.toml", wall);
  test::writeFile(folder / "script.txt", "0.1 picture a\n0.1 end\n");
  const auto choice = [&](const std::string& scene) {
    const auto result = test::viewer(scene + " --headless --script '" + folder / "script.txt' --overwrite --record '" +
                                     folder / "out' --report '" + folder / "report.json'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    return nlohmann::json::parse(test::readFile(folder / "report.json")).at("shown").at("choice of scenes");
  };
  nlohmann::json shipped = choice(test::shippedScene("jaw.toml"));
  CHECK(shipped == choice(""));
  CHECK(std::count(shipped.begin(), shipped.end(), "jaw") == 1);
  CHECK(std::count(shipped.begin(), shipped.end(), "cusps") == 1);
  shipped.push_back("another");
  shipped.push_back("own");
  CHECK(choice("'" + folder / "own.toml'") == shipped);
}

TEST_CASE("a script records ticks and makes a clip; without ffmpeg its pictures remain, and that is said", "[viewer]") {
  const test::TemporaryFolder folder;
  const auto run = [&](const std::string& script, const std::string& arguments) {
    test::writeFile(folder / "script.txt", script);
    const auto result = test::viewer("--headless --script '" + folder / "script.txt' --overwrite --record '" +
                                         folder / "out' --report '" + folder / "report.json' " + arguments,
                                     "env -u DISPLAY -u WAYLAND_DISPLAY PATH=/nowhere");
    INFO(result.output);
    REQUIRE(result.status == 0);
    return result.output;
  };
  const std::string size = " --size 320x240", out = folder / "out/";
  const std::string said = run("0 clip\n0 record\n0 hand 0 0 -20 over 0.3\n1 record\n1.1 clip\n1.2 end\n", size);
  CHECK(said.find("clip-001: 28 pictures, 25 a second; no MP4: ffmpeg is not installed") != std::string::npos);
  int pictures = 0;
  for (const auto& entry : std::filesystem::directory_iterator(out + "clip-001"))
    pictures += entry.path().extension() == ".png";
  CHECK(pictures == 28);  // at 0, 0.04, ..., 1.08 s
  CHECK(Pixels(out + "clip-001/00027.png").size() == glm::ivec2(320, 240));
  const auto shown = [&] { return nlohmann::json::parse(test::readFile(folder / "report.json")).at("shown"); };
  const double deepest = shown().at("deepest [m]");
  run("0 seek 0.9\n0.1 picture there\n0.1 end\n", "--play '" + out + "enamel-001.rec'" + size);
  CHECK(shown().at("scenes") == nlohmann::json{"flat wall"});
  CHECK(shown().at("deepest [m]").get<double>() <= deepest);
  // A recording that is impossible is refused.
  run("0 split\n0.1 record\n0.2 end\n", size);
  CHECK(shown().at("notices") == nlohmann::json{"The split screen cannot be recorded: V shows one tool."});
  CHECK_FALSE(std::filesystem::exists(out + "enamel-002.rec"));
  // A scan is recorded and saved like a scene. The recording and the saved scene open again, as the only argument.
  const std::string scan = "'" ENAMEL_SOURCE_DIR "/data/meshes/molar.ply'" + size;
  run("0 turn-z\n0.1 record\n0.1 hand 0 0 -12 over 0.3\n1 record\n1.1 save-scene\n1.2 end\n", scan);
  const double pressed = shown().at("deepest [m]");
  CHECK(pressed > 0.0);
  run("0 seek 0.9\n0.1 picture there\n0.1 end\n", "'" + out + "enamel-002.rec'" + size);
  CHECK(shown().at("scenes") == nlohmann::json{"molar"});
  run("0.1 hand 0 0 -12 over 0.3\n1 end\n", "'" + out + "molar-001.toml'" + size);
  CHECK(shown().at("scenes") == nlohmann::json{"molar"});
  CHECK(shown().at("deepest [m]").get<double>() > 0.0);
}

TEST_CASE("the magnified view lists every contact", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", "0.1 hand -30 -30 -30 over 0.5\n2 picture corner\n2 end\n");
  const auto result =
      test::viewer(test::shippedScene("corner.toml") + " --renderer impedance --headless --script '" +
                   folder / "script.txt' --record '" + folder / "out' --report '" + folder / "report.json'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto readouts = nlohmann::json::parse(test::readFile(folder / "report.json")).at("readouts");
  INFO(readouts.dump());
  for (const char* contact : {"contact 1: ", "contact 2: "}) CHECK(test::RunningViewer::isAmong(readouts, contact));
}

TEST_CASE("two tools do not share a bur", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "script.txt", "0.05 picture before\n0.1 split\n0.2 picture after\n0.2 end\n");
  const auto result = test::viewer(test::shippedScene("drill.toml") + " --headless --script '" + folder / "script.txt" +
                                   "' --record '" + folder / "out'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  const Pixels before(folder / "out/before.png"), after(folder / "out/after.png");
  const Rect scene = layOut({1280, 720}, 1.0f, true, true).scene;
  // The reason is shown on a dark ground; the panel is unchanged.
  const int x = static_cast<int>(scene.x + 0.5f * scene.width);
  int dark = 0;
  for (int y = 78; y < 102; ++y) dark += after.at(x, y).g < 90 && before.at(x, y).g >= 90;
  CHECK(dark > 8);
  int moved = 0;
  for (int y = 0; y < 720; ++y)
    for (int px = 0; px < 248; ++px) moved += before.at(px, y) != after.at(px, y);
  CHECK(moved == 0);
}

TEST_CASE("a drilled tooth shows where it is deeper than its target, and where it is higher", "[viewer]") {
  const test::TemporaryFolder folder;
  const auto box = [&](const char* name, double top) {  // of 8 mm, from -4 mm to the top
    std::string text;
    for (int i = 0; i < 8; ++i)
      text += "v " + std::to_string(i & 1 ? 4 : -4) + " " + std::to_string(i & 2 ? 4 : -4) + " " +
              std::to_string(i & 4 ? top : -4.0) + "\n";
    test::writeFile(folder / name, text +
                                       "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\n"
                                       "f 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n");
  };
  box("block.obj", 0.0);
  box("high.obj", 0.0);
  box("low.obj", -1.0);
  test::writeFile(folder / "open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  test::writeFile(folder / "block.toml",
                  "name = \"block\"\nstart = [0, 0, 0.002]\n[[tool]]\nfrom = [0, 0, 0.001]\nradius = 0.001\n"
                  "[bur]\nwear = 2.0\n[[obstacle]]\nname = \"block\"\nshape = \"solid\"\nfile = \"block.obj\"\n"
                  "unit = \"mm\"\ncell = 0.0002\n[[obstacle.layer]]\nname = \"enamel\"\nhardness = 3.4e9\n");
  test::writeFile(folder / "script.txt",
                  "0 panels\n0 charts\n0 view 0 0 0 20 -40 40\n0.1 picture before\n0.2 spin on\n0.2 hand 0 0 -12 over "
                  "0.3\n1.6 spin off\n1.6 hand 0 0 9 over 0.2\n2.1 picture after\n2.1 end\n");
  const auto run = [&](const std::string& target) {
    return test::viewer("'" + folder / "block.toml' --headless --size 640x360 --script '" +
                        folder / "script.txt' --record '" + folder / target + "' --target '" + folder / target +
                        ".obj'");
  };
  const auto count = [&](const std::string& picture, unsigned colour) {
    return patchOf(Pixels(folder / (picture + ".png")), colour, {160, 60}, {480, 340}, 0.04).count;
  };
  for (const char* target : {"high", "low"}) {
    const auto result = run(target);
    INFO(result.output);
    REQUIRE(result.status == 0);
  }
  INFO(count("high/after", kBlue) << " " << count("low/before", kVermilion));
  CHECK(count("high/before", kBlue) < 20);
  CHECK(count("high/after", kBlue) > 100);
  CHECK(count("high/after", kVermilion) < 20);
  CHECK(count("low/before", kVermilion) > 1000);
  CHECK(count("low/before", kBlue) < 20);
  const auto open = run("open");
  CHECK(open.status != 0);
  CHECK_THAT(open.output, test::ContainsSubstring("must be closed"));
}

TEST_CASE("a drilled tooth shows its layers, an undone stroke does not; other scenes have no bur", "[viewer]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "tooth.toml",
                  "name = \"tooth\"\nstart = [0, 0, 0.002]\n[[tool]]\nfrom = [0, 0, 0.001]\nradius = 0.001\n"
                  "[bur]\nwear = 2.0\n[[obstacle]]\nname = \"molar\"\nshape = \"solid\"\nfile = \"" ENAMEL_SOURCE_DIR
                  "/data/meshes/molar.ply\"\nunit = \"mm\"\nscale = 1.2\nposition = [0, 0, -0.0057]\ncell = 0.0002\n"
                  "[[obstacle.layer]]\nname = \"enamel\"\nhardness = 3.4e9\n[[obstacle.layer]]\nname = \"dentine\"\n"
                  "hardness = 0.6e9\ndepth = 0.0006\n");
  const std::string away = "hand 0 0 6 over 0.2\n", front = "view 0 0 -3 20 -20 62\n", side = "view 0 0 -3 75 -10 62\n";
  std::string script = "0 panels\n0 charts\n0 " + side + "0.1 " + away + "0.6 picture whole\n0.6 " + front +
                       "0.7 picture before\n0.7 spin on\n0.7 hand 0 0 -12 over 0.3\n1.2 " + side +
                       "1.3 picture flying\n1.3 pause\n1.5 picture paused\n1.5 pause\n2.3 " + front +
                       "2.4 spin off\n2.4 " + away +
                       "2.9 picture drilled\n3.0 cut-away\n3.0 picture open\n3.1 cut-away\n3.1 undo\n3.2 picture "
                       "undone\n3.3 undo\n3.4 picture nothing\n3.4 end\n";
  for (const std::string out : {"out", "again"}) {
    if (out == "again") script.insert(script.find("2.9 picture drilled"), "2.9 save-solid\n");
    test::writeFile(folder / "script.txt", script);
    const auto result = test::viewer("'" + folder / "tooth.toml' --headless --script '" + folder / "script.txt" +
                                     "' --size 640x360 --record '" + folder / out + "'");
    INFO(result.output);
    REQUIRE(result.status == 0);
  }
  // Inside the tooth: beside the box on the left, whose legend has the colours too, and the numbers.
  const auto count = [&](const std::string& name, unsigned colour) {
    return patchOf(Pixels(folder / ("out/" + name + ".png")), colour, {240, 60}, {480, 340}, 0.04).count;
  };
  const unsigned dentine = layerColour("dentine", 3);
  Solid saved = loadSolid(folder / "again/molar-001.solid");
  const RemovedVolume drilled = saved.volume();
  saved.restore();
  const RemovedVolume whole = saved.volume();
  CHECK(drilled[0] < whole[0] - 1e-9);
  CHECK(drilled[1] < whole[1]);
  CHECK(count("before", dentine) < 20);
  CHECK(count("drilled", dentine) > count("before", dentine) + 60);
  CHECK(count("open", dentine) > count("drilled", dentine) + 500);
  // Chips of dentine: the same ones every time, and at rest in the air while time is paused.
  CHECK(count("flying", dentine) > count("whole", dentine) + 60);
  CHECK(count("paused", dentine) == count("flying", dentine));
  CHECK(test::readFile(folder / "out/flying.png") == test::readFile(folder / "again/flying.png"));
  CHECK(count("undone", dentine) < 20);
  CHECK(count("undone", layerColour("enamel", 2)) > 1000);
  // A refusal is shown on a dark ground in the middle.
  const auto isRefused = [&](const std::string& name) {
    const Pixels pixels(folder / ("out/" + name + ".png"));
    int dark = 0;
    for (int y = 78; y < 102; ++y) dark += pixels.at(pixels.size().x / 2, y).g < 90;
    return dark > 12;
  };
  CHECK_FALSE(isRefused("undone"));
  CHECK(isRefused("nothing"));
  test::writeFile(folder / "script.txt",
                  "0 panels\n0 charts\n0 spin off\n0.1 picture quiet\n0.2 spin on\n0.3 picture refused\n0.3 end\n");
  CHECK(test::viewer("--headless --script '" + folder / "script.txt' --size 640x360 --record '" + folder / "out'")
            .status == 0);
  CHECK_FALSE(isRefused("quiet"));
  CHECK(isRefused("refused"));
  if (!test::haveXvfb()) return test::skipTest("Xvfb is missing");
  // A script is silent unless it requests sound; a missing device is reported once.
  const std::string silence = "ALSOFT_DRIVERS=none ";
  test::writeFile(folder / "script.txt", "0.1 spin on\n0.8 end\n");
  const auto silent = test::viewer("'" + folder / "tooth.toml' --script '" + folder / "script.txt'" + test::kByPictures,
                                   "env " + silence + test::kXvfb);
  CHECK(silent.status == 0);
  CHECK(silent.output.empty());
  test::writeFile(folder / "script.txt", "0 sound\n0.1 spin on\n7000 end\n");
  const test::XServer server(folder);
  test::RunningViewer viewer(folder,
                             "'" + folder / "tooth.toml' --script '" + folder / "script.txt'" + test::kFewPictures,
                             server.environment() + silence);
  viewer.untilSaid("no sound: ");
  viewer.untilDrawn(5);
  viewer.signal(SIGINT);
  CHECK(viewer.wait() == 128 + SIGINT);
  CHECK(viewer.said().find("no sound: ") == viewer.said().rfind("no sound: "));
}

}  // namespace enamel::viewer::test_pictures
