#include "study/figures.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/figure_parts.hpp"
#include "study/numbers.hpp"

namespace enamel::app {
namespace {

// ---- the impedance wall's stability (RQ 2) -------------------------------------------------------------------------

Figure stabilityFigure(const Study& study) {
  const WallDevice device = wallDeviceOf(study);
  constexpr int kColumns = 62, kRows = 40, kDelays = 4;
  constexpr const char *kStable = "#9cc9e6", *kUnstable = "#f0b27a";
  Axis kAxis{"rendered stiffness K (kN/m)", 0.5, 100.0, true}, bAxis{"rendered damping B (N s/m)", 0.1, 100.0, true};
  // Return the edges and centres of `count` cells, alternating.
  const auto edges = [](const Axis& axis, int count) {
    std::vector<double> at;
    for (int i = 0; i <= 2 * count; ++i) at.push_back(axis.low * std::pow(axis.high / axis.low, 0.5 * i / count));
    return at;
  };
  const std::vector<double> kEdges = edges(kAxis, kColumns), bEdges = edges(bAxis, kRows);
  std::vector<double> stiffnesses, dampings;
  for (int i = 0; i < kColumns; ++i) stiffnesses.push_back(1e3 * kEdges[static_cast<std::size_t>(2 * i + 1)]);
  for (int i = 0; i < kRows; ++i) dampings.push_back(bEdges[static_cast<std::size_t>(2 * i + 1)]);
  const std::vector<WallStability> map = mapWallStability(device, stiffnesses, dampings, {0, 1, 2, 3});
  Svg svg;
  constexpr double kLeft = 66.0, kWide = 345.0, kHigh = 220.0;
  addLegend(svg, {kLeft, 0.0}, Svg::kWidth,
            {{"stable", {kStable}, true}, {"unstable", {kUnstable}, true}, {"bound of eq. 16", {kInk, 2.5}}});
  std::vector<std::string> stiffest;
  for (int delay = 0; delay < kDelays; ++delay) {
    const int column = delay % 2, row = delay / 2;
    kAxis.numbers = row == 1;
    bAxis.numbers = column == 0;
    const Place corner{kLeft + column * (kWide + 30.0), 52.0 + row * (kHigh + 34.0)};
    Panel panel(svg, corner, kWide, kHigh, kAxis, bAxis,
                delay == 0   ? "no delay"
                : delay == 1 ? "1 tick of delay"
                             : fmt::format("{} ticks of delay", delay),
                false);
    svg.box(corner, kWide, kHigh, kUnstable, "", fmt::format("stroke=\"{}\"", kMuted));
    svg.openGroup("shape-rendering=\"crispEdges\"");
    int i = 0;
    double begin = 0.0, most = 0.0;  // of the stable cells: start of the current run in a row; largest K
    for (const WallStability& w : map) {
      if (w.wall.delay != delay) continue;
      const int k = i % kColumns, b = i / kColumns;
      ++i;
      if (w.stable) most = std::max(most, 1e-3 * w.wall.stiffness);
      if (w.stable && (k == 0 || begin == 0.0)) begin = kEdges[static_cast<std::size_t>(2 * k)];
      const bool ends = k + 1 == kColumns;
      if (begin > 0.0 && (!w.stable || ends)) {
        const Place from = panel.at(begin, bEdges[static_cast<std::size_t>(2 * b + 2)]),
                    to = panel.at(kEdges[static_cast<std::size_t>(2 * k + (w.stable ? 2 : 0))],
                                  bEdges[static_cast<std::size_t>(2 * b)]);
        svg.box(from, to.x - from.x, to.y - from.y, kStable);
        begin = 0.0;
      }
    }
    svg.closeGroup();
    stiffest.push_back(most > 0.0 ? numberText(most, 2) : "none");
    // Bound of eq. 16: b = K Ts / 2 + B.
    std::vector<double> ks, bs;
    for (int s = 0; s <= 200; ++s) {
      const double b = bAxis.low * std::pow(device.damping / bAxis.low, s / 200.0);
      bs.push_back(b);
      ks.push_back(1e-3 * 2.0 * (device.damping - b) / device.period);
    }
    panel.curve(ks, bs, {kInk, 2.5});
  }
  return {
      "impedance-stability", svg.whole("stability of a spring-damper wall", 52.0 + 2.0 * kHigh + 34.0 + 46.0),
      fmt::format(
          "Stability of a wall that is rendered as a spring K with a damper B on this device. In simulation, the "
          "motion after a push of 12 N decays within 3 s (effective mass {} kg, mechanical damping {} N s/m, ticks of "
          "{} ms). Walls left of and below the bound of eq. 16 are passive. More walls are stable than eq. 16 allows, "
          "but delay, which eq. 16 ignores, makes them fewer: the largest stable K is {} kN/m at 0, 1, 2 and 3 ticks.",
          numberText(device.mass), givenText(device.damping), givenText(1e3 * device.period), join(stiffest, ", "))};
}

// ---- speed against error -------------------------------------------------------------------------------------------

Figure convergenceFigure(const Convergence& c) {
  const struct {
    Integrator integrator;
    const char* colour;
  } shown[] = {
      {Integrator::semiImplicitEuler, kVermilion}, {Integrator::midpoint, kOrange}, {Integrator::rungeKutta4, kBlue}};
  Extent time, metric, path;
  const auto drawn = [](const MethodError& m) { return std::isfinite(m.worst) && m.worst > 0.0 && m.trajectory > 0.0; };
  for (const MethodError& m : c.methods) {
    if (!drawn(m)) continue;
    time.see(1e3 * m.secondsPerSecond);
    metric.see(m.worst);
    path.see(m.trajectory);
  }
  metric.see(c.allowed);
  Svg svg;
  constexpr double kWide = 300.0, kHigh = 270.0, kLefts[] = {80.0, 490.0};
  std::vector<LegendEntry> entries;
  for (const auto& s : shown) entries.push_back({nameOf(s.integrator), {s.colour, 2.0}});
  const double top = addLegend(svg, {kLefts[0], 0.0}, Svg::kWidth, entries) + 8.0;
  const Axis x = time.axis("processor time (ms per simulated s)", 0.12, true);
  Panel left(svg, {kLefts[0], top}, kWide, kHigh, x, metric.axis("largest relative error of a metric", 0.08, true)),
      right(svg, {kLefts[1], top}, kWide, kHigh, x, path.axis("largest error of position (m)", 0.08, true));
  left.level(c.allowed, {kInk, 1.2, true});
  for (const auto& s : shown) {
    std::vector<double> times, metrics, paths;
    for (const MethodError& m : c.methods) {
      if (m.method.integrator != s.integrator || !drawn(m)) continue;
      times.push_back(1e3 * m.secondsPerSecond);
      metrics.push_back(m.worst);
      paths.push_back(m.trajectory);
    }
    left.curve(times, metrics, {s.colour, 1.6}, true);
    right.curve(times, paths, {s.colour, 1.6}, true);
  }
  return {
      "convergence", svg.whole("speed against error", top + kHigh + 46.0),
      fmt::format(
          "Speed against error of the integration: 1, 2, 4 and 8 steps a tick from left to right, against {} with {} "
          "steps; a method that misses an event is not drawn. Dashed: the allowed error, {} %. The best method is the "
          "fastest below this line.",
          nameOf(c.reference.integrator), c.reference.substeps, givenText(100.0 * c.allowed))};
}

}  // namespace

WallDevice wallDeviceOf(const Study& study) {
  const std::size_t spring = study.column(ColumnKind::impedance);
  const double damping = study.labels[spring < study.labels.size() ? spring : 0].damping;
  const Kinematics& home = study.mechanism->home();
  return {effectiveMass(home, home.pose.position, Vec3::UnitZ()), damping, study.plan.setup.period};
}

std::string colourOf(const Study& study, std::size_t column) {
  switch (study.labels[column].kind) {
    case ColumnKind::positionControl: return kBlue;
    case ColumnKind::hold: return kGreen;
    case ColumnKind::impedance: return kVermilion;
    case ColumnKind::passivity: return kMuted;
    case ColumnKind::scheduled: return kOrange;
    case ColumnKind::edge:
    case ColumnKind::rival:
    case ColumnKind::plugin: break;
  }
  const char* const others[] = {kPurple, kSky, kBrown, kInk};
  std::size_t before = 0;
  for (std::size_t c = 0; c < column; ++c) before += study.labels[c].kind >= ColumnKind::edge;
  return others[before % std::size(others)];
}

std::string join(const std::vector<std::string>& parts, const std::string& between) {
  std::string all;
  for (const std::string& part : parts) all += (all.empty() ? "" : between) + part;
  return all;
}

std::vector<Figure> figuresOf(const Study& study, const Findings& findings) {
  std::vector<Figure> figures;
  if (findings.whole) {
    const std::vector<int>& scenarios = study.plan.scenarios;
    figures.push_back(deviceFigure(study));
    for (const int scenario : scenarios) figures.push_back(responseFigure(study, scenario));
    if (std::count(scenarios.begin(), scenarios.end(), 1) > 0) figures.push_back(firstImpactMap(study, findings));
    if (study.plan.grid > 1) figures.push_back(alongYFigure(study, findings));
    if (study.column(ColumnKind::hold) < study.plan.columns.size()) figures.push_back(torqueFigure(study));
    for (const int scenario : scenarios) figures.push_back(steadyMap(study, findings, scenario));
    if (wallDeviceOf(study).damping > 0.0) figures.push_back(stabilityFigure(study));
  }
  if (findings.convergence) figures.push_back(convergenceFigure(*findings.convergence));
  return figures;
}

}  // namespace enamel::app
