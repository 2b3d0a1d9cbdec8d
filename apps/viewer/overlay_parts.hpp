// The parts of the overlay, a file each.
#pragma once

#include "brush.hpp"
#include "overlay_input.hpp"

namespace enamel::viewer {

inline constexpr unsigned kSlotColour[kMaxRenderers] = {kBlue, kPurple, kSky, kGreen, 0x8C6BB1};
inline constexpr unsigned kSideColour[] = {kBlue, kPurple};  // of the split screen
inline constexpr const char* kLinkedTitle[kLinkedRenderers] = {"Position control", "Spring", "Hold (paper)",
                                                               "Passive spring"};

/// Of the renderers that can be chosen, where a plugin stands among them or in the place of a linked one.
inline bool isPlugin(const OverlayInput& input, std::size_t slot) {
  return input.device.plugin != nullptr && indexOf(slotOf(*input.device.plugin)) == slot;
}
inline std::size_t rendererCount(const OverlayInput& input) {
  return isPlugin(input, indexOf(RendererSlot::plugin)) ? kMaxRenderers : kLinkedRenderers;
}
/// Never the title of the linked renderer that a plugin stands for.
inline std::string titleOf(const OverlayInput& input, std::size_t slot) {
  return isPlugin(input, slot) ? format("Plugin %s", input.device.plugin->description().name) : kLinkedTitle[slot];
}

/// Of the hand, into the nearest wall, N.
double handForce(const Frame& frame);

/// A stiffness as people read it: "27.1 kN/m". What a test push gave: that, or why it gave none.
std::string stiffnessText(double stiffness);
std::string shownText(const TestPush& test);
/// Why a test push gave no stiffness.
std::string verdictText(const TestPush& test);

/// names.cpp: what hand and tool are, beside them, where there is room in `scene` outside of `taken`.
void drawNames(const Rect& scene, const std::vector<Rect>& taken, const Camera& camera, const Frame& frame, bool hand,
               const Brush& brush);

/// tips.cpp: what the mouse is on, among what is only read.
void drawTips(const Layout& layout, const OverlayInput& input, OverlayState& state);

/// panel.cpp.
void drawPanel(const Layout& layout, const OverlayInput& input, OverlayState& state);

/// badges.cpp: what the tool is doing, in a word, and what is wrong, each in its pill, from the right; what is being
/// recorded, in the middle.
void drawStatus(float right, float y, const OverlayInput& input, const Frame& frame, const Brush& brush);
/// What is wrong, in the order of their pills.
std::array<std::pair<bool, const char*>, 4> badgesOf(const Frame& frame);
void drawBadges(float right, float y, const Frame& frame, const Brush& brush);
void drawRecordingPills(const Layout& layout, const OverlayInput& input, const Brush& brush);

/// Where the wall's line stands in an inset of the split screen, share of its height.
inline constexpr float kWallShare = 0.45f;

/// inset.cpp: what an inset shows.
struct InsetView {
  const Rect& area;
  const ToolInput& tool;
  const std::vector<Vec3>& trail;
  bool isSplit;     // one of two panes: at one fixed scale, and its head says whose it is
  unsigned colour;  // of the tool
};
/// The contacts, seen along the walls, magnified: the deepest one's wall below, the tool above, whatever the normal.
void drawInset(const InsetView& view, double toolRadius, OverlayState& state, const Brush& brush);

/// gauge.cpp: beside the scene, the charts' titles and the stiffnesses of the test pushes.
void drawChartTitles(const Layout& layout, const OverlayInput& input, const Brush& brush);
void drawGauge(const Layout& layout, const OverlayInput& input, const OverlayState& state, const Brush& brush);

/// split_screen.cpp: the split screen and its tour.
void drawSplitScreen(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush);
void drawTour(const Layout& layout, double time, const Brush& brush);

/// readouts.cpp: over the scene, what the bur does and has taken away, timing and guard.
Rect drillBox(const Layout& layout, const OverlayInput& input);  ///< width 0: not shown
void drawDrill(const Layout& layout, const OverlayInput& input, const Brush& brush);
void drawTiming(const Layout& layout, const OverlayInput& input, const Brush& brush);

/// time_bar.cpp: of a recording.
void drawTimeBar(const Layout& layout, const OverlayInput& input, const Brush& brush);

/// help.cpp: over everything.
void drawHelp(const Layout& layout, bool recording, const Brush& brush);

}  // namespace enamel::viewer
