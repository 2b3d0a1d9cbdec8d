// The parts of the overlay, one file each.
#pragma once

#include <cctype>

#include "brush.hpp"
#include "colours/renderers.hpp"
#include "overlay_input.hpp"

namespace enamel::viewer {

/// Return the colour of a renderer's slot.
constexpr unsigned slotColour(std::size_t slot) {
  return slot < kLinkedRenderers ? kRendererLooks[slot].colour : kOtherLooks[0].colour;
}
/// Return the colour of a tool in the split screen: that of its renderer, or another one if both have the same.
inline unsigned sideColour(const OverlayInput& input, std::size_t side) {
  const std::size_t left = indexOf(input.left.frame.selected), right = indexOf(input.right->frame.selected);
  return side == 0 ? slotColour(left) : left == right ? kReference : slotColour(right);
}

/// Return whether a slot holds a plugin, as an additional renderer or instead of a linked one.
inline bool isPlugin(const OverlayInput& input, std::size_t slot) {
  return input.device.plugin != nullptr && indexOf(slotOf(*input.device.plugin)) == slot;
}
inline std::size_t rendererCount(const OverlayInput& input) {
  return isPlugin(input, indexOf(RendererSlot::plugin)) ? kMaxRenderers : kLinkedRenderers;
}
/// Return the title of a slot. A plugin never gets the title of the linked renderer that it replaces.
inline std::string titleOf(const OverlayInput& input, std::size_t slot) {
  if (isPlugin(input, slot)) return format("Plugin %s", input.device.plugin->description().name);
  std::string title = kRendererLooks[slot].title;
  title[0] = static_cast<char>(std::toupper(title[0]));
  return title;
}

/// Return the values that the read-outs show: smoothed, but those of one tick in pause and slow motion.
inline const Readout shownOf(const OverlayInput& input, const Frame& frame) {
  return input.showsTick() ? readoutOf(frame.record) : frame.readout;
}

/// Return what the guard does, in words.
std::string guardText(GuardReason reason);

/// Format a depth for people: "0.042 mm", "3.82 mm".
std::string depthText(double metres);

/// Format a stiffness for people: "27.1 kN/m". The next function formats a test push: its stiffness or its verdict.
std::string stiffnessText(double stiffness);
std::string shownText(const TestPush& test);
/// Return why a test push has no stiffness.
std::string verdictText(const TestPush& test);

/// names.cpp: names beside hand and tool, where `scene` has room outside of `taken`.
void drawNames(const Rect& scene, const std::vector<Rect>& taken, const Camera& camera, const Frame& frame, bool hand,
               const Brush& brush);

/// tips.cpp: tips for read-outs under the mouse.
void drawTips(const Layout& layout, const OverlayInput& input, OverlayState& state);

/// panel.cpp.
void drawPanel(const Layout& layout, const OverlayInput& input, OverlayState& state);

/// badges.cpp: state of the tool in one word; problems, each in its own badge from the right; recordings in the middle.
void drawStatus(float right, float y, const OverlayInput& input, const Frame& frame, const Brush& brush);
/// Return the problems in the order of their badges.
std::array<std::pair<bool, const char*>, 4> badgesOf(const Frame& frame);
void drawBadges(float right, float y, const Frame& frame, const Brush& brush);
void drawRecordingPills(const Layout& layout, const OverlayInput& input, const Brush& brush);

/// inset.cpp: inputs of an inset.
struct InsetView {
  const Layout& layout;
  const Rect& area;
  const OverlayInput& input;
  const ToolInput& tool;
  const std::vector<Vec3>& trail;
  bool isSplit;     // one of two panes: with a fixed scale, and a title that names the renderer
  unsigned colour;  // of the tool
  double deepest;   // in this press, m
};
/// Draw the magnified contacts, seen along the walls. The deepest contact's wall is always below and the tool above.
void drawInset(const InsetView& view, OverlayState& state, const Brush& brush);

/// gauge.cpp: titles of the charts and stiffnesses of the test pushes, beside the scene.
void drawChartTitles(const Layout& layout, const OverlayInput& input, const Brush& brush);
void drawGauge(const Layout& layout, const OverlayInput& input, const OverlayState& state, const Brush& brush);

/// split_screen.cpp: the split screen and its tour.
void drawSplitScreen(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush);
void drawTour(const Layout& layout, double time, const Brush& brush);

/// readouts.cpp, over the scene: depth and forces; the bur and the removed volumes; timing and guard.
inline constexpr float kNumberRow = 46.0f, kNumberTitle = 20.0f;  // units of layout
Rect numbersBox(const Layout& layout, const OverlayInput& input);
void drawNumbers(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush);
Rect drillBox(const Layout& layout, const OverlayInput& input);  ///< width 0: not shown
void drawDrill(const Layout& layout, const OverlayInput& input, const Brush& brush);
void drawTiming(const Layout& layout, const OverlayInput& input, const Brush& brush);

/// time_bar.cpp: of a recording.
void drawTimeBar(const Layout& layout, const OverlayInput& input, const Brush& brush);

/// help.cpp: over everything. `source`: of the frame; both: a connected device.
void drawHelp(const Layout& layout, Source source, const Brush& brush);

}  // namespace enamel::viewer
