// Explanations of the read-outs under the mouse.
#include <imgui.h>

#include <algorithm>

#include "overlay_parts.hpp"
#include "widgets.hpp"

namespace enamel::viewer {
namespace {

bool has(const Rect& area, const ImVec2& at) {
  return at.x >= area.x && at.x < area.x + area.width && at.y >= area.y && at.y < area.y + area.height;
}

constexpr const char* kNumberTip[] = {
    "Depth of the tool's lowest point in the nearest wall, or its distance, mm, along the wall's normal.",
    ("Force of the motors on the tool, N, as delivered in this tick, without the part that carries its weight. Shown "
     "along the wall's normal (negative: it pulls into the wall), along the wall, and in total."),
    "Force of the hand into the wall, N.\nforce = grip x (hand - tool) - damping x speed",
    "Stiffness that the hand feels now, kN/m. Only while the tool is in the wall.\nforce of the hand / penetration"};
constexpr const char* kChartTip[] = {
    "Penetration of the last 3 s, mm: each column shows the smallest and the largest of 12 ticks.",
    "Force of the motors along the wall's normal, N, as delivered. Dashed: the limit of the motors there.",
    "Torques of the joints as delivered, with the motors' limits (dashed)."};
constexpr const char* kGaugeTip =
    "The stiffness of the first impact of a test push (P), from 1 kN/m to 1 MN/m. Grey: impossible here for any "
    "renderer without a force sensor, at this delay.\nK_z1 = force of the step / depth at the first return";
constexpr const char* kInsetTip =
    "The contact, magnified. The wall is always below and the tool above; the scale in mm or \u00b5m is at the left. "
    "Numbers: depths of all contacts that touch, deepest first, mm. Orange red: force of the motors, N. Orange: force "
    "of "
    "the hand, N.";
constexpr const char* kDrillTip =
    "Depth of the bur's tip below the uncut surface, mm. Feed: its speed into the material, mm/s. Then the removed "
    "volume "
    "of each layer, mm\u00b3.";
constexpr const char* kTimeTip =
    "Time of the recording, s. Drag the mark to any time. Orange red: contact. Dark red: the guard acted. Dark: ticks "
    "are "
    "missing.";
constexpr const char* kStatusTip =
    "contact: the tool touches a wall. free: it does not. stopped: the guard has switched the motors off, with the "
    "reason. "
    "guard: it limits the force in this tick.";
constexpr const char* kCompareTip[] = {
    "Depths of both tools over the last 3 s, mm.",
    "Force of the motors over the depth of the last press: a steeper curve is a stiffer wall.",
    ("Ratio of the largest depths of the two tools in the last test push (P), a step of 12 N from rest. A depth below "
     "2 \u00b5m counts as 2 \u00b5m, so the ratio is then a lower bound.")};
constexpr const char* kBadgeTip =
    "saturated: a motor is at its limit. unstable: torques alternate by more than a quarter of their limits. slipped: "
    "the tool slid 0.2 mm on a wall with friction. edge of workspace: the tool is at a mechanical stop.";

}  // namespace

void drawTips(const Layout& layout, const OverlayInput& input, OverlayState& state) {
  const ImVec2 at = ImGui::GetIO().MousePos;
  if (ImGui::GetIO().WantCaptureMouse || state.help || input.elapsed.tour >= 0.0 || ImGui::IsMouseDown(0) ||
      ImGui::IsMouseDown(1))
    return;
  const float s = layout.scale;
  const Rect& scene = layout.scene;
  const auto onInset = [&](const Rect& inset) { return inset.width > 0 && has(inset, at); };
  if (onInset(layout.inset) || onInset(layout.rightInset)) return showTip(state, kInsetTip);
  if (layout.isSplit()) {
    if (!has(layout.compare, at)) return;
    const float share = (at.x - layout.compare.x) / layout.compare.width;
    return showTip(state, kCompareTip[share < 0.37f ? 0 : share < 0.75f ? 1 : 2]);
  }
  for (std::size_t i = 0; i < kCharts; ++i)
    if (layout.charts.width > 0 && has(layout.chart[i], at)) return showTip(state, kChartTip[i]);
  if (layout.gauge.width > 0 && has(layout.gauge, at)) return showTip(state, kGaugeTip);
  if (input.bur && has(drillBox(layout, input), at)) return showTip(state, kDrillTip);
  if (layout.bar.width > 0 && has(layout.bar, at)) return showTip(state, kTimeTip);
  if (has({scene.x + scene.width - 140 * s, scene.y + 16 * s, 122 * s, 24 * s}, at)) return showTip(state, kStatusTip);
  const Rect numbers = numbersBox(layout, input);
  const float top = numbers.y + kNumberTitle * s;
  if (has({scene.x + 18 * s, top, 150 * s, numbers.height - kNumberTitle * s}, at))
    return showTip(state, kNumberTip[static_cast<std::size_t>((at.y - top) / (kNumberRow * s))]);
  const auto badges = badgesOf(input.left.frame);
  const bool any = std::any_of(badges.begin(), badges.end(), [](const auto& badge) { return badge.first; });
  if (any && has({scene.x + scene.width - 240 * s, scene.y + 72 * s, 222 * s, 22 * s}, at)) showTip(state, kBadgeTip);
}

}  // namespace enamel::viewer
