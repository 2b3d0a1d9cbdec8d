// Badges over the scene: state of the tool, problems, and recordings.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

std::string guardText(GuardReason reason) {
  switch (reason) {
    case GuardReason::engaging: return "force fades in";
    case GuardReason::slew: return "torque changes too fast";
    case GuardReason::brake: return "brakes the fast tool";
    case GuardReason::unreachable: return "the device cannot have this pose";
    case GuardReason::energy: return "the wall gave energy";
    case GuardReason::oscillation: return "the tool vibrates";
    default: return toString(reason);
  }
}

// Draw the state of the tool as one word.
void drawStatus(float right, float y, const OverlayInput& input, const Frame& frame, const Brush& brush) {
  const float s = brush.s;
  const Player* const player = input.player;
  const bool contact = frame.record.nearest.gap <= 0.0 || frame.record.mode == RenderMode::contact;
  std::string chip = contact ? "contact" : "free";
  unsigned fill = contact ? kForce : kMuted;
  if (frame.testing) chip = "test push", fill = kChosen;
  if (frame.record.status != Status::ok) chip = "no valid command", fill = kInk;
  if (frame.record.guard != GuardReason::none)
    chip = (isFault(frame.record.guard) ? "stopped: " : "guard: ") + guardText(frame.record.guard) +
           (!isFault(frame.record.guard) || player != nullptr ? ""
            : input.live != nullptr                           ? "; Backspace continues"
                                                              : "; select it again"),
    fill = kInk;
  if (player != nullptr && player->gap() > 0)
    chip = format("%llu ticks missing here", static_cast<unsigned long long>(player->gap())), fill = kInk;
  if (frame.plant != Status::ok) chip = "stopped: left the workspace", fill = kInk;
  const float chipWidth = Brush::width(gFonts.bold, chip) + 20 * s;
  brush.list->AddRectFilled({right - chipWidth, y}, {right, y + 24 * s}, ink(fill), 12 * s);
  brush.text(gFonts.bold, right - chipWidth + 10 * s, y + 4 * s, 0xFFFFFF, chip);
}

// Return all problems. Each has its own badge, starting from the right.
std::array<std::pair<bool, const char*>, 4> badgesOf(const Frame& frame) {
  const Conditions& c = frame.conditions;
  return {
      {{c.unstable, "unstable"}, {c.saturated, "saturated"}, {c.slipped, "slipped"}, {c.edge, "edge of workspace"}}};
}

void drawBadges(float right, float y, const Frame& frame, const Brush& brush) {
  const float s = brush.s;
  for (const auto& [on, name] : badgesOf(frame)) {
    if (!on) continue;
    const float wide = Brush::width(gFonts.small, name) + 16 * s;
    brush.list->AddRectFilled({right - wide, y}, {right, y + 20 * s}, ink(kInk), 10 * s);
    brush.text(gFonts.small, right - wide + 8 * s, y + 3 * s, 0xFFFFFF, name);
    right -= wide + 6 * s;
  }
}

void drawRecordingPills(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  float y = layout.scene.y + 14 * s;
  for (const auto& [name, seconds] : {std::pair("recording", input.elapsed.recording), {"clip", input.elapsed.clip}}) {
    if (seconds < 0.0) continue;
    const std::string text = format("%s  %.1f s", name, seconds);
    const float wide = Brush::width(gFonts.text, text) + 34 * s;
    const float x = layout.scene.x + 0.5f * (layout.scene.width - wide);
    brush.list->AddRectFilled({x, y}, {x + wide, y + 24 * s}, ink(0xFFFFFF), 12 * s);
    brush.list->AddCircleFilled({x + 14 * s, y + 12 * s}, 5 * s, ink(kWrong));
    brush.text(gFonts.text, x + 25 * s, y + 4 * s, kInk, text);
    y += 28 * s;
  }
}

}  // namespace enamel::viewer
