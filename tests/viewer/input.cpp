// Keys and mouse do what the help says, without a window.
#define GLFW_INCLUDE_NONE
#include "input.hpp"

#include <GLFW/glfw3.h>

#include <glm/gtc/matrix_access.hpp>
#include <set>
#include <string>
#include <vector>

#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::viewer::test_input {

namespace {

class Recorder final : public InputTarget {
 public:
  void act(Action action) override { actions.push_back(action); }
  void moveHandBy(const glm::dvec3& millimetres) override { hand += millimetres, ++moves; }
  void pressBy(double newtons) override { pressed += newtons; }
  void spin(bool on) override { spins.push_back(on); }
  void seek(double share) override { shares.push_back(share); }
  void drop(const std::vector<std::string>& paths) override { dropped = paths; }
  Camera& camera() override { return view; }
  const Layout& layout() const override { return place; }
  glm::dvec3 tool() const override { return {3.0, -2.0, 8.0}; }
  glm::dvec3 axis() const override { return {0.0, 0.0, 1.0}; }
  glm::dvec3 normal() const override { return wall; }

  std::vector<Action> actions;
  std::vector<std::string> dropped;
  std::vector<double> shares;
  std::vector<bool> spins;
  glm::dvec3 hand{0.0};
  int moves = 0;
  double pressed = 0.0;
  glm::dvec3 wall{0.0, 0.0, 1.0};
  Camera view = cameraPresets()[0].camera;
  Layout place = layOut({1280, 720}, 1.0f, true, true);
};

}  // namespace

TEST_CASE("every key of the help acts, once a press", "[viewer]") {
  std::set<std::pair<int, bool>> keys;
  for (const ActionRow& row : actionRows()) {
    INFO(row.keys);
    CHECK(keys.insert({row.key, row.control}).second);  // every key has one meaning
    Recorder recorder;
    Input input(recorder);
    const int modifiers = row.control ? GLFW_MOD_CONTROL : 0;
    input.key(row.key, GLFW_PRESS, modifiers);
    input.key(row.key, GLFW_REPEAT, modifiers);
    input.key(row.key, GLFW_RELEASE, modifiers);
    // Only single ticks repeat while their key is held.
    const bool ticks = row.action == Action::step || row.action == Action::stepBack;
    REQUIRE(recorder.actions.size() == (ticks ? 2 : 1));
    CHECK(&actionRows()[static_cast<std::size_t>(row.action)] == &row);
    CHECK(recorder.actions[0] == row.action);
    CHECK(actionOfName(row.name) == &row);
  }
  Recorder recorder;
  Input input(recorder);
  input.key(GLFW_KEY_F12, GLFW_PRESS, 0);
  input.key(GLFW_KEY_TAB, GLFW_PRESS, GLFW_MOD_CONTROL);
  CHECK(recorder.actions.empty());
  input.key(GLFW_KEY_KP_ADD, GLFW_PRESS, 0);
  input.key(GLFW_KEY_KP_SUBTRACT, GLFW_PRESS, 0);
  CHECK(recorder.actions == std::vector<Action>{Action::faster, Action::slower});
  CHECK(actionOfName("no-such-action") == nullptr);
}

TEST_CASE("a left drag moves the hand as far as the cursor goes at the tool", "[viewer]") {
  test::Random random(611);
  for (int i = 0; i < 100; ++i) {
    Recorder recorder;
    recorder.view = cameraPresets()[static_cast<std::size_t>(i % 3)].camera;
    const Camera before = recorder.view;
    Input input(recorder);
    const glm::dvec2 corner(recorder.place.scene.x, recorder.place.scene.y);
    const glm::dvec2 size(recorder.place.scene.width, recorder.place.scene.height);
    const glm::dvec2 from = corner + glm::dvec2(project(before, size, recorder.tool()));
    const glm::dvec2 to = from + glm::dvec2{random.uniform(-80.0, 80.0), random.uniform(-80.0, 80.0)};
    input.cursor(from);
    input.cursor(to);
    CHECK(recorder.moves == 0);  // no button is pressed
    input.cursor(from);
    input.button(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS);
    input.cursor(glm::mix(from, to, 0.3));
    input.cursor(to);
    input.button(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE);
    input.cursor(from);
    CHECK(recorder.moves == 2);
    // The tool would be seen at the cursor; 1e-6 of a pixel is far above rounding.
    const glm::dvec2 seen = corner + glm::dvec2(project(before, size, recorder.tool() + recorder.hand));
    CHECK(glm::distance(seen, to) < 1e-6);
    CHECK(recorder.view.azimuth == before.azimuth);
    CHECK(recorder.view.focus == before.focus);
  }
}

TEST_CASE(
    "with Shift a left drag moves the hand along the wall, under the cursor where the wall is seen from the front",
    "[viewer]") {
  test::Random random(613);
  int under = 0;
  for (int i = 0; i < 200; ++i) {
    Recorder recorder;
    const Vec3 n = random.vector(1.0).normalized();
    recorder.wall = {n.x(), n.y(), n.z()};
    const Camera& camera = recorder.view;
    Input input(recorder);
    const glm::dvec2 corner(recorder.place.scene.x, recorder.place.scene.y);
    const glm::dvec2 size(recorder.place.scene.width, recorder.place.scene.height);
    const glm::dvec2 from = corner + glm::dvec2(project(camera, size, recorder.tool()));
    const glm::dvec2 to = from + glm::dvec2{random.uniform(-40.0, 40.0), random.uniform(-40.0, 40.0)};
    input.cursor(from);
    input.button(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS, GLFW_MOD_SHIFT);
    input.cursor(to);
    input.button(GLFW_MOUSE_BUTTON_LEFT, GLFW_RELEASE);
    CHECK(std::abs(glm::dot(recorder.hand, recorder.wall)) < 1e-9);  // mm
    CHECK(glm::length(recorder.hand) < 200.0);                       // also if it is seen edge-on
    const glm::dvec3 ray = glm::normalize(recorder.tool() - camera.eye());
    if (std::abs(glm::dot(ray, recorder.wall)) < 0.5) continue;
    ++under;
    const glm::dvec2 seen = corner + glm::dvec2(project(camera, size, recorder.tool() + recorder.hand));
    CHECK(glm::distance(seen, to) < 1e-6);  // pixels
  }
  CHECK(under > 50);
}

TEST_CASE("from 640x480 to 4K every part is inside of the window, and none stands on another", "[viewer]") {
  const auto inside = [](const Rect& a, const Rect& of) {
    return a.x >= of.x && a.y >= of.y && a.x + a.width <= of.x + of.width + 0.01f &&
           a.y + a.height <= of.y + of.height + 0.01f;
  };
  const auto apart = [](const Rect& a, const Rect& b) {
    return a.x + a.width <= b.x + 0.01f || b.x + b.width <= a.x + 0.01f || a.y + a.height <= b.y + 0.01f ||
           b.y + b.height <= a.y + 0.01f;
  };
  for (const glm::ivec2 size : {glm::ivec2(640, 480),
                                {800, 600},
                                {1024, 768},
                                {1280, 720},
                                {1366, 768},
                                {1920, 1080},
                                {2560, 1440},
                                {3840, 2160},
                                {480, 900}})
    for (const float scale : {1.0f, 1.5f, 2.0f, 3.0f})
      for (const int what : {0, 1, 2, 3, 4}) {  // a run, a recording, one without panels, the split screen, its tour
        if (static_cast<float>(size.x) < 480 * scale || static_cast<float>(size.y) < 480 * scale) continue;
        INFO(size.x << "x" << size.y << " " << scale << " " << what);
        const Layout l = what >= 3 ? layOutSplit(size, scale, true, what == 4)
                                   : layOut(size, scale, what != 2, what != 2, what == 1 ? 0 : 5);
        const Rect window{0, 0, static_cast<float>(size.x), static_cast<float>(size.y)};
        const Rect* const parts[] = {&l.panel, &l.scene, &l.right, &l.charts, &l.gauge, &l.bar, &l.compare, &l.tour};
        for (const Rect* a : parts) {
          CHECK(inside(*a, window));
          for (const Rect* b : parts)
            if (a != b && a->width * a->height > 0 && b->width * b->height > 0) CHECK(apart(*a, *b));
        }
        CHECK(l.scene.width >= 230 * scale);
        CHECK(l.scene.height >= 100 * scale);
        if (what < 3 && l.inset.width > 0) CHECK(inside(l.inset, l.scene));
        if (what >= 3)
          for (const Rect* part : {&l.scene, &l.right, &l.compare, &l.tour})
            if (l.inset.width > 0 && part->height > 0) CHECK(apart(l.inset, *part));
        for (const Rect& chart : l.chart)
          if (l.charts.width * l.charts.height > 0) CHECK(inside(chart, l.charts));
      }
}

TEST_CASE("zooming keeps what is under the cursor where it is", "[viewer]") {
  Recorder recorder;
  Input input(recorder);
  const Rect& area = recorder.place.scene;
  const glm::dvec2 size(area.width, area.height), corner(area.x, area.y), cursor = corner + glm::dvec2(140.0, 90.0);
  const Camera before = recorder.view;
  const glm::dvec3 point = unproject(before, size, cursor - corner, recorder.tool());
  input.cursor(cursor);
  for (const double notches : {3.0, -1.0, 200.0}) {  // the last one is limited by the smallest distance
    input.wheel(notches, false);
    CHECK(glm::distance(corner + glm::dvec2(project(recorder.view, size, point)), cursor) < 1e-6);  // pixels
  }
  CHECK(recorder.view.distance == Approx(kNearest));
  CHECK(recorder.view.azimuth == before.azimuth);
  CHECK(recorder.pressed == 0.0);
}

TEST_CASE("a camera that follows is there after half a second, whatever the rate of pictures", "[viewer]") {
  for (const double passed : {1.0 / 60.0, 0.1}) {
    Camera camera = cameraPresets()[0].camera;
    for (double time = 0.0; time < 0.6; time += passed) follow(camera, {5.0, 6.0, -7.0}, passed);
    CHECK(glm::distance(camera.focus, glm::dvec3(5.0, 6.0, -7.0)) < 0.5);
  }
  Camera still = cameraPresets()[0].camera;
  follow(still, {5.0, 6.0, -7.0}, 0.0);
  CHECK(still.focus == cameraPresets()[0].camera.focus);
}

TEST_CASE("a drag beside the tool turns the view, the middle button shifts it, and the hand stays", "[viewer]") {
  Recorder recorder;
  Input input(recorder);
  const Rect& scene = recorder.place.scene;
  const glm::dvec2 tip =
      glm::dvec2(scene.x, scene.y) + glm::dvec2(project(recorder.view, {scene.width, scene.height}, recorder.tool()));
  for (const int button : {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT}) {
    const Camera before = recorder.view;
    // The right button turns it anywhere, the left one away from the tool.
    const glm::dvec2 from = button == GLFW_MOUSE_BUTTON_RIGHT ? tip : tip + glm::dvec2(60.0, 60.0);
    input.cursor(from);
    input.button(button, GLFW_PRESS);
    input.cursor(from + glm::dvec2(60.0, 30.0));
    input.button(button, GLFW_RELEASE);
    CHECK(recorder.view.azimuth < before.azimuth);  // the scene follows the mouse
    CHECK(recorder.view.elevation > before.elevation);
    CHECK(recorder.view.focus == before.focus);
    CHECK(recorder.moves == 0);
  }
  input.cursor({660.0, 330.0});
  const Camera turned = recorder.view;
  const Rect& area = recorder.place.scene;
  const glm::dvec2 size(area.width, area.height);
  const glm::dvec2 seenBefore(project(turned, size, recorder.tool()));
  input.button(GLFW_MOUSE_BUTTON_MIDDLE, GLFW_PRESS);
  input.cursor({690.0, 310.0});
  input.button(GLFW_MOUSE_BUTTON_MIDDLE, GLFW_RELEASE);
  CHECK(recorder.view.azimuth == turned.azimuth);
  // The point at the tool's distance has moved with the cursor.
  const glm::dvec2 shift = glm::dvec2(project(recorder.view, size, recorder.tool())) - seenBefore;
  CHECK(glm::distance(shift, glm::dvec2(30.0, -20.0)) < 1e-6);
  CHECK(recorder.moves == 0);
  CHECK(recorder.pressed == 0.0);
}

TEST_CASE("the field shows the tip of the tool and what is nearest, large; a drag meets the tool along its handle",
          "[viewer]") {
  for (const char* name : {"flat-wall", "jaw", "cusps", "corner", "box", "oblique-wall"}) {
    INFO(name);
    const SceneFile scene = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/" + std::string(name) + ".toml");
    const Camera camera = fieldCamera(scene);
    const glm::dvec3 tip = millimetres(scene.start), axis(0.0, 0.0, 1.0);
    for (const glm::dvec2 size : {glm::dvec2(660.0, 720.0), {1300.0, 1080.0}, {552.0, 600.0}}) {
      const auto at = [&](const glm::dvec3& point) { return glm::dvec2(project(camera, size, point)); };
      // The tip is in the upper middle, away from the numbers.
      CHECK(std::abs(at(tip).x / size.x - 0.5) < 0.25);
      CHECK(at(tip).y > 0.12 * size.y);
      CHECK(at(tip).y < 0.6 * size.y);
      // A tooth of 10 mm has more than a fifth of the height.
      const glm::dvec3 up = glm::dvec3(glm::row(camera.view(), 1));
      CHECK(glm::distance(at(tip), at(tip + 10.0 * up)) > 0.2 * size.y);
      for (const double along : {0.0, 10.0, 20.0}) CHECK(isOnTool(camera, size, at(tip + along * axis), tip, axis));
      const glm::dvec3 right = glm::dvec3(glm::row(camera.view(), 0));
      CHECK_FALSE(isOnTool(camera, size, at(tip + 12.0 * right), tip, axis));
    }
    CHECK(camera.distance < kDeviceFrom);
  }
  for (const CameraPreset& preset : cameraPresets()) CHECK(preset.camera.distance > kDeviceFrom);
}

TEST_CASE("a click on the time bar and a drag from it seek, whatever the button was", "[viewer]") {
  Recorder recorder;
  recorder.place = layOut({1280, 720}, 1.0f, true, true, 0);
  const Rect& bar = recorder.place.bar;
  REQUIRE(bar.width > 100);
  const double middle = bar.y + 0.5 * bar.height;
  const auto at = [&](double share) { return glm::dvec2(bar.x + share * bar.width, middle); };
  for (const int button : {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT}) {
    recorder.shares.clear();
    Input input(recorder);
    const Camera before = recorder.view;
    input.cursor(at(0.25));
    CHECK(recorder.shares.empty());
    input.button(button, GLFW_PRESS);
    input.cursor(at(0.5));
    input.cursor(at(0.75) - glm::dvec2(0.0, 300.0));  // it may leave the bar
    input.cursor(at(2.0));
    input.cursor(at(-1.0));
    input.button(button, GLFW_RELEASE);
    input.cursor(at(0.5));
    REQUIRE(recorder.shares.size() == 5);
    const double expected[] = {0.25, 0.5, 0.75, 1.0, 0.0};
    for (std::size_t i = 0; i < 5; ++i) CHECK(recorder.shares[i] == Approx(expected[i]));
    CHECK(recorder.moves == 0);
    CHECK(recorder.view.azimuth == before.azimuth);
  }
  // Beside the bar, or without one, nothing seeks; Shift moves the hand anywhere.
  for (const int renderers : {0, 4}) {
    recorder.place = layOut({1280, 720}, 1.0f, true, true, renderers);
    recorder.shares.clear();
    Input input(recorder);
    input.cursor(glm::dvec2(bar.x + 50.0, renderers == 0 ? bar.y - 5.0 : middle));
    input.button(GLFW_MOUSE_BUTTON_LEFT, GLFW_PRESS, GLFW_MOD_SHIFT);
    input.cursor(glm::dvec2(bar.x + 90.0, middle));
    CHECK(recorder.shares.empty());
  }
  CHECK(recorder.moves == 2);
}

TEST_CASE("the bur spins as long as the pedal's key is down", "[viewer]") {
  Recorder recorder;
  Input input(recorder);
  bool isDown = false;
  const auto hold = [&] { input.hold([&](int key) { return isDown && key == GLFW_KEY_F; }, 0.02); };
  hold();
  CHECK(recorder.spins.empty());
  isDown = true;
  for (int i = 0; i < 3; ++i) hold();
  CHECK(recorder.spins == std::vector<bool>{true});
  isDown = false;
  for (int i = 0; i < 3; ++i) hold();
  CHECK(recorder.spins == std::vector<bool>{true, false});
  CHECK(recorder.moves == 0);
  input.key(GLFW_KEY_Z, GLFW_PRESS, GLFW_MOD_CONTROL);
  input.key(GLFW_KEY_C, GLFW_PRESS, 0);
  CHECK(recorder.actions == std::vector<Action>{Action::undo, Action::cutAway});
}

TEST_CASE("the wheel zooms, with Ctrl it presses; held keys go with time", "[viewer]") {
  Recorder recorder;
  Input input(recorder);
  const double distance = recorder.view.distance;
  input.wheel(2.0, true);
  CHECK(recorder.pressed == Approx(0.8));  // N
  CHECK(recorder.view.distance == distance);
  input.wheel(1.0, false);
  CHECK(recorder.view.distance == Approx(0.9 * distance));
  CHECK(recorder.pressed == Approx(0.8));

  std::set<int> down;
  const auto hold = [&](double seconds) { input.hold([&](int key) { return down.count(key) > 0; }, seconds); };
  hold(0.1);
  CHECK(recorder.moves == 0);
  down = {GLFW_KEY_D, GLFW_KEY_W};
  hold(0.1);
  CHECK(recorder.hand.x == Approx(2.5));  // mm: 25 mm/s
  CHECK(recorder.hand.y == Approx(2.5));
  CHECK(recorder.hand.z == 0.0);
  down = {GLFW_KEY_A, GLFW_KEY_S};
  hold(0.2);
  CHECK(recorder.hand.x == Approx(-2.5));
  CHECK(recorder.hand.y == Approx(-2.5));
  down = {GLFW_KEY_A, GLFW_KEY_D, GLFW_KEY_E, GLFW_KEY_Q};
  const int moves = recorder.moves;
  hold(0.2);
  CHECK(recorder.moves == moves);
  CHECK(recorder.pressed == Approx(0.8));
  down = {GLFW_KEY_E};
  hold(0.5);
  CHECK(recorder.pressed == Approx(4.8));
  down = {GLFW_KEY_Q};
  hold(1.0);
  CHECK(recorder.pressed == Approx(-3.2));
}

}  // namespace enamel::viewer::test_input
