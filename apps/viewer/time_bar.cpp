// The time bar of a recording, with its contacts and the guard's actions.
#include <imgui.h>

#include <algorithm>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

void drawTimeBar(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const Player& player = *input.player;
  const float s = layout.scale;
  const Rect& bar = layout.bar;
  const auto place = [&](std::uint64_t position) {
    return bar.x + bar.width * static_cast<float>(static_cast<double>(position) /
                                                  std::max(1.0, static_cast<double>(player.size() - 1)));
  };
  const float top = bar.y + 14 * s, bottom = top + 8 * s;
  brush.list->AddRectFilled({layout.scene.x, bar.y}, {layout.scene.x + layout.scene.width, bar.y + bar.height},
                            ink(kPaper));
  brush.list->AddRectFilled({bar.x, top}, {bar.x + bar.width, bottom}, ink(kLine));
  // Draw marks at least as wide as a line, and at most one per pixel: an hour has 28000 chunks.
  float contacts = -1.0f, gaps = -1.0f, acts = -1.0f;  // ends of the last marks
  const auto mark = [&](float& drawn, std::uint64_t from, std::uint64_t to, float up, unsigned colour) {
    const float end = std::max(place(to), place(from) + 1.5f * s);
    if (end < drawn + 1.0f) return;
    brush.list->AddRectFilled({place(from) < drawn + 1.0f ? drawn : place(from), top - up}, {end, bottom}, ink(colour));
    drawn = end;
  };
  const auto& stretches = player.stretches();
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    if (stretches[i].contact) mark(contacts, stretches[i].begin, stretches[i].end, 0.0f, kForce);
    if (i > 0 && stretches[i].begin > stretches[i - 1].end)
      mark(gaps, stretches[i - 1].end, stretches[i].begin, 4 * s, kInk);
  }
  for (const PlayerEvent& event : player.events())
    if (event.reason != GuardReason::none) mark(acts, event.position, event.position, 6 * s, kWrong);
  const float now = place(player.position());
  brush.list->AddLine({now, bar.y + 5 * s}, {now, bottom + 4 * s}, ink(kBlue), 2 * s);
  brush.list->AddCircleFilled({now, 0.5f * (top + bottom)}, 6 * s, ink(kBlue));

  const std::string time =
      format("%s%.3f of %.3f s   tick %llu   %g x", player.playing() ? "" : "paused   ", input.elapsed.simulated,
             static_cast<double>(player.size() - 1) * player.header().guard.period,
             static_cast<unsigned long long>(input.left.frame.record.tick), player.speed());
  const float y = bottom + 6 * s, right = bar.x + bar.width - Brush::width(gFonts.small, time);
  brush.text(gFonts.small, right, y, kInk, time);
  float x = bar.x;
  const auto key = [&](unsigned colour, const char* name) {
    if (x + Brush::width(gFonts.small, name) + 24 * s > right) return;
    brush.list->AddRectFilled({x, y + 5 * s}, {x + 10 * s, y + 11 * s}, ink(colour));
    brush.text(gFonts.small, x + 14 * s, y, kMuted, name);
    x += Brush::width(gFonts.small, name) + 30 * s;
  };
  key(kForce, "contact");
  key(kWrong, "guard");
  key(kInk, "missing");
}

}  // namespace enamel::viewer
