// The split screen: two tools under one hand, their comparison, and the tour.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"
#include "tour.hpp"

namespace enamel::viewer {

namespace {

// Two axes: the horizontal one begins at 0, the vertical one at `low`, at most 0.
struct Plot {
  Rect area;
  double low, right, top;
  ImVec2 at(double x, double y) const {
    return {area.x + area.width * static_cast<float>(x / right),
            area.y + area.height * static_cast<float>((top - y) / (top - low))};
  }
};

// Return the smallest 1, 2 or 5 times a power of ten that reaches `far` in five steps.
double stepFor(double far) {
  const double raw = 0.2 * far, power = std::pow(10.0, std::floor(std::log10(raw)));
  return power * (raw <= power ? 1.0 : raw <= 2.0 * power ? 2.0 : raw <= 5.0 * power ? 5.0 : 10.0);
}

// Return the first multiple of a step that is not below a value.
double endFor(double value, double least) {
  const double far = std::max(1.04 * value, least), step = stepFor(far);
  return step * std::ceil(far / step - 1e-9);
}

void drawAxes(const Plot& plot, const char* name, const Brush& brush) {
  const float s = brush.s;
  const Rect& a = plot.area;
  brush.text(gFonts.bold, a.x - 34 * s, a.y - 24 * s, kInk, name);
  const double step = stepFor(plot.top);
  for (int i = static_cast<int>(std::ceil(plot.low / step)); i * step <= plot.top * (1 + 1e-9); ++i) {
    const float y = plot.at(0.0, i * step).y;
    brush.list->AddLine({a.x, y}, {a.x + a.width, y}, ink(i == 0 ? kCubeLine : kLine), s);
    brush.textRight(gFonts.small, a.x - 6 * s, y - 8 * s, kMuted, format("%g", i * step));
  }
}

void drawLine(const std::vector<ImVec2>& points, unsigned rgb, const Brush& brush) {
  for (std::size_t i = 1; i < points.size(); ++i)  // single lines: a polyline fails at turns by 180 degrees
    brush.list->AddLine(points[i - 1], points[i], ink(rgb), 1.8f * brush.s);
}

void drawDepths(const Rect& area, const OverlayInput& input, const Brush& brush) {
  const Comparison& both = input.comparison;
  constexpr double window = Comparison::History::kBins * Comparison::History::kBinTicks * kPeriod;  // s
  float largest = 0.0f;
  for (std::size_t side = 0; side < 2; ++side)
    for (int bin = 0; bin < Comparison::History::kBins; ++bin) largest = std::max(largest, both.depth(side, bin).high);
  const Plot plot{area, 0.0, window, endFor(1e3 * static_cast<double>(largest), 0.05)};
  drawAxes(plot, "Depth, mm", brush);
  const std::string from = format("-%g s", window);
  brush.text(gFonts.small, area.x, area.y + area.height + 3 * brush.s, kMuted, from);
  brush.textRight(gFonts.small, area.x + area.width, area.y + area.height + 3 * brush.s, kMuted, "now");
  for (const std::size_t side : {1u, 0u}) {
    std::vector<ImVec2> points;
    for (int bin = 0; bin < Comparison::History::kBins; ++bin) {
      const auto& range = both.depth(side, bin);
      const double time = window * (bin + 0.5) / Comparison::History::kBins;
      points.push_back(plot.at(time, 1e3 * static_cast<double>(range.low)));
      if (range.high > range.low) points.push_back(plot.at(time, 1e3 * static_cast<double>(range.high)));
    }
    drawLine(points, sideColour(input, side), brush);
  }
}

void drawCurves(const Rect& area, const OverlayInput& input, const Brush& brush) {
  const Comparison& both = input.comparison;
  float lowest = 0.0f;
  for (std::size_t side = 0; side < 2; ++side)
    for (const Comparison::Point& point : both.curve(side)) lowest = std::min(lowest, point.force);
  const double deepest = 1e3 * std::max(both.deepest(0), both.deepest(1));
  Plot plot{area, 0.0, endFor(deepest, 0.05), endFor(std::max(both.strongest(0), both.strongest(1)), 5.0)};
  if (lowest < -0.05f * static_cast<float>(plot.top)) plot.low = 1.05 * static_cast<double>(lowest);
  drawAxes(plot, "Force over depth, N", brush);
  const double step = stepFor(plot.right);
  for (int i = 0; i * step <= plot.right * (1 + 1e-9); ++i) {
    const float x = plot.at(i * step, 0.0).x;
    const std::string text = format(i * step > 0.999 * plot.right ? "%g mm" : "%g", i * step);
    brush.list->AddLine({x, area.y}, {x, area.y + area.height}, ink(kLine), brush.s);
    brush.text(gFonts.small, x - 0.5f * Brush::width(gFonts.small, text), area.y + area.height + 3 * brush.s, kMuted,
               text);
  }
  brush.list->PushClipRect({area.x - 1, area.y}, {area.x + area.width, area.y + area.height + 1}, true);
  for (const std::size_t side : {1u, 0u}) {
    std::vector<ImVec2> points;
    for (const Comparison::Point& p : both.curve(side))
      points.push_back(plot.at(1e3 * std::max(0.0, static_cast<double>(p.depth)), static_cast<double>(p.force)));
    drawLine(points, sideColour(input, side), brush);
  }
  brush.list->PopClipRect();
}

std::string timesText(const Comparison::Ratio& ratio) {
  const bool above = ratio.atLeast || ratio.times > 9999.0;
  return std::string(above ? "> " : "") +
         format(ratio.times >= 9.95 ? "%.0f\u00d7" : "%.1f\u00d7", std::min(ratio.times, 9999.0));
}

// Draw the ratio of the two depths.
void drawRatio(const Rect& area, const OverlayInput& input, const Brush& brush) {
  const float s = brush.s, x = area.x;
  const Comparison& both = input.comparison;
  const Frame* const frames[] = {&input.left.frame, &input.right->frame};
  const auto titled = [&](float y, std::size_t side, const char* before) {
    const float at = x + Brush::width(gFonts.text, before);
    brush.text(gFonts.text, x, y, kInk, before);
    brush.list->AddCircleFilled({at + 5 * s, y + 9 * s}, 5 * s, ink(sideColour(input, side)));
    brush.text(gFonts.bold, at + 15 * s, y, kInk, titleOf(input, indexOf(frames[side]->selected)));
  };
  const std::optional<Comparison::Ratio> ratio = both.ratio();
  float y = area.y + 10 * s;
  if (!ratio) {
    brush.text(gFonts.bold, x, y, kInk, "Which one is stiffer?");
    brush.text(gFonts.text, x, y + 24 * s, kMuted, "Press both into the wall with");
    brush.text(gFonts.text, x, y + 43 * s, kMuted, "1 N or more, or P: test push.");
    return;
  }
  titled(y, ratio->deeper, "");
  brush.text(gFonts.text, x, y + 18 * s, kMuted, "sinks");
  brush.text(gFonts.huge, x, y + 28 * s, kInk, timesText(*ratio));
  titled(y + 82 * s, 1 - ratio->deeper, "as deep as ");
  y += 103 * s;
  const auto depth = [&](std::size_t side) {
    return both.deepest(side) < Comparison::kLeast ? format("< %g", 1e3 * Comparison::kLeast)
                                                   : format("%.3f", 1e3 * both.deepest(side));
  };
  brush.text(gFonts.small, x, y, kMuted,
             format("deepest of this press: %s and %s mm", depth(0).c_str(), depth(1).c_str()));
  const TestPush* tests[2];
  for (std::size_t i = 0; i < 2; ++i) tests[i] = &frames[i]->tests[indexOf(frames[i]->selected)];
  if (!tests[0]->made && !tests[1]->made) return;
  const auto result = [](const TestPush& test) {
    return test.verdict == FirstImpactVerdict::measured ? stiffnessText(test.stiffness)
           : test.made                                  ? verdictText(test)
                                                        : std::string("not measured");
  };
  brush.text(gFonts.small, x, y + 17 * s, kMuted,
             format("perceived: %s and %s", result(*tests[0]).c_str(), result(*tests[1]).c_str()));
}

// Draw the position of a pane's tool, and the motors' force on it as delivered.
void drawForces(const Rect& inset, const Frame& frame, const Brush& brush) {
  const float s = brush.s, x = inset.x + 10 * s, wall = inset.y + kWallShare * inset.height;
  const Delivered force = deliveredOf(frame.record);
  const double depth = -1e3 * frame.record.nearest.gap;
  const std::pair<const char*, std::string> rows[] = {
      {depth > -0.0005 ? "depth" : "to the wall",
       format(std::abs(depth) < 10.0 ? "%.3f mm" : "%.1f mm", std::abs(depth))},
      {"normal", tenths(force.normal) + " N"},
      {"tangential", tenths(force.tangential) + " N"},
      {"total", tenths(force.total) + " N"}};
  float y = inset.y + 28 * s;
  const float right = x + std::min(134 * s, 0.5f * inset.width - 50 * s);
  for (const auto& [name, value] : rows) {
    if (y + 15 * s > wall) break;  // as many rows as fit above the wall
    brush.text(gFonts.small, x, y, kMuted, name);
    brush.textRight(gFonts.small, right, y, kInk, value);
    y += 17 * s;
  }
}

// Draw the comparison below the panes: depths, curves and ratio.
void drawComparison(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const Rect& a = layout.compare;
  brush.list->AddLine({layout.right.x, 0}, {layout.right.x, a.y}, ink(kCubeLine), 2 * s);
  if (a.height <= 0) return;
  brush.list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kPaper));
  brush.list->AddLine({a.x, a.y}, {a.x + a.width, a.y}, ink(kCubeLine), 2 * s);
  const float ratio = std::min(250 * s, 0.4f * a.width), top = a.y + 34 * s, high = a.height - 34 * s - 26 * s;
  const float plots = a.width - ratio - 14 * s;
  const float share = plots >= 480 * s ? 0.5f : 1.0f;  // without room: one plot only
  drawDepths({a.x + 48 * s, top, share * plots - 74 * s, high}, input, brush);
  if (share < 1.0f) drawCurves({a.x + share * plots + 48 * s, top, share * plots - 80 * s, high}, input, brush);
  drawRatio({a.x + a.width - ratio, a.y, ratio, a.height}, input, brush);
}

}  // namespace

// Draw the text and the progress of the tour between the tools, above the scale bars of the insets.
void drawTour(const Layout& layout, double time, const Brush& brush) {
  const float s = layout.scale, whole = 2 * layout.scene.width, pad = 14 * s, high = 76 * s;
  const std::size_t part = Tour::part(time);
  const Tour::Words& words = Tour::words(part);
  const float wide = std::max(Brush::width(gFonts.text, words.sentence), 320 * s) + 2 * pad;
  const Rect& above = layout.inset.width > 0 ? layout.inset : layout.scene;
  const float x = layout.scene.x + 0.5f * (whole - wide), left = x + pad, right = x + wide - pad;
  const float y = std::max(0.0f, above.y + above.height - 38 * s - high);
  brush.list->AddRectFilled({x, y}, {x + wide, y + high}, ink(kInk, 0.93), 8 * s);
  brush.text(gFonts.large, left, y + 6 * s, 0xFFFFFF, words.title);
  brush.textRight(gFonts.small, right, y + 15 * s, kLine, format("%zu of %zu   Esc: skip", part + 1, Tour::kParts));
  brush.text(gFonts.text, left, y + 40 * s, 0xFFFFFF, words.sentence);
  const float done = (right - left) * static_cast<float>(std::min(1.0, time / Tour::kLength));
  brush.list->AddRectFilled({left, y + 66 * s}, {right, y + 69 * s}, ink(kMuted));
  brush.list->AddRectFilled({left, y + 66 * s}, {left + done, y + 69 * s}, ink(0xFFFFFF));
}

void drawSplitScreen(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  static const std::vector<Vec3> noTrail;
  const float s = layout.scale;
  const std::tuple<const Rect&, const Rect&, const ToolInput&, unsigned> panes[] = {
      {layout.scene, layout.inset, input.left, sideColour(input, 0)},
      {layout.right, layout.rightInset, *input.right, sideColour(input, 1)}};
  for (const auto& [scene, inset, tool, colour] : panes) {
    const Frame& frame = tool.frame;
    if (inset.width > 0) {
      drawInset({inset, tool, noTrail, true, colour}, input.scene.toolRadius, state, brush);
      drawForces(inset, frame, brush);
    }
    const std::string title = titleOf(input, indexOf(frame.selected));
    const float x = scene.x + 14 * s, y = scene.y + 10 * s, right = scene.x + scene.width - 14 * s;
    brush.list->PushClipRect({scene.x, scene.y}, {scene.x + scene.width, scene.y + scene.height}, true);
    brush.clear(x, y, Brush::width(gFonts.large, title) + 24 * s, 32 * s);
    brush.list->AddCircleFilled({x + 8 * s, y + 16 * s}, 8 * s, ink(colour));
    brush.text(gFonts.large, x + 24 * s, y + 1 * s, kInk, title);
    drawNames(scene, {{scene.x, scene.y, scene.width, 62 * s}}, input.camera, frame, true, brush);
    drawStatus(right, y, input, frame, brush);
    drawBadges(right, y + 32 * s, frame, brush);
    brush.list->PopClipRect();
  }
  drawComparison(layout, input, brush);
}

}  // namespace enamel::viewer
