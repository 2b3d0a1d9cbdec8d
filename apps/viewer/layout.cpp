#include "layout.hpp"

#include <algorithm>

namespace enamel::viewer {

Layout layOut(const glm::ivec2& size, float scale, bool panels, bool charts, int renderers) {
  Layout layout;
  layout.scale = scale;
  layout.size = size;
  const float w = static_cast<float>(size.x), h = static_cast<float>(size.y);
  const float panel = 248 * scale, column = 372 * scale,
              gauge = renderers <= 0 ? 0.0f : (106 + kGaugeRow * static_cast<float>(renderers)) * scale,
              bar = renderers == 0 && h >= 200 * scale ? 46 * scale : 0.0f;
  const float sceneLeast = 300 * scale;
  // Without room for both, the panel is shown: it has the controls.
  const bool showPanel = panels && w >= panel + sceneLeast;
  const bool showCharts = charts && w >= column + sceneLeast + (showPanel ? panel : 0.0f) && h >= 420 * scale;
  const float left = showPanel ? panel : 0.0f, right = showCharts ? column : 0.0f;
  layout.panel = {0, 0, left, h};
  layout.scene = {left, 0, w - left - right, h - bar};
  if (bar > 0) layout.bar = {left + 24 * scale, h - bar, std::max(0.0f, layout.scene.width - 48 * scale), bar};
  layout.charts = {w - right, 0, right, showCharts ? h - gauge : 0};
  layout.gauge = {w - right, h - gauge, right, showCharts ? gauge : 0};
  // The torques need more room: six lines and a legend.
  const float unit = layout.charts.height / 3.2f, heights[] = {unit, unit, 1.2f * unit};
  float y = 0;
  for (std::size_t i = 0; i < kCharts; ++i) {
    layout.chart[i] = {layout.charts.x, y, right, heights[i]};
    y += heights[i];
  }
  const float side = std::min({236 * scale, 0.5f * layout.scene.width, 0.45f * h});
  if (side > 170 * scale)  // a smaller one has no room for its text

    layout.inset = {layout.scene.x + layout.scene.width - side - 14 * scale, layout.scene.height - side - 14 * scale,
                    side, side};
  return layout;
}

Layout layOutSplit(const glm::ivec2& size, float scale, bool panels, bool tour) {
  Layout layout;
  layout.scale = scale;
  layout.size = size;
  const float w = static_cast<float>(size.x), h = static_cast<float>(size.y);
  const float panel = panels && w >= (248 + 2 * 300) * scale ? 248 * scale : 0.0f;
  // In small windows, comparison and insets give their room to the scenes.
  const float compare = h >= 420 * scale ? std::clamp(0.29f * h, 150 * scale, 230 * scale) : 0.0f;
  const float text = tour ? 64 * scale : 0.0f, upper = h - compare - text;
  const float inset = upper >= 260 * scale ? 0.6f * upper : 0.0f, scene = upper - inset;
  const float half = 0.5f * (w - panel);
  layout.panel = {0, 0, panel, h};
  layout.tour = {panel, 0, w - panel, text};
  layout.scene = {panel, text, half, scene};
  layout.right = {panel + half, text, half, scene};
  if (inset > 0) {
    layout.inset = {panel, text + scene, half, inset};
    layout.rightInset = {panel + half, text + scene, half, inset};
  }
  layout.compare = {panel, h - compare, w - panel, compare};
  return layout;
}

}  // namespace enamel::viewer
