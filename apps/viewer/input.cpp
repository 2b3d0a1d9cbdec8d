#define GLFW_INCLUDE_NONE
#include "input.hpp"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>

namespace enamel::viewer {
namespace {

double shareOf(const Area& bar, double x) {
  return std::clamp((x - static_cast<double>(bar.x)) / static_cast<double>(bar.width), 0.0, 1.0);
}

}  // namespace

void Input::key(int key, int action, int modifiers) {
  if (action == GLFW_RELEASE) return;
  const ActionRow* row = actionOfKey(key, (modifiers & GLFW_MOD_CONTROL) != 0);
  if (row != nullptr && (action == GLFW_PRESS || row->action == Action::step || row->action == Action::stepBack))
    driven_.act(row->action);
}

void Input::button(int button, int action) {
  dragged_ = action == GLFW_RELEASE ? -1 : button;
  const Area& bar = driven_.layout().bar;
  seeks_ = dragged_ >= 0 && cursor_.x >= bar.x && cursor_.x < bar.x + bar.width && cursor_.y >= bar.y &&
           cursor_.y < bar.y + bar.height;
  if (seeks_) driven_.seek(shareOf(bar, cursor_.x));
}

void Input::cursor(const glm::dvec2& place) {
  const glm::dvec2 before = cursor_;
  cursor_ = place;
  if (dragged_ < 0) return;
  if (seeks_) return driven_.seek(shareOf(driven_.layout().bar, place.x));
  const Layout& layout = driven_.layout();
  const Area& area = layout.isSplit() && place.x >= layout.right.x ? layout.right : layout.scene;
  const glm::dvec2 size(std::max(1.0f, area.width), std::max(1.0f, area.height)), corner(area.x, area.y);
  Camera& camera = driven_.camera();
  const glm::dvec3 like = driven_.tool();
  const glm::dvec3 moved =
      unproject(camera, size, place - corner, like) - unproject(camera, size, before - corner, like);
  if (dragged_ == GLFW_MOUSE_BUTTON_LEFT)
    driven_.moveHandBy(moved);
  else if (dragged_ == GLFW_MOUSE_BUTTON_RIGHT)
    orbit(camera, 4.0 * (place.x - before.x) / size.y, 4.0 * (place.y - before.y) / size.y);
  else
    camera.focus -= moved;
}

void Input::wheel(double notches, bool control) {
  if (control)
    zoom(driven_.camera(), std::pow(0.9, notches));
  else
    driven_.pressBy(0.4 * notches);
}

void Input::hold(const std::function<bool(int key)>& isDown, double seconds) {
  constexpr double speed = 25.0, pressing = 8.0;  // mm/s, N/s
  const auto down = [&isDown](int key) { return isDown(key) ? 1.0 : 0.0; };
  const glm::dvec3 across(down(GLFW_KEY_D) - down(GLFW_KEY_A), down(GLFW_KEY_W) - down(GLFW_KEY_S), 0.0);
  if (across != glm::dvec3(0.0)) driven_.moveHandBy(speed * seconds * across);
  const double press = down(GLFW_KEY_E) - down(GLFW_KEY_Q);
  if (press != 0.0) driven_.pressBy(pressing * seconds * press);
  if (isDown(GLFW_KEY_F) != pedal_) driven_.spin(pedal_ = !pedal_);
}

}  // namespace enamel::viewer
