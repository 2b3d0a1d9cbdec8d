// Titles of the charts, and stiffnesses measured by test pushes.
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "colours/palette.hpp"
#include "overlay_parts.hpp"

namespace enamel::viewer {

std::string depthText(double metres) {
  return metres < 2e-6 ? "< 0.002 mm" : format(metres < 0.0995e-3 ? "%.3f mm" : "%.2f mm", 1e3 * metres);
}

std::string stiffnessText(double stiffness) {
  if (stiffness >= 999.5e3) return format("%.2f MN/m", 1e-6 * stiffness);
  if (stiffness >= 99.95e3) return format("%.0f kN/m", 1e-3 * stiffness);
  if (stiffness >= 9.995e3) return format("%.1f kN/m", 1e-3 * stiffness);
  return format("%.2f kN/m", 1e-3 * stiffness);
}

std::string shownText(const TestPush& test) {
  return test.verdict == FirstImpactVerdict::measured ? stiffnessText(test.stiffness) : verdictText(test);
}

void drawChartTitles(const Layout& layout, const OverlayInput& input, const Brush& brush) {
  const float s = layout.scale;
  const TorqueStyle& torques = input.device.torques;
  const std::string limits[] = {"paper's limit 1 mm", format("motors allow %.0f N", input.device.limit.largestForce),
                                torques.shares ? "share of each joint's limit" : format("limit %g N m", torques.limit)};
  const char* names[] = {"Penetration", "Normal force", "Joint torques"};
  for (std::size_t i = 0; i < kCharts; ++i) {
    const Rect& a = layout.chart[i];
    const float x = a.x + 14 * s;
    brush.text(gFonts.bold, x, a.y + 6 * s, kInk, names[i]);
    brush.text(gFonts.small, x + Brush::width(gFonts.bold, names[i]) + 8 * s, a.y + 8 * s, kMuted, limits[i]);
  }
  // Legend of the torques.
  const Rect& a = layout.chart[2];
  float x = a.x + 56 * s;
  const float y = a.y + 34 * s;
  bool dashed = false;
  for (int joint = 0; joint < torques.joints; ++joint) {
    dashed = dashed || torques.dashed(joint);
    if (torques.perChain > 0 ? joint % torques.perChain > 0 : joint >= 3) continue;
    brush.list->AddLine({x, y + 7 * s}, {x + 14 * s, y + 7 * s}, ink(torques.colourOf(joint)), 3 * s);
    brush.text(gFonts.small, x + 18 * s, y, kMuted,
               torques.perChain > 0 ? format("chain %d", joint / torques.perChain + 1) : format("joint %d", joint + 1));
    x += 66 * s;
  }
  if (dashed) brush.text(gFonts.small, x, y, kMuted, torques.perChain > 0 ? "dashed: 2nd joint" : "dashed: joints 4+");
}

std::string verdictText(const TestPush& test) {
  if (test.status != Status::ok && test.status != Status::stopped) return "left the workspace";
  const std::string reason = toString(test.verdict);
  if (test.verdict == FirstImpactVerdict::noStep) return reason + ": no wall";
  if (test.verdict == FirstImpactVerdict::slips) return reason + format(" by %.2g mm", 1e3 * test.amount);
  if (test.verdict != FirstImpactVerdict::unstable) return reason;
  if (test.status == Status::stopped) return reason + ": stopped by the guard";
  return reason + format(": \u00b1%.1f N", test.amount);
}

namespace {

// Return the settings of a test push that have changed since; empty if none has.
std::string conditionsText(const TestPush& test, std::size_t slot, const Settings& now) {
  const Settings& then = test.settings;
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (then.delay.low != now.delay.low || then.delay.high != now.delay.high)
    add(then.delay.low == then.delay.high ? format("delay %d", then.delay.high)
                                          : format("delay %d-%d", then.delay.low, then.delay.high));
  if (then.extraMass != now.extraMass) add(format("+%.0f g", 1e3 * then.extraMass));
  if (then.toolDamping != now.toolDamping) add(format("%.1f N s/m", then.toolDamping));
  if (then.friction != now.friction) add("other friction");
  if (then.noise != now.noise) add(format("tremor %.1f N", then.noise));
  if (then.encoders.quantised != now.encoders.quantised || then.encoders.rates != now.encoders.rates)
    add("other encoders");
  const bool spring = slot == indexOf(RendererSlot::impedance) || slot == indexOf(RendererSlot::passivity);
  if (spring && (then.spring.stiffness != now.spring.stiffness || then.spring.damping != now.spring.damping))
    add(format("spring %.1f kN/m", 1e-3 * then.spring.stiffness));
  if (slot == indexOf(RendererSlot::hold) &&
      (then.hold.release != now.hold.release || then.hold.antiWindup != now.hold.antiWindup))
    add("other hold");
  return text.empty() ? text : "at " + text;
}

}  // namespace

void drawGauge(const Layout& layout, const OverlayInput& input, const OverlayState& state, const Brush& brush) {
  const float s = layout.scale;
  const Rect& a = layout.gauge;
  const float x = a.x + 14 * s, right = a.x + a.width - 14 * s;
  brush.list->AddRectFilled({a.x, a.y}, {a.x + a.width, a.y + a.height}, ink(kPaper));
  brush.list->AddLine({x, a.y}, {right, a.y}, ink(kLine), s);
  brush.text(gFonts.bold, x, a.y + 8 * s, kInk, "Perceived stiffness");
  brush.text(gFonts.small, x + Brush::width(gFonts.bold, "Perceived stiffness") + 8 * s, a.y + 10 * s, kMuted,
             "12 N / first depth");
  float y = a.y + 32 * s;
  for (std::size_t i = 0; i < rendererCount(input); ++i) {
    const TestPush& test = input.left.frame.tests[i];
    const bool active = indexOf(input.left.frame.selected) == i;
    brush.list->AddCircleFilled({x + 5 * s, y + 9 * s}, 5 * s, ink(slotColour(i)));
    brush.text(active ? gFonts.bold : gFonts.text, x + 17 * s, y, kInk, titleOf(input, i));
    if (test.verdict == FirstImpactVerdict::measured) {
      brush.text(gFonts.bold, x + 150 * s, y, kInk, stiffnessText(test.stiffness));
      const std::string then = conditionsText(test, i, state.settings);
      const std::string share = format("%.1f %% of the limit", 100.0 * test.stiffness / test.limit);
      // Shorten the text to the available room, with dots at its end.
      std::string shown = then.empty() ? share : then;
      const float room = right - x - 158 * s - Brush::width(gFonts.bold, stiffnessText(test.stiffness));
      while (shown.size() > 4 && Brush::width(gFonts.text, shown) > room)
        shown = shown.substr(0, shown.size() - 4) + "...";
      brush.textRight(gFonts.text, right, y, kMuted, shown);
    } else {
      brush.text(gFonts.text, x + 150 * s, y, kMuted, test.made ? verdictText(test) : "press P to measure");
    }
    y += kGaugeRow * s;
  }
  // A logarithmic bar from 1 kN/m to 1 MN/m.
  const float bar = y + 30 * s, height = 8 * s;
  const auto place = [&](double stiffness) {
    const double share = std::log10(std::clamp(stiffness, 1e3, 1e6) / 1e3) / 3.0;
    return x + static_cast<float>(share) * (right - x);
  };
  brush.list->AddRectFilled({x, bar}, {right, bar + height}, ink(kLine), 3 * s);
  const float limit = place(input.device.limit.stiffness);
  brush.list->AddRectFilled({limit, bar}, {right, bar + height}, ink(kMuted, 0.55), 3 * s);
  brush.list->AddLine({limit, bar - 6 * s}, {limit, bar + height + 6 * s}, ink(kInk), 2 * s);
  const std::string text = "limit " + stiffnessText(input.device.limit.stiffness);
  const float wide = Brush::width(gFonts.small, text);
  brush.text(gFonts.small, std::min(limit - 0.5f * wide, right - wide), bar - 22 * s, kInk, text);
  constexpr const char* ticks[] = {"1 kN/m", "10", "100", "1 MN/m"};
  for (int i = 0; i < 4; ++i) {
    const float tx = x + static_cast<float>(i) * (right - x) / 3.0f, tw = Brush::width(gFonts.small, ticks[i]);
    brush.list->AddLine({tx, bar + height}, {tx, bar + height + 4 * s}, ink(kMuted), s);
    brush.text(gFonts.small, std::clamp(tx - 0.5f * tw, x, right - tw), bar + height + 6 * s, kMuted, ticks[i]);
  }
  for (std::size_t i = 0; i < rendererCount(input); ++i)
    if (input.left.frame.tests[i].verdict == FirstImpactVerdict::measured) {
      const ImVec2 centre{place(input.left.frame.tests[i].stiffness), bar + 0.5f * height};
      brush.list->AddCircleFilled(centre, 8 * s, ink(0xFFFFFF));
      brush.list->AddCircleFilled(centre, 6.5f * s, ink(slotColour(i)));
    }
}

}  // namespace enamel::viewer
