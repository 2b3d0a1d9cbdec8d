// Read-outs over the scene: the bur, the loop's timing and the guard.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

namespace {

constexpr float kDrillRow = 20.0f;

// Return what the forces are.
std::string forcesText(const Frame& frame, const Delivered& force, float room) {
  if (isFault(frame.record.guard)) return "stopped by the guard";
  const std::string across = tenths(force.tangential), total = tenths(force.total);
  const std::string forces = format("normal; tangential %s N, total %s N", across.c_str(), total.c_str());
  return Brush::width(gFonts.small, forces) <= room ? forces
                                                    : format("tang. %s, total %s N", across.c_str(), total.c_str());
}

}  // namespace

Rect numbersBox(const Layout& layout, const OverlayInput& input) {
  const float s = layout.scale, high = ((input.knowsHand() ? 4 : 2) * kNumberRow + kNumberTitle) * s;
  return {layout.scene.x, layout.scene.y + layout.scene.height - high - 14 * s, 260 * s, high};
}

void drawNumbers(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  const float s = layout.scale;
  const Frame& frame = input.left.frame;
  const Rect box = numbersBox(layout, input);
  const Readout shown = shownOf(input, frame);
  struct Number {
    std::string value;
    const char* unit;
    std::string name;
    unsigned colour;
  };
  const Delivered force = deliveredOf(shown.force, frame.record.nearest);
  const double depth = 1e3 * shown.depth, now = shown.hand / std::max(1e-9, shown.depth);
  const bool inside = depth > 1e-3 && shown.hand >= 0.1;  // for smaller values the ratio means nothing
  // Beside the inset, as far as there is room.
  const float room = layout.inset.width > 0 ? layout.inset.x - box.x - 36 * s : layout.scene.width;
  const Number numbers[] = {
      {format(std::abs(depth) < 0.1 || depth > 0.0 ? "%.3f" : "%.1f", std::abs(depth)), "mm",
       depth > -0.0005 ? "penetration" : "to the wall", kDepth},
      {tenths(force.normal), "N", forcesText(frame, force, room), kForce},
      {tenths(shown.hand), "N", "force of the hand", kHand},
      {!inside     ? "-"
       : now < 1e6 ? format("%.1f", 1e-3 * now)
                   : "> 1000",
       "kN/m", "hand force / depth now", kInk},
  };
  const int count = input.knowsHand() ? 4 : 2;
  const float x = box.x + 18 * s;
  float y = box.y;
  const std::string title = input.showsTick() ? "in this tick" : "smoothed over 0.1 s";
  float wide = Brush::width(gFonts.small, title);
  for (int i = 0; i < count; ++i) wide = std::max(wide, 12 * s + Brush::width(gFonts.small, numbers[i].name));
  brush.clear(x, y - 3 * s, wide, box.height + 12 * s);
  brush.text(gFonts.small, x, y, kMuted, title);
  state.readouts.push_back(title);
  y += kNumberTitle * s;
  for (int i = 0; i < count; ++i) {
    const Number& n = numbers[i];
    brush.list->AddRectFilled({x, y + 3 * s}, {x + 3 * s, y + 38 * s}, ink(n.colour));
    brush.text(gFonts.large, x + 12 * s, y, kInk, n.value);
    brush.text(gFonts.text, x + 18 * s + Brush::width(gFonts.large, n.value), y + 8 * s, kMuted, n.unit);
    brush.text(gFonts.small, x + 12 * s, y + 27 * s, kMuted, n.name);
    state.readouts.push_back(n.value + " " + n.unit + ": " + n.name);
    y += kNumberRow * s;
  }
}

Rect drillBox(const Layout& layout, const OverlayInput& input) {
  if (!input.bur) return {};
  const float s = layout.scale, rows = static_cast<float>(input.bur->layers.size());
  return {layout.scene.x + 18 * s, layout.scene.y + 76 * s, 186 * s, (80 + kDrillRow * rows) * s};
}

void drawDrill(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const DrillState& drilled = input.left.frame.drilled;
  const Rect card = drillBox(layout, input);
  brush.box(card, 0.88);
  const float x = card.x + 12 * s, right = card.x + card.width - 12 * s;
  float y = card.y + 8 * s;
  brush.list->AddCircleFilled({x + 5 * s, y + 9 * s}, 5 * s, ink(drilled.spins ? kInk : kMuted));
  brush.text(gFonts.bold, x + 16 * s, y, kInk, "Bur");
  brush.textRight(gFonts.text, right, y, kMuted,
                  drilled.turns > 0.0 ? format("%.0f 1/min", 60.0 * drilled.turns)
                  : drilled.spins     ? "stalled"
                                      : "at rest");
  const auto line = [&](const char* name, const std::string& value) {
    y += kDrillRow * s;
    brush.text(gFonts.text, x + 16 * s, y, kMuted, name);
    brush.textRight(gFonts.bold, right, y, kInk, value);
  };
  line("depth", format("%.2f mm", 1e3 * input.bur->depth));
  line("feed", format("%.2f mm/s", 1e3 * std::max(0.0, drilled.feed)));
  y += 4 * s;
  for (std::size_t i = 0; i < input.bur->layers.size(); ++i) {
    const std::string& name = input.bur->layers[i].name;
    line(name.c_str(), format("%.2f mm\u00b3", 1e9 * std::max(0.0, drilled.removed[i])));
    brush.list->AddRectFilled({x, y + 4 * s}, {x + 10 * s, y + 14 * s}, ink(layerColour(name, i)), 2 * s);
    brush.list->AddRect({x, y + 4 * s}, {x + 10 * s, y + 14 * s}, ink(kEnamelEdge), 2 * s);
  }
}

namespace {

// Draw the shares of ticks over a logarithmic scale. The highest class fills the height; every class with ticks is
// visible.
void drawHistogram(const Rect& area, const std::array<float, TimingNumbers::kClasses>& shares, const Brush& brush) {
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

// Return how often the guard acted, most frequent reasons first: ticks in a run, events in a recording.
std::vector<std::string> guardLines(const OverlayInput& input) {
  std::array<std::uint64_t, kGuardReasons> counts = input.left.frame.guardTicks;
  if (input.player != nullptr)
    for (const PlayerEvent& event : input.player->events()) ++counts[static_cast<std::size_t>(event.reason)];
  std::vector<std::size_t> reasons;
  for (std::size_t i = 1; i < counts.size(); ++i)
    if (counts[i] > 0) reasons.push_back(i);
  std::stable_sort(reasons.begin(), reasons.end(), [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  constexpr std::size_t most = 4;
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < std::min(most, reasons.size()); ++i)
    lines.push_back(format("guard: %s, %llu %s", guardText(static_cast<GuardReason>(reasons[i])).c_str(),
                           static_cast<unsigned long long>(counts[reasons[i]]),
                           input.player != nullptr ? "times" : "ticks"));
  if (reasons.size() > most) lines.push_back(format("guard: %zu more reasons", reasons.size() - most));
  if (lines.empty()) lines.push_back("guard: no events");
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
  const Rect above = drillBox(layout, input);
  const Rect card{layout.scene.x + 18 * s, layout.scene.y + 76 * s + (above.height > 0 ? above.height + 8 * s : 0.0f),
                  std::min(316 * s, layout.scene.width - 36 * s), high * s};
  brush.box(card, 0.94);
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
    line(format("from tick to tick  median delay %.0f \u00b5s, p99.9 %.0f", 1e6 * t.wakeMedian, 1e6 * t.wakeHigh));
    shares(t.interval);
    line(format("computing a tick  median %.1f \u00b5s, p99.9 %.1f", 1e6 * t.computeMedian, 1e6 * t.computeHigh));
    shares(t.compute);
    const bool isPolled = input.live != nullptr && input.live->isPolled();
    line(format("missed %llu of %llu %s", t.missed, t.missed + t.periods, isPolled ? "polls" : "ticks"),
         t.missed > 0 ? kWrong : kInk);
    line(format("%.0f pictures/s", t.framesPerSecond));
  } else {
    line(input.player != nullptr ? "a recording: no haptic thread" : "simulated time: no haptic thread");
  }
  for (const std::string& text : guard) line(text, input.left.frame.record.guard != GuardReason::none ? kWrong : kInk);
}

}  // namespace enamel::viewer
