#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/figures.hpp"
#include "study/numbers.hpp"

namespace enamel::app {
namespace {

// ---- maps over the wall --------------------------------------------------------------------------------------------

// Return the lowest and highest finite value.
std::pair<double, double> rangeOf(const std::vector<std::vector<double>>& lists) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const auto& values : lists)
    for (const double v : values)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  return {low, high};
}

std::string rangeText(const std::vector<double>& values, const std::string& unit) {
  const auto [low, high] = rangeOf({values});
  return low <= high ? fmt::format("{} to {} {}", numberText(low), numberText(high), unit) : "none";
}

// A quantity with a value and a text for every column and point, on one colour scale.
struct Map {
  std::vector<std::vector<double>> values;
  std::vector<std::vector<std::string>> texts;
};

Figure mapFigure(const Study& study, const Map& map, const std::string& name, const std::string& title,
                 const std::string& caption) {
  const int grid = study.plan.grid, columns = std::min(3, static_cast<int>(study.labels.size()));
  const double half = edgeOf(study) / std::max(1, grid - 1), edge = grid > 1 ? edgeOf(study) + half : edgeOf(study),
               step = grid > 1 ? half : edge;
  const auto [low, high] = rangeOf(map.values);
  const bool logarithmic = low > 0.0;
  Json panels = Json::array();
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    Json cells = Json::array();
    for (std::size_t p = 0; p < study.plan.points(); ++p) {
      const Vec3 at = 1e3 * (queryPoint(study.plan, p) - study.plan.middle);
      cells.push_back(rectangle(at.x() - step, at.x() + step, at.y() - step, at.y() + step));
      cells.back()["value"] = numbers({map.values[c][p]})[0];
      cells.back()["text"] = pointText(study, p) + " mm: " + map.texts[c][p];
    }
    Json x = axis("x (mm)", -edge, edge), y = axis("y (mm)", -edge, edge);
    y["numbers"] = c % static_cast<std::size_t>(columns) == 0;
    panels.push_back(
        panel(study.labels[c].title, 210, 210, x, y, Json::array({{{"type", "cells"}, {"cells", cells}}})));
    panels.back()["grid"] = false;
  }
  const double least = low <= high ? low : 0.0, most = low < high ? high : least + 1.0;
  Json plot = figure(title, columns, Json::array(), panels);
  plot["scale"] = axis(title, least, most, logarithmic);
  return {name, plot, caption};
}

// Return the statistics of a column's points in their order.
std::vector<const PointStatistics*> pointsOf(const Findings& findings, int scenario, std::size_t column) {
  std::vector<const PointStatistics*> points;
  for (const PointStatistics& p : findings.points)
    if (p.scenario == scenario && p.column == column) points.push_back(&p);
  return points;
}

}  // namespace

Json legendOf(const Study& study, bool filled) {
  Json legend = Json::array();
  for (const ColumnLabel& label : study.labels) legend.push_back(entry(label.title, label.style, filled));
  return legend;
}

Figure stiffnessBoxes(const Study& study, const Findings& findings) {
  Json panels = Json::array();
  for (const int scenario : study.plan.scenarios) {
    Json boxes = Json::array();
    for (std::size_t c = 0; c < study.labels.size(); ++c) {
      std::vector<double> values;
      std::vector<std::string> texts;
      for (const PointStatistics* p : pointsOf(findings, scenario, c)) {
        const Spread& s = scenario == 1 ? p->of(&PushMetrics::depthStiffness) : p->forceOverRms;
        if (!std::isfinite(s.mean)) continue;
        values.push_back(1e-3 * s.mean);
        texts.push_back(fmt::format("{} mm: {} kN/m", pointText(study, p->point), meanText(s, 1e-3)));
      }
      boxes.push_back(boxOf("", study.labels[c].title, study.labels[c].style, values));
      boxes.back()["texts"] = texts;
    }
    panels.push_back(panel(scenario == 1 ? "a sudden push (scenario 1)" : "a hand that presses (scenario 2)", 340, 190,
                           {{"names", Json::array({""})}},
                           axis(scenario == 1 ? "stiffness K_d (kN/m)" : "F_c / rms depth (kN/m)", true),
                           Json::array({{{"type", "boxes"}, {"boxes", boxes}}})));
  }
  return {
      "stiffness", figure("stiffness over the wall", 2, legendOf(study, true), panels),
      fmt::format("Stiffness at the {} query points, in simulation; higher is better. Each dot is the mean of the {} "
                  "runs at one point, a box has the quartiles and the median of the points.",
                  study.plan.points(), study.plan.runs)};
}

Figure firstImpactMap(const Study& study, const Findings& findings) {
  Map map;
  double widest = 0.0;
  std::vector<std::string> ranges, flat;
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    std::vector<double> k;
    std::vector<std::string> texts;
    double half = 0.0;
    for (const PointStatistics* p : pointsOf(findings, 1, c)) {
      const Spread& s = p->of(&PushMetrics::firstStiffness);
      k.push_back(1e-3 * s.mean);
      texts.push_back(s.count > 0 ? meanText(s, 1e-3) + " kN/m" : "no run has K_z1");
      half = std::max(half, 1e-3 * halfInterval(s));
      if (const double width = halfInterval(s) / s.mean; std::isfinite(width)) widest = std::max(widest, width);
    }
    const auto [low, high] = rangeOf({k});
    if (study.plan.grid > 1 && high - low < 2.0 * half) flat.push_back(escape(study.labels[c].title));
    ranges.push_back(escape(study.labels[c].title) + " " + rangeText(k, "kN/m"));
    map.values.push_back(k);
    map.texts.push_back(texts);
  }
  return mapFigure(
      study, map, "fig10-first-impact", "mean K_z1 (kN/m)",
      fmt::format("Scenario 1: mean of K_z1 at each query point, over those of its {} runs that have a K_z1 (after the "
                  "paper's Fig. 10), on one colour scale for all renderers. Ranges: {}. Every 95 % interval is at most "
                  "± {} % of its mean (grey: no run has a K_z1).{}",
                  study.plan.runs, join(ranges, ", "), numberText(100.0 * widest, 2),
                  flat.empty()
                      ? ""
                      : " A map is flat if its range is smaller than its widest interval: " + join(flat, ", ") + "."));
}

Figure steadyMap(const Study& study, const Findings& findings, int scenario) {
  Map map;
  int unresolved = 0;
  std::vector<std::string> ranges;
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    std::vector<double> k;
    std::vector<std::string> texts;
    for (const PointStatistics* p : pointsOf(findings, scenario, c)) {
      k.push_back(p->steadyStiffness ? 1e-3 * *p->steadyStiffness : std::nan(""));
      unresolved += !p->steadyStiffness;
      texts.push_back(p->steadyStiffness ? steadyText(p->of(&PushMetrics::steadyCompliance), 1e-3) + " kN/m"
                                         : "not resolved");
    }
    ranges.push_back(escape(study.labels[c].title) + " " + rangeText(k, "kN/m"));
    map.values.push_back(k);
    map.texts.push_back(texts);
  }
  return mapFigure(
      study, map, fmt::format("fig1{}-steady-{}", scenario == 1 ? 2 : 3, scenario), "K_zs (kN/m)",
      fmt::format("Scenario {}: K_zs = 1 / |mean C_zs| at each query point (after the paper's Fig. {}), on one colour "
                  "scale. Ranges: {}.{}",
                  scenario, scenario == 1 ? 12 : 13, join(ranges, ", "),
                  unresolved > 0 ? fmt::format(" Grey: not resolved, {} of the {} points shown: the mean compliance "
                                               "is below two standard errors, so the stiffness may be infinite.",
                                               unresolved, study.labels.size() * study.plan.points())
                                 : ""));
}

}  // namespace enamel::app
