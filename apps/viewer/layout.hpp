// Positions of the parts of the picture.
#pragma once

#include <algorithm>
#include <array>
#include <glm/glm.hpp>

namespace enamel::viewer {

inline constexpr int kCharts = 3;

/// A rectangle in pixels from the top left.
struct Rect {
  float x = 0, y = 0, width = 0, height = 0;
};

/// Positions of all parts. layOut(): for a size and a scale; `renderers` is their number in the gauge. -1: a connected
/// device, 0: a recording, with a time bar and no gauge.
struct Layout {
  float scale = 1.0f;
  glm::ivec2 size{0};
  Rect panel, scene, charts, inset, gauge, bar;  ///< width 0: not shown; bar: the time bar from end to end
  std::array<Rect, kCharts> chart;               ///< each with room for its title
  /// Split screen: `scene` and `inset` belong to the left pane; charts and gauge are not shown.
  Rect right, rightInset, compare, tour;  ///< tour: its text, above both panes
  bool isSplit() const { return right.width > 0; }
};
Layout layOut(const glm::ivec2& size, float scale, bool panels, bool charts, int renderers = 4);
/// Lay out the split screen: in each pane the scene above the magnified contact, and the comparison below both panes.
Layout layOutSplit(const glm::ivec2& size, float scale, bool panels, bool tour = false);
/// Split screen: position of the wall's line in an inset, relative to its height; length of a step of its ruler,
/// pixels.
inline constexpr float kWallShare = 0.32f;
inline float rulerStep(const Layout& layout) {
  return std::min(40.0f * layout.scale, (1.0f - kWallShare) * layout.inset.height / 4.3f);
}
inline constexpr float kChartTitle = 28.0f;  // units of layout, above each chart
inline constexpr float kGaugeRow = 21.0f;    // height of a renderer's row in the gauge

}  // namespace enamel::viewer
