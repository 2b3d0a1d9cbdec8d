#define GLFW_INCLUDE_NONE
#include "input.hpp"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace enamel::viewer {
namespace {

// Return the scene at a place, and its size.
std::pair<Rect, glm::dvec2> paneAt(const Layout& layout, const glm::dvec2& place) {
  const Rect& area = layout.isSplit() && place.x >= layout.right.x ? layout.right : layout.scene;
  return {area, {std::max(1.0f, area.width), std::max(1.0f, area.height)}};
}

double shareOf(const Rect& bar, double x) {
  return std::clamp((x - static_cast<double>(bar.x)) / static_cast<double>(bar.width), 0.0, 1.0);
}

// Return the displacement in the plane through `like` with normal `normal` that follows the cursor. If the plane is
// seen almost edge-on, use the plane of the view and remove the part along the normal.
glm::dvec3 slid(const Camera& camera, const glm::dvec2& size, const glm::dvec2& from, const glm::dvec2& to,
                const glm::dvec3& like, const glm::dvec3& normal) {
  constexpr double leastSlope = 0.2;
  const glm::dvec3 eye = camera.eye();
  const auto onPlane = [&](const glm::dvec2& pixel, glm::dvec3& point) {
    const glm::dvec3 ray = glm::normalize(unproject(camera, size, pixel, like) - eye);
    const double slope = glm::dot(ray, normal);
    point = eye + glm::dot(like - eye, normal) / slope * ray;
    return std::abs(slope) > leastSlope;
  };
  glm::dvec3 a, b;
  if (onPlane(from, a) && onPlane(to, b)) return b - a;
  const glm::dvec3 moved = unproject(camera, size, to, like) - unproject(camera, size, from, like);
  return moved - glm::dot(moved, normal) * normal;
}

}  // namespace

void Input::key(int key, int action, int modifiers) {
  if (action == GLFW_RELEASE) return;
  const ActionRow* row = actionOfKey(key, (modifiers & GLFW_MOD_CONTROL) != 0);
  if (row != nullptr && (action == GLFW_PRESS || row->action == Action::step || row->action == Action::stepBack))
    target_.act(row->action);
}

void Input::button(int button, int action, int modifiers) {
  drag_ = Drag::none;
  seeks_ = false;
  if (action == GLFW_RELEASE) return;
  const Rect& bar = target_.layout().bar;
  seeks_ = cursor_.x >= bar.x && cursor_.x < bar.x + bar.width && cursor_.y >= bar.y && cursor_.y < bar.y + bar.height;
  if (seeks_) return target_.seek(shareOf(bar, cursor_.x));
  along_ = (modifiers & GLFW_MOD_SHIFT) != 0;
  const auto [area, size] = paneAt(target_.layout(), cursor_);
  const bool onTool =
      along_ || isOnTool(target_.camera(), size, cursor_ - glm::dvec2(area.x, area.y), target_.tool(), target_.axis());
  drag_ = button == GLFW_MOUSE_BUTTON_MIDDLE           ? Drag::pan
          : button == GLFW_MOUSE_BUTTON_LEFT && onTool ? Drag::hand
                                                       : Drag::orbit;
}

void Input::cursor(const glm::dvec2& place) {
  const glm::dvec2 before = cursor_;
  cursor_ = place;
  if (seeks_) return target_.seek(shareOf(target_.layout().bar, place.x));
  if (drag_ == Drag::none) return;
  const auto [area, size] = paneAt(target_.layout(), place);
  const glm::dvec2 corner(area.x, area.y);
  Camera& camera = target_.camera();
  const glm::dvec3 like = target_.tool();
  const glm::dvec3 moved =
      unproject(camera, size, place - corner, like) - unproject(camera, size, before - corner, like);
  if (drag_ == Drag::hand)
    target_.moveHandBy(along_ ? slid(camera, size, before - corner, place - corner, like, target_.normal()) : moved);
  else if (drag_ == Drag::orbit)
    orbit(camera, 4.0 * (place.x - before.x) / size.y, 4.0 * (place.y - before.y) / size.y);
  else
    camera.focus -= moved;
}

void Input::wheel(double notches, bool presses) {
  if (presses) return target_.pressBy(0.4 * notches);
  // Keep the point under the cursor, at the tool's distance, in place.
  const auto [area, size] = paneAt(target_.layout(), cursor_);
  Camera& camera = target_.camera();
  const glm::dvec3 kept = unproject(camera, size, cursor_ - glm::dvec2(area.x, area.y), target_.tool());
  const double before = camera.distance;
  zoom(camera, std::pow(0.9, notches));
  camera.focus = kept + camera.distance / before * (camera.focus - kept);
}

void Input::hold(const std::function<bool(int key)>& isDown, double seconds) {
  constexpr double speed = 25.0, pressing = 8.0;  // mm/s, N/s
  const auto down = [&isDown](int key) { return isDown(key) ? 1.0 : 0.0; };
  const glm::dvec3 across(down(GLFW_KEY_D) - down(GLFW_KEY_A), down(GLFW_KEY_W) - down(GLFW_KEY_S), 0.0);
  if (across != glm::dvec3(0.0)) target_.moveHandBy(speed * seconds * across);
  const double press = down(GLFW_KEY_E) - down(GLFW_KEY_Q);
  if (press != 0.0) target_.pressBy(pressing * seconds * press);
  if (isDown(GLFW_KEY_F) != pedal_) target_.spin(pedal_ = !pedal_);
}

}  // namespace enamel::viewer
