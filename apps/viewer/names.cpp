// Names in the scene.
#include <algorithm>

#include "device_view.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

void drawNames(const Rect& scene, const std::vector<Rect>& taken, const Camera& camera, const Frame& frame, bool hand,
               const Brush& brush) {
  const float s = brush.s;
  const auto seen = [&](const Vec3& point) { return project(camera, {scene.width, scene.height}, millimetres(point)); };
  // Place the names on opposite sides, so that neither hides the handle between them.
  const Pose& tool = frame.record.pose;
  const Vec3 end = frame.hand.position + tool.rotation * Vec3(0.0, 0.0, kHandleEnd);
  const bool handLeft = seen(end).x < seen(tool.position).x;
  const auto name = [&](const Vec3& point, const char* text, unsigned rgb, bool left) {
    const glm::dvec3 at = seen(point);
    const float px = scene.x + static_cast<float>(at.x), py = scene.y + static_cast<float>(at.y);
    const float wide = Brush::width(gFonts.bold, text), high = 18 * s, x = left ? px - 22 * s - wide : px + 22 * s,
                y = py - 34 * s;
    const auto meets = [&](const Rect& a) {
      return x - 6 * s < a.x + a.width && x + wide + 6 * s > a.x && y < a.y + a.height && y + high > a.y;
    };
    if (at.z > 1.0 || x - 6 * s < scene.x || py < scene.y || py > scene.y + scene.height || y < scene.y ||
        x + wide + 6 * s > scene.x + scene.width || std::any_of(taken.begin(), taken.end(), meets))
      return;
    const float side = left ? -s : s;
    brush.list->AddLine({px + 5 * side, py - 5 * s}, {px + 18 * side, y + high - 3 * s}, ink(rgb), 1.5f * s);
    brush.clear(x, y, wide, high);
    brush.text(gFonts.bold, x, y, kInk, text);
  };
  name(tool.position, "tool", kNeedle, !handLeft);
  if (hand) name(end, "hand", kHand, handLeft);
}

}  // namespace enamel::viewer
