// Where the parts of the picture stand.
#pragma once

#include <array>
#include <glm/glm.hpp>

namespace enamel::viewer {

inline constexpr int kCharts = 3;

/// A rectangle, pixels from the top left.
struct Rect {
  float x = 0, y = 0, width = 0, height = 0;
};

/// Where everything stands; layOut(): at a size and a scale, with so many renderers in the gauge; 0: of a recording,
/// with a time bar and no gauge.
struct Layout {
  float scale = 1.0f;
  glm::ivec2 size{0};
  Rect panel, scene, charts, inset, gauge, bar;  ///< width 0: not shown; bar: of time, from end to end
  std::array<Rect, kCharts> chart;               ///< each with room for its title
  /// Of the split screen, where `scene` and `inset` are those of the left pane, and there are no charts and no gauge.
  Rect right, rightInset, compare;
  bool isSplit() const { return right.width > 0; }
};
Layout layOut(const glm::ivec2& size, float scale, bool panels, bool charts, int renderers = 4);
/// The split screen: two panes with a scene above and the magnified contact below, and what compares them below both.
Layout layOutSplit(const glm::ivec2& size, float scale, bool panels);
inline constexpr float kChartTitle = 28.0f;  // units of layout, above each chart
inline constexpr float kGaugeRow = 21.0f;    // a renderer in the gauge

}  // namespace enamel::viewer
