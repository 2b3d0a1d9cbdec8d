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

// Draw the ratio of the two depths of the test pushes. The same push gives the same numbers every time.
void drawRatio(const Rect& area, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  const float s = brush.s, x = area.x;
  const Frame* const frames[] = {&input.left.frame, &input.right->frame};
  const TestPush* tests[2];
  for (std::size_t i = 0; i < 2; ++i) tests[i] = &frames[i]->tests[indexOf(frames[i]->selected)];
  const auto titled = [&](float y, std::size_t side, const char* before) {
    const float at = x + Brush::width(gFonts.text, before);
    brush.text(gFonts.text, x, y, kInk, before);
    brush.list->AddCircleFilled({at + 5 * s, y + 9 * s}, 5 * s, ink(sideColour(input, side)));
    brush.text(gFonts.bold, at + 15 * s, y, kInk, titleOf(input, indexOf(frames[side]->selected)));
  };
  float y = area.y + 10 * s;
  const std::optional<DepthRatio> ratio = ratioOf(*tests[0], *tests[1]);
  if (!ratio) {
    brush.text(gFonts.bold, x, y, kInk, "Which one is stiffer?");
    brush.text(gFonts.text, x, y + 24 * s, kMuted, "P pushes both with the same 12 N.");
    for (std::size_t i = 0; i < 2; ++i)
      if (tests[i]->made) {
        titled(y + (54 + 42 * static_cast<float>(i)) * s, i, "");
        brush.text(gFonts.text, x + 15 * s, y + (73 + 42 * static_cast<float>(i)) * s, kMuted, shownText(*tests[i]));
      }
    return;
  }
  const std::string times =
      (ratio->atLeast ? "> " : "") + format(ratio->times >= 9.95 ? "%.0f\u00d7" : "%.1f\u00d7", ratio->times);
  titled(y, ratio->deeper, "");
  brush.text(gFonts.text, x, y + 18 * s, kMuted, "sinks");
  brush.text(gFonts.huge, x, y + 28 * s, kInk, times);
  titled(y + 82 * s, 1 - ratio->deeper, "as deep as ");
  y += 103 * s;
  const std::string depths = format("test push of 12 N: %s and %s", depthText(tests[0]->deepest).c_str(),
                                    depthText(tests[1]->deepest).c_str());
  brush.text(gFonts.small, x, y, kMuted, depths);
  brush.text(gFonts.small, x, y + 17 * s, kMuted,
             format("perceived K_z1: %s and %s", shownText(*tests[0]).c_str(), shownText(*tests[1]).c_str()));
  state.readouts.push_back(times + "; " + depths);
}

// Draw in words how deep a pane's tool sank in this press, then the motors' force on it now.
void drawWords(const Rect& inset, double deepest, const Delivered& force, OverlayState& state, const Brush& brush) {
  const float s = brush.s, x = inset.x + 12 * s, wall = inset.y + kWallShare * inset.height;
  const std::string words = "sank " + depthText(deepest);
  brush.text(gFonts.large, x, inset.y + 4 * s, kInk, words);
  const std::string when = "at most in this press";
  const float after = x + Brush::width(gFonts.large, words) + 8 * s;
  if (after + Brush::width(gFonts.small, when) < inset.x + inset.width)
    brush.text(gFonts.small, after, inset.y + 13 * s, kMuted, when);
  state.readouts.push_back(words);
  const std::pair<const char*, double> rows[] = {
      {"force now, normal", force.normal}, {"tangential", force.tangential}, {"total", force.total}};
  float y = inset.y + 36 * s;
  for (const auto& [name, value] : rows) {
    if (y + 15 * s > wall) break;  // as many rows as fit above the wall
    brush.text(gFonts.small, x, y, kMuted, name);
    brush.textRight(gFonts.small, x + 152 * s, y, kInk, tenths(value) + " N");
    y += 17 * s;
  }
}

// Draw the comparison below the panes: depths, curves and ratio.
void drawComparison(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  const float s = layout.scale;
  const Rect& a = layout.compare;
  brush.list->AddLine({layout.right.x, layout.right.y}, {layout.right.x, a.y}, ink(kCubeLine), 2 * s);
  if (a.height <= 0) return;
  brush.list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kPaper));
  brush.list->AddLine({a.x, a.y}, {a.x + a.width, a.y}, ink(kCubeLine), 2 * s);
  const float ratio = std::min(250 * s, 0.4f * a.width), top = a.y + 34 * s, high = a.height - 34 * s - 26 * s;
  const float plots = a.width - ratio - 14 * s;
  const float share = plots >= 480 * s ? 0.5f : 1.0f;  // without room: one plot only
  drawDepths({a.x + 48 * s, top, share * plots - 74 * s, high}, input, brush);
  if (share < 1.0f) drawCurves({a.x + share * plots + 48 * s, top, share * plots - 80 * s, high}, input, brush);
  drawRatio({a.x + a.width - ratio, a.y, ratio, a.height}, input, state, brush);
}

}  // namespace

// Draw the text and the progress of the tour above both panes.
void drawTour(const Layout& layout, double time, const Brush& brush) {
  const float s = layout.scale;
  const Rect& a = layout.tour;
  const std::size_t part = Tour::part(time);
  const Tour::Words& words = Tour::words(part);
  const float left = a.x + 18 * s, right = a.x + a.width - 18 * s, title = Brush::width(gFonts.large, words.title);
  brush.list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kInk));
  brush.text(gFonts.large, left, a.y + 6 * s, 0xFFFFFF, words.title);
  brush.textRight(gFonts.small, right, a.y + 8 * s, kLine, format("%zu of %zu", part + 1, Tour::kParts));
  brush.textRight(gFonts.small, right, a.y + 24 * s, kLine, "Esc: skip");
  const char* const sentence = words.sentence;
  brush.text(gFonts.text, left + (a.width >= 600 * s ? title + 18 * s : 0.0f), a.y + (a.width >= 600 * s ? 13 : 38) * s,
             0xFFFFFF, sentence);
  const float done = (right - left) * static_cast<float>(std::min(1.0, time / Tour::kLength)), y = a.y + 58 * s;
  brush.list->AddRectFilled({left, y}, {right, y + 3 * s}, ink(kMuted));
  brush.list->AddRectFilled({left, y}, {left + done, y + 3 * s}, ink(0xFFFFFF));
}

void drawSplitScreen(const Layout& layout, const OverlayInput& input, OverlayState& state, const Brush& brush) {
  static const std::vector<Vec3> noTrail;
  const float s = layout.scale;
  const std::tuple<const Rect&, const Rect&, const ToolInput&, unsigned> panes[] = {
      {layout.scene, layout.inset, input.left, sideColour(input, 0)},
      {layout.right, layout.rightInset, *input.right, sideColour(input, 1)}};
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& [scene, inset, tool, colour] = panes[side];
    const Frame& frame = tool.frame;
    if (inset.width > 0) {
      drawInset({layout, inset, input, tool, noTrail, true, colour, input.comparison.deepest(side)}, state, brush);
      drawWords(inset, input.comparison.deepest(side), deliveredOf(shownOf(input, frame).force, frame.record.nearest),
                state, brush);
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
  drawComparison(layout, input, state, brush);
}

}  // namespace enamel::viewer
