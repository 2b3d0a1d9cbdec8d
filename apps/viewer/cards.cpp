// Cards over the scene: the bar of a recording, the bur, the timing, the help.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

// What the bur does, and what it has taken away.
namespace {
constexpr float kDrillRow = 20.0f;
}  // namespace

Area drillCard(const Layout& layout, const OverlayInput& input) {
  if (input.bur == nullptr) return {};
  const float s = layout.scale, rows = static_cast<float>(input.layers->size());
  return {layout.scene.x + 18 * s, layout.scene.y + 76 * s, 186 * s, (80 + kDrillRow * rows) * s};
}

void drawBar(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const Player& player = *input.player;
  const float s = layout.scale;
  const Area& bar = layout.bar;
  const auto place = [&](std::uint64_t position) {
    return bar.x + bar.width * static_cast<float>(static_cast<double>(position) /
                                                  std::max(1.0, static_cast<double>(player.size() - 1)));
  };
  const float top = bar.y + 14 * s, bottom = top + 8 * s;
  brush.list->AddRectFilled({layout.scene.x, bar.y}, {layout.scene.x + layout.scene.width, bar.y + bar.height},
                            ink(kPaper));
  brush.list->AddRectFilled({bar.x, top}, {bar.x + bar.width, bottom}, ink(kLine));
  // Never thinner than a line, at most one a pixel: an hour has 28000 chunks.
  float contacts = -1.0f, gaps = -1.0f, acts = -1.0f;  // where the last marks end
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
      format("%s%.3f of %.3f s   tick %llu   %g x", player.playing() ? "" : "paused   ", input.simulated,
             static_cast<double>(player.size() - 1) * player.header().guard.period,
             static_cast<unsigned long long>(input.frame.record.tick), player.speed());
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

void drawDrill(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const Drilled& drilled = input.frame.drilled;
  const Area card = drillCard(layout, input);
  brush.card(card, 0.88);
  const float x = card.x + 12 * s, right = card.x + card.width - 12 * s;
  float y = card.y + 8 * s;
  brush.list->AddCircleFilled({x + 5 * s, y + 9 * s}, 5 * s, ink(drilled.spins ? kInk : kMuted));
  brush.text(gFonts.bold, x + 16 * s, y, kInk, "Bur");
  brush.textRight(gFonts.text, right, y, kMuted, drilled.spins ? format("%.0f turns/s", input.bur->turns) : "at rest");
  const auto line = [&](const char* name, const std::string& value) {
    y += kDrillRow * s;
    brush.text(gFonts.text, x + 16 * s, y, kMuted, name);
    brush.textRight(gFonts.bold, right, y, kInk, value);
  };
  line("depth", format("%.2f mm", 1e3 * input.burDepth));
  line("feed", format("%.2f mm/s", 1e3 * std::max(0.0, drilled.feed)));
  y += 4 * s;
  for (std::size_t i = 0; i < input.layers->size(); ++i) {
    line((*input.layers)[i].name.c_str(), format("%.2f mm\u00b3", 1e9 * std::max(0.0, drilled.removed[i])));
    brush.list->AddRectFilled({x, y + 4 * s}, {x + 10 * s, y + 14 * s}, ink(layerColour(static_cast<int>(i))), 2 * s);
    brush.list->AddRect({x, y + 4 * s}, {x + 10 * s, y + 14 * s}, ink(kEnamelEdge), 2 * s);
  }
}

namespace {

// Shares of the ticks over a logarithmic scale; the highest class fills the height, and any that has ticks is seen.
void drawHistogram(const Area& area, const std::array<float, TimingNumbers::kClasses>& shares, const Brush& brush) {
  const float s = brush.s, bottom = area.y + area.height, each = area.width / static_cast<float>(shares.size());
  const float highest = std::max(1e-9f, *std::max_element(shares.begin(), shares.end()));
  for (std::size_t i = 0; i < shares.size(); ++i)
    if (const float left = area.x + static_cast<float>(i) * each; shares[i] > 0.0f)
      brush.list->AddRectFilled({left, bottom - std::max(2 * s, shares[i] / highest * area.height)},
                                {left + std::max(1.0f, each - s), bottom}, ink(kChosen));
  brush.list->AddLine({area.x, bottom}, {area.x + area.width, bottom}, ink(kMuted), s);
  constexpr const char* decades[] = {"1 \u00b5s", "10 \u00b5s", "100 \u00b5s", "1 ms", "10 ms"};
  const float decade = 4.0f * std::log2(10.0f) * each;
  for (int i = 0; i < 5; ++i) {
    const float x = area.x + static_cast<float>(i) * decade, wide = Brush::width(gFonts.small, decades[i]);
    brush.list->AddLine({x, bottom}, {x, bottom + 4 * s}, ink(kMuted), s);
    brush.text(gFonts.small, std::clamp(x - 0.5f * wide, area.x, area.x + area.width - wide), bottom + 4 * s, kMuted,
               decades[i]);
  }
}

// How often the guard acted, the most frequent reasons first: ticks of a run, acts of a recording.
std::vector<std::string> guardLines(const OverlayInput& input) {
  std::array<std::uint64_t, kGuardReasons> counts = input.frame.guardTicks;
  if (input.player != nullptr)
    for (const PlayerEvent& event : input.player->events()) ++counts[static_cast<std::size_t>(event.reason)];
  std::vector<std::size_t> reasons;
  for (std::size_t i = 1; i < counts.size(); ++i)
    if (counts[i] > 0) reasons.push_back(i);
  std::stable_sort(reasons.begin(), reasons.end(), [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  constexpr std::size_t most = 4;
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < std::min(most, reasons.size()); ++i)
    lines.push_back(format("guard: %s, %llu %s", toString(static_cast<GuardReason>(reasons[i])),
                           static_cast<unsigned long long>(counts[reasons[i]]),
                           input.player != nullptr ? "times" : "ticks"));
  if (reasons.size() > most) lines.push_back(format("guard: %zu more reasons", reasons.size() - most));
  if (lines.empty()) lines.push_back("guard: let everything through");
  return lines;
}

}  // namespace

void drawTiming(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const TimingNumbers& t = input.timing;
  const std::vector<std::string> guard = guardLines(input);
  constexpr float row = 20, histogram = 34, scale = 22;
  const float high = 16 + row * static_cast<float>(guard.size() + (t.available ? 5 : 1)) +
                     (t.available ? 2 * (histogram + scale) : 0.0f);
  const Area above = drillCard(layout, input);
  const Area card{layout.scene.x + 18 * s, layout.scene.y + 76 * s + (above.height > 0 ? above.height + 8 * s : 0.0f),
                  std::min(316 * s, layout.scene.width - 36 * s), high * s};
  brush.card(card, 0.94);
  const float x = card.x + 12 * s;
  float y = card.y + 8 * s;
  const auto line = [&](const std::string& text, unsigned colour = kInk) {
    brush.text(gFonts.text, x, y, colour, text);
    y += row * s;
  };
  const auto shares = [&](const auto& of) {
    drawHistogram({x, y, card.width - 24 * s, histogram * s}, of, brush);
    y += (histogram + scale) * s;
  };
  if (t.available) {
    line(format("haptic loop 1 kHz, %s", t.realtime ? "real-time class" : "normal class"));
    line(format("from tick to tick  median late %.0f \u00b5s, p99.9 %.0f", 1e6 * t.wakeMedian, 1e6 * t.wakeHigh));
    shares(t.interval);
    line(format("computing a tick  median %.1f \u00b5s, p99.9 %.1f", 1e6 * t.computeMedian, 1e6 * t.computeHigh));
    shares(t.compute);
    line(format("missed %llu of %llu ticks", t.missed, t.missed + t.periods), t.missed > 0 ? kWrong : kInk);
    line(format("%.0f pictures/s", t.framesPerSecond));
  } else {
    line(input.player != nullptr ? "a recording: no haptic thread" : "simulated time: no haptic thread");
  }
  for (const std::string& text : guard) line(text, input.frame.record.guard != GuardReason::none ? kWrong : kInk);
}

// What is being made of what one sees.
void drawMaking(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  float y = layout.scene.y + 14 * s;
  for (const auto& [name, seconds] : {std::pair("recording", input.recording), {"clip", input.clip}}) {
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

void drawHelp(const Layout& layout, bool recording, const Brush& brush) {
  std::vector<HelpRow> help;
  const auto add = [&](const auto& row) {
    if (row.source == Source::both || (row.source == Source::recording) == recording)
      help.push_back({row.keys, row.meaning});
  };
  for (const HelpRow& row : drivingRows()) add(row);
  for (const ActionRow& row : actionRows()) add(row);
  const std::size_t all = help.size(), left = all / 2;
  const float rows = static_cast<float>(all - left);
  const float w = static_cast<float>(layout.size.x), h = static_cast<float>(layout.size.y);
  // Smaller where the window is too small for it.
  const float fit = std::min({1.0f, w / (740 * layout.scale), h / ((76 + 23 * rows) * layout.scale)});
  const float s = layout.scale * fit, wide = 720 * s, high = (66 + 23 * rows) * s;
  const Area card{0.5f * (w - wide), 0.5f * (h - high), wide, high};
  const auto text = [&](ImFont* font, float x, float y, unsigned rgb, const char* words) {
    brush.list->AddText(font, fit * font->FontSize, {std::round(x), std::round(y)}, ink(rgb), words);
  };
  brush.list->AddRectFilled({0, 0}, {w, h}, ink(kInk, 0.25));
  brush.card(card, 1.0);
  text(gFonts.large, card.x + 20 * s, card.y + 12 * s, kInk,
       recording ? "Look at a recording" : "Push the tool against the wall");
  for (std::size_t i = 0; i < all; ++i) {
    const bool second = i >= left;
    const float x = card.x + 20 * s + (second ? 0.53f * wide : 0.0f);
    const float y = card.y + (52 + 23 * static_cast<float>(second ? i - left : i)) * s;
    text(gFonts.bold, x, y, kInk, help[i].keys);
    text(gFonts.text, x + 92 * s, y, kMuted, help[i].meaning);
  }
}
}  // namespace enamel::viewer
