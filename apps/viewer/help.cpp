// The help with all keys.
#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

void drawHelp(const Layout& layout, Source source, const Brush& brush) {
  std::vector<HelpRow> help;
  const auto add = [&](const auto& row) {
    if (row.source == Source::both || row.source == source || (row.source == Source::timed && source != Source::both))
      help.push_back({row.keys, row.meaning});
  };
  for (const HelpRow& row : drivingRows()) add(row);
  for (const ActionRow& row : actionRows()) add(row);
  const std::size_t all = help.size(), left = all / 2;
  const float rows = static_cast<float>(all - left);
  const float w = static_cast<float>(layout.size.x), h = static_cast<float>(layout.size.y);
  // Shrink it in small windows.
  const float fit = std::min({1.0f, w / (740 * layout.scale), h / ((76 + 23 * rows) * layout.scale)});
  const float s = layout.scale * fit, wide = 720 * s, high = (66 + 23 * rows) * s;
  const Rect card{0.5f * (w - wide), 0.5f * (h - high), wide, high};
  const auto text = [&](ImFont* font, float x, float y, unsigned rgb, const char* words) {
    brush.list->AddText(font, fit * font->FontSize, {std::round(x), std::round(y)}, ink(rgb), words);
  };
  brush.list->AddRectFilled({0, 0}, {w, h}, ink(kInk, 0.25));
  brush.box(card, 1.0);
  text(gFonts.large, card.x + 20 * s, card.y + 12 * s, kInk,
       source == Source::recording ? "Play a recording" : "Push the tool against the wall");
  for (std::size_t i = 0; i < all; ++i) {
    const bool second = i >= left;
    const float x = card.x + 20 * s + (second ? 0.53f * wide : 0.0f);
    const float y = card.y + (52 + 23 * static_cast<float>(second ? i - left : i)) * s;
    text(gFonts.bold, x, y, kInk, help[i].keys);
    text(gFonts.text, x + 92 * s, y, kMuted, help[i].meaning);
  }
}

}  // namespace enamel::viewer
