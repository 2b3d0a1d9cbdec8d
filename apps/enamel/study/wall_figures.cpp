#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/figure_parts.hpp"
#include "study/numbers.hpp"

namespace enamel::app {
namespace {

// ---- maps over the wall --------------------------------------------------------------------------------------------

// A quantity with a value and a text for every column and point.
struct Map {
  std::vector<std::vector<double>> values;
  std::vector<std::vector<std::string>> texts;  // empty: no texts
  Axis bar;
};

// Add one panel for each column, with a common colour scale. Return their lower end.
double addMaps(Svg& svg, double top, const Study& study, const Map& map) {
  const std::size_t count = study.labels.size(), perLine = std::min<std::size_t>(count, 4);
  constexpr double kLeft = 60.0, kGap = 18.0, kBar = 106.0;
  const double side = std::min(250.0, (Svg::kWidth - kLeft - kBar) / static_cast<double>(perLine) - kGap);
  bool tall = false;
  for (const ColumnLabel& label : study.labels) tall = tall || widthOf(label.title) > side;
  const double above = tall ? 42.0 : 24.0,
               step = study.plan.grid > 1 ? 2.0 * edgeOf(study) / (study.plan.grid - 1) : 2.0 * edgeOf(study),
               edge = study.plan.grid > 1 ? edgeOf(study) + 0.5 * step : edgeOf(study), cell = side / study.plan.grid;
  for (std::size_t c = 0; c < count; ++c) {
    const std::size_t place = c % perLine;
    if (place == 0) top += c == 0 ? above : side + above + 10.0;
    Panel panel(svg, {kLeft + static_cast<double>(place) * (side + kGap), top}, side, side,
                {"x (mm)", -edge, edge, false, c + perLine >= count}, {"y (mm)", -edge, edge, false, place == 0},
                study.labels[c].title, false);
    svg.openGroup("class=\"cells\" shape-rendering=\"crispEdges\"");
    for (std::size_t p = 0; p < study.plan.points(); ++p) {
      const Vec3 at = 1e3 * queryPoint(study.plan, p);
      const double value = map.values[c][p];
      svg.box(panel.at(at.x() - 0.5 * step, at.y() + 0.5 * step), cell, cell,
              std::isfinite(value) ? viridis(map.bar.share(value)) : kNoValue,
              map.texts.empty() ? "" : pointText(study, p) + " mm: " + map.texts[c][p]);
    }
    svg.closeGroup();
    if (c + 1 == perLine) addColourBar(svg, {kLeft + static_cast<double>(perLine) * (side + kGap), top}, side, map.bar);
  }
  return top + side + 46.0;
}

// Return the statistics of a column's points in their order.
std::vector<const PointStatistics*> pointsOf(const Findings& findings, int scenario, std::size_t column) {
  std::vector<const PointStatistics*> points;
  for (const PointStatistics& p : findings.points)
    if (p.scenario == scenario && p.column == column) points.push_back(&p);
  return points;
}

std::string rangeText(const std::vector<double>& values, const std::string& unit) {
  Extent extent;
  for (const double v : values) extent.see(v);
  return extent.low <= extent.high ? fmt::format("{} to {} {}", numberText(extent.low), numberText(extent.high), unit)
                                   : "none";
}

// ---- along y --------------------------------------------------------------------------------------------------------

// Mean, lowest and highest value over x at each y.
struct Row {
  std::string name;
  Style style;
  std::vector<double> means, lows, highs;
};

Row rowOf(const Study& study, const std::vector<double>& values) {
  const auto side = static_cast<std::size_t>(study.plan.grid);
  Row row;
  row.means = rowMeans(study, values);
  for (std::size_t i = 0; i < side; ++i) {
    const auto [low, high] = std::minmax_element(values.begin() + static_cast<std::ptrdiff_t>(i * side),
                                                 values.begin() + static_cast<std::ptrdiff_t>((i + 1) * side));
    row.lows.push_back(*low);
    row.highs.push_back(*high);
  }
  return row;
}

// Return K_z1 of every renderer, in % deviation from its mean.
std::vector<Row> stiffnessRows(const Study& study, const Findings& findings, Extent& percents) {
  std::vector<Row> rows;
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    std::vector<double> k = over(findings.survey[c], [](const SurveyPoint& p) { return p.stiffness; });
    const double mean = spreadOf(k).mean;
    for (double& v : k) percents.see(v = 100.0 * (v / mean - 1.0));
    rows.push_back(rowOf(study, k));
    rows.back().name = study.labels[c].title;
    rows.back().style = {colourOf(study, c), 2.0, study.labels[c].kind == ColumnKind::scheduled};
  }
  return rows;
}

// Return the largest torque of every joint. Joints with equal torques, such as mirror images, share a row.
std::vector<Row> torqueRows(const Study& study, const std::vector<SurveyPoint>& points, Extent& torques) {
  const char* const colours[] = {kBlue, kOrange, kGreen, kVermilion};
  std::vector<Row> rows;
  for (int joint = 0; joint < study.mechanism->joints(); ++joint) {
    const Row row = rowOf(study, over(points, [&](const SurveyPoint& p) { return p.peak[joint]; }));
    for (const double v : row.highs) torques.see(v);
    const auto alike = std::find_if(rows.begin(), rows.end(), [&](const Row& other) {
      return std::equal(row.means.begin(), row.means.end(), other.means.begin(),
                        [](double a, double b) { return std::abs(a - b) <= 0.005 * std::abs(b); });
    });
    if (alike != rows.end()) {
      alike->name += fmt::format(", q_{}", joint + 1);
      continue;
    }
    rows.push_back(row);
    rows.back().name = fmt::format("q_{}", joint + 1);
    rows.back().style = {colours[(rows.size() - 1) % 4], 2.0, rows.size() > 4};
  }
  return rows;
}

std::vector<LegendEntry> legendOf(const std::vector<Row>& rows) {
  std::vector<LegendEntry> entries;
  for (const Row& row : rows) entries.push_back({row.name, row.style});
  return entries;
}

}  // namespace

Figure firstImpactMap(const Study& study, const Findings& findings) {
  Map absolute, relative;
  Extent extent, share;
  double widest = 0.0;
  std::vector<std::string> ranges;
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    std::vector<double> k, percent;
    std::vector<std::string> texts;
    for (const PointStatistics* p : pointsOf(findings, 1, c)) {
      const Spread& s = p->of(&PushMetrics::firstStiffness);
      k.push_back(1e-3 * s.mean);
      extent.see(k.back());
      texts.push_back(s.count > 0 ? meanText(s, 1e-3) + " kN/m" : "no run has K_z1");
      if (const double width = halfInterval(s) / s.mean; std::isfinite(width)) widest = std::max(widest, width);
    }
    std::vector<double> finite;
    for (const double v : k)
      if (std::isfinite(v)) finite.push_back(v);
    for (const double v : k) share.see(percent.emplace_back(100.0 * (v / spreadOf(finite).mean - 1.0)));
    ranges.push_back(escape(study.labels[c].title) + " " + rangeText(k, "kN/m"));
    absolute.values.push_back(k);
    absolute.texts.push_back(texts);
    relative.values.push_back(percent);
  }
  absolute.bar = extent.axis("mean K_z1 (kN/m)", 0.02, true);
  relative.bar = share.axis("from the wall's mean (%)", 0.0);
  Svg svg;
  const double bottom = addMaps(svg, 0.0, study, absolute);
  const double end = addMaps(svg, bottom + 6.0, study, relative);
  return {"fig10-first-impact", svg.whole("first impact stiffness over the wall", end),
          fmt::format("Scenario 1: mean of K_z1 at each query point, over those of its {} runs that have a K_z1 (after "
                      "the paper's Fig. 10). Top: one logarithmic colour scale for all renderers. Bottom: the "
                      "difference from each renderer's mean over the wall, one scale for all. Ranges: {}. The bottom "
                      "maps show whether the stiffness has a slope. Every 95 % interval is at most ± {} % of its mean "
                      "(grey: no run has a K_z1); the mouse pointer shows the value of a point.",
                      study.plan.runs, join(ranges, ", "), numberText(100.0 * widest, 2))};
}

Figure steadyMap(const Study& study, const Findings& findings, int scenario) {
  Map map;
  Extent extent;
  int unresolved = 0;
  std::vector<std::string> ranges;
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    std::vector<double> k;
    std::vector<std::string> texts;
    for (const PointStatistics* p : pointsOf(findings, scenario, c)) {
      k.push_back(p->steadyStiffness ? 1e-3 * *p->steadyStiffness : std::nan(""));
      extent.see(k.back());
      unresolved += !p->steadyStiffness;
      texts.push_back(p->steadyStiffness ? steadyText(p->of(&PushMetrics::steadyCompliance), 1e-3) + " kN/m"
                                         : "not resolved");
    }
    ranges.push_back(escape(study.labels[c].title) + " " + rangeText(k, "kN/m"));
    map.values.push_back(k);
    map.texts.push_back(texts);
  }
  map.bar = extent.axis("K_zs (kN/m)", 0.02, true);
  Svg svg;
  const double end = addMaps(svg, 0.0, study, map);
  return {fmt::format("fig1{}-steady-{}", scenario == 1 ? 2 : 3, scenario),
          svg.whole("steady stiffness over the wall", end),
          fmt::format(
              "Scenario {}: K_zs = 1 / |mean C_zs| at each query point (after the paper's Fig. {}), one logarithmic "
              "colour scale. The mouse pointer shows the value of a point with its 95 % interval. Ranges: {}.{}",
              scenario, scenario == 1 ? 12 : 13, join(ranges, ", "),
              unresolved > 0 ? fmt::format(" Grey: not resolved, {} of the {} points shown: the mean compliance "
                                           "is below two standard errors, so the stiffness may be infinite.",
                                           unresolved, study.labels.size() * study.plan.points())
                             : "")};
}

Figure alongYFigure(const Study& study, const Findings& findings) {
  const auto side = static_cast<std::size_t>(study.plan.grid);
  std::vector<double> ys;
  for (std::size_t i = 0; i < side; ++i) ys.push_back(1e3 * queryPoint(study.plan, i * side).y());
  Extent percents, torques;
  const std::vector<Row> stiffness = stiffnessRows(study, findings, percents);
  const std::size_t hold = study.column(ColumnKind::hold), shown = hold < study.labels.size() ? hold : 0;
  const std::vector<Row> torque = torqueRows(study, findings.survey[shown], torques);
  Svg svg;
  constexpr double kWide = 310.0, kHigh = 270.0, kLefts[] = {72.0, 474.0};
  const double top = std::max(addLegend(svg, {kLefts[0], 0.0}, kWide, legendOf(stiffness)),
                              addLegend(svg, {kLefts[1], 0.0}, kWide, legendOf(torque))) +
                     8.0;
  const Axis y{"y (mm)", -edgeOf(study), edgeOf(study)};
  torques.see(0.0);
  Axis torqueAxis = torques.axis("largest torque (N m)", 0.08);
  torqueAxis.low = 0.0;
  Panel left(svg, {kLefts[0], top}, kWide, kHigh, y, percents.axis("K_z1 from its mean (%)", 0.08)),
      right(svg, {kLefts[1], top}, kWide, kHigh, y, torqueAxis);
  for (const auto& [panel, rows] : {std::pair(&left, &stiffness), std::pair(&right, &torque)}) {
    for (const Row& row : *rows) panel->band(ys, row.lows, row.highs, row.style.colour);
    for (const Row& row : *rows) panel->curve(ys, row.means, row.style);
  }
  return {
      "along-y", svg.whole("stiffness and torque along y", top + kHigh + 46.0),
      fmt::format("Pushes without noise. Lines are means over x; bands are the range over x (without noise there is "
                  "one result and so no interval). Left: K_z1 for {:.0f} N along y, relative to each renderer's mean. "
                  "Right: largest torque of each joint for {:.0f} N with {}; the motors' limit is {} N m. The figure "
                  "shows how the stiffness changes along y and how far the motors stay below their limit.",
                  kSurveyForce, kHardForce, escape(study.labels[shown].title),
                  givenText(study.mechanism->limits().effort.minCoeff()))};
}

}  // namespace enamel::app
