#include "study/figures.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "study/numbers.hpp"
#include "study/svg.hpp"

namespace enamel::app {
namespace {

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

// Ends of the wall along x and y, mm.
double edgeOf(const Study& study) { return 1e3 * study.plan.halfWidth; }

// ---- Fig. 6: the device and the query points -----------------------------------------------------------------------

Figure deviceFigure(const Study& study) {
  const std::vector<Bar> bars = study.mechanism->bars(Pose{});
  const Vec3 handle(0.0, 0.0, 0.062);  // drawn so long; the device file has no handle
  const double pane = study.plan.halfWidth + 0.004;
  Eigen::AlignedBox<double, 3> box(Vec3(-pane, -pane, 0.0), Vec3(pane, pane, handle.z()));
  for (const Bar& bar : bars) box.extend(bar.from).extend(bar.to);
  constexpr double kLeft = 62.0, kTop = 26.0, kGap = 22.0, kMargin = 12.0;  // of the axes: mm
  const Vec3 low = 1e3 * box.min() - Vec3::Constant(kMargin), high = 1e3 * box.max() + Vec3::Constant(kMargin),
             size = high - low;
  const double scale = std::min((Svg::kWidth - kLeft - kGap - 6.0) / (size.x() + size.z()), 460.0 / size.y());
  const Axis x{"x (mm)", low.x(), high.x()}, y{"y (mm)", low.y(), high.y()}, z{"z (mm)", low.z(), high.z()};
  Svg svg;
  Panel front(svg, {kLeft, kTop}, scale * size.x(), scale * size.y(), x, y, "facing the wall");
  Axis shared = y;
  shared.numbers = false;
  Panel side(svg, {kLeft + scale * size.x() + kGap, kTop}, scale * size.z(), scale * size.y(), z, shared,
             "from the side");
  const double edge = 1e3 * pane;
  svg.box(front.at(-edge, edge), 2.0 * edge * scale, 2.0 * edge * scale, "#f3ead6", "", "stroke=\"#9c8a5e\"");
  svg.line(side.at(0.0, -edge), side.at(0.0, edge), {"#9c8a5e", 3.0});
  int chains = 0;
  for (const Bar& bar : bars) chains = std::max(chains, bar.chain + 1);
  std::vector<int> links(static_cast<std::size_t>(chains), 0);
  std::vector<Vec3> tips(static_cast<std::size_t>(chains), Vec3::Zero());
  const auto rod = [&](const Vec3& from, const Vec3& to, const Style& style) {
    svg.path({front.at(1e3 * from.x(), 1e3 * from.y()), front.at(1e3 * to.x(), 1e3 * to.y())}, style);
    svg.path({side.at(1e3 * from.z(), 1e3 * from.y()), side.at(1e3 * to.z(), 1e3 * to.y())}, style);
  };
  const auto ball = [&](const Vec3& at, double radius, const char* colour) {
    svg.disc(front.at(1e3 * at.x(), 1e3 * at.y()), radius, colour);
    svg.disc(side.at(1e3 * at.z(), 1e3 * at.y()), radius, colour);
  };
  std::vector<std::tuple<Place, std::string, Anchor>> labels;
  for (const Bar& bar : bars) {
    if (bar.chain < 0) continue;
    const int link = links[static_cast<std::size_t>(bar.chain)]++;
    tips[static_cast<std::size_t>(bar.chain)] = bar.to;
    rod(bar.from, bar.to, {link == 0 ? "#55606e" : "#8c97a4", link == 0 ? 6.0 : 4.5});
    ball(bar.to, 4.0, kInk);
    if (link > 0) continue;
    ball(bar.from, 6.0, kInk);
    // Joints go to the chains in turn.
    std::string text = fmt::format("chain {}:", bar.chain + 1);
    const int each = study.mechanism->joints() / chains;
    for (int j = 0; j < each; ++j) text += fmt::format("{} q_{}", j > 0 ? "," : "", bar.chain * each + j + 1);
    // Where nothing else is: in front of the wall stand the points.
    const bool aside = std::abs(bar.from.x()) > study.plan.halfWidth;
    const Place at =
        aside ? front.at(1e3 * bar.from.x(), 1e3 * bar.from.y()) : side.at(1e3 * bar.from.z(), 1e3 * bar.from.y());
    labels.emplace_back(Place{at.x, at.y - 12.0}, text, aside && bar.from.x() > 0.0 ? Anchor::end : Anchor::start);
  }
  for (const Vec3& tip : tips) rod(tip, Vec3(0.0, 0.0, 0.010), {"#6c7785", 3.0});
  rod(Vec3(0.0, 0.0, 0.004), handle, {"#2f6f73", 8.0});
  for (std::size_t p = 0; p < study.plan.points(); ++p) {
    const Vec3 at = 1e3 * queryPoint(study.plan, p);
    svg.disc(front.at(at.x(), at.y()), std::min(2.2, 18.0 / study.plan.grid), kVermilion);
  }
  svg.openGroup("paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"3\"");  // readable over anything
  for (const auto& [at, text, anchor] : labels) svg.text(at, text, anchor, kMuted);
  svg.closeGroup();
  return {"fig06-device", svg.whole("the device and the query points", kTop + scale * size.y() + 46.0),
          fmt::format("The device at home, to scale, and the {} query points (red) on the wall z = 0 (yellowish; after "
                      "the paper's Fig. 6). Dark: the first link of each chain with its motors' joints q; light: the "
                      "second; green: the tool's handle. The person pushes the tool to the left in the view from the "
                      "side. To see: every push begins on the wall, and the points cover x and y from {} to {} mm.",
                      study.plan.points(), givenText(-edgeOf(study)), givenText(edgeOf(study)))};
}

// ---- Fig. 8, 9: typical responses ----------------------------------------------------------------------------------

Figure responseFigure(const Study& study, int scenario) {
  const StudyPlan& plan = study.plan;
  const double from = 0.9, to = plan.setup.duration;
  // Away from home, where nothing is special.
  const auto side = static_cast<std::size_t>(plan.grid), middle = (7 * side / 10) * side + side / 4;
  struct Curve {
    std::string title, colour;
    std::vector<double> times, values;
    Extent extent;
    bool lost = false;
  };
  Curve force{"", kInk, {}, {}, {}};
  std::vector<Curve> depths;
  Extent all;
  StudyRun run;
  for (std::size_t c = 0; c < plan.columns.size(); ++c) {
    for (std::size_t i = 0; i < plan.size(); ++i) {
      run = runAt(plan, i);
      if (run.scenario == scenario && run.column == c && run.point == middle) break;
    }
    Curve depth{study.labels[c].title, colourOf(study, c), {}, {}, {}};
    const StudyResult result = performRun(plan, run, [&](const TickRecord& t) {
      if (t.time < from) return;
      depth.times.push_back(t.time);
      depth.values.push_back(1e3 * t.pose.position.z());
      depth.extent.see(depth.values.back());
      all.see(depth.values.back());
      if (!depths.empty()) return;
      force.times.push_back(t.time);
      force.values.push_back(-t.person[2]);
      force.extent.see(-t.person[2]);
    });
    depth.lost = result.status != Status::ok;
    depths.push_back(depth);
  }

  constexpr double kLeft = 66.0, kWide = Svg::kWidth - kLeft - 18.0, kHigh = 96.0, kStep = kHigh + 28.0;
  Svg svg;
  double top = 24.0;
  Axis time{"time (s)", from, to, false, false};
  const auto add = [&](const std::string& title, const Curve& curve, const Axis& y) {
    Panel panel(svg, {kLeft, top}, kWide, kHigh, time, y, title);
    panel.level(0.0, {kMuted, 1.0, true});
    panel.curve(curve.times, curve.values, {curve.colour, 1.3});
    top += kStep;
  };
  all.see(0.0);
  const Axis depthAxis = all.axis("z (mm)", 0.06);
  add("the person's force", force, force.extent.axis("force (N)", 0.08));
  for (const Curve& depth : depths) {
    time.numbers = &depth == &depths.back();
    add(depth.title, depth, depthAxis);
  }
  top += 40.0;
  // Close up: the first impact where there is one; else what the stillest of them does.
  const bool step = scenario == 1;
  const auto stillest = std::min_element(depths.begin(), depths.end(), [](const Curve& a, const Curve& b) {
    return a.extent.high - a.extent.low < b.extent.high - b.extent.low;
  });
  Extent still;
  still.see(1e3 * stillest->extent.low);
  still.see(1e3 * stillest->extent.high);
  Axis near = time;
  if (step) near.low = 0.99, near.high = 1.15;
  Panel panel(svg, {kLeft, top}, kWide, 2.0 * kHigh, near, step ? depthAxis : still.axis("z (µm)", 0.06),
              step ? "all of them at the step, same scale of z" : "all of them on the scale of " + stillest->title);
  std::vector<LegendEntry> entries;
  std::vector<std::string> deepest;
  for (Curve& depth : depths) {
    if (!step)
      for (double& value : depth.values) value *= 1e3;
    panel.curve(depth.times, depth.values, {depth.colour, step ? 1.6 : 1.0});
    entries.push_back({depth.title, {depth.colour, 2.5}});
    deepest.push_back(fmt::format("{} mm ({}{})", numberText(-depth.extent.low, 2), escape(depth.title),
                                  depth.lost ? ": the run was lost there" : ""));
  }
  panel.level(0.0, {kMuted, 1.0, true});
  top += 2.0 * kHigh + 46.0;
  top += addLegend(svg, {kLeft, top}, kWide, entries);
  return {
      fmt::format("fig0{}-response-{}", scenario == 1 ? 8 : 9, scenario),
      svg.whole(fmt::format("responses in scenario {}", scenario), top),
      fmt::format("Scenario {}: one typical run at {} mm with F_c = {:.1f} N (after the paper's Fig. {}). Top: the "
                  "person's force into the wall. Below: where the tool is with each renderer, all on one scale; the "
                  "wall is dashed, below it is inside. Bottom: {}. To see: how deep the tool goes, at most {}.",
                  scenario, pointText(study, middle), run.force, scenario == 1 ? 8 : 9,
                  step ? "the first 0.15 s after the step"
                       : fmt::format("the same, magnified to the range of {}; what leaves it is cut off",
                                     escape(stillest->title)),
                  join(deepest, ", "))};
}

// ---- maps over the wall --------------------------------------------------------------------------------------------

// One quantity: a value and a text for every column and point.
struct Map {
  std::vector<std::vector<double>> values;
  std::vector<std::vector<std::string>> texts;  // empty: no texts
  Axis bar;
};

// A panel a column, one colour scale for all. Returns where it ends.
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

// The statistics of a column's points, in their order.
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
      texts.push_back(s.count > 0 ? meanText(s, 1e-3) + " kN/m" : "no run has one");
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
  return {
      "fig10-first-impact", svg.whole("first impact stiffness over the wall", end),
      fmt::format(
          "Scenario 1: mean of K_z1 at each query point, over those of its {} runs that have one (after the paper's "
          "Fig. 10). Top: one logarithmic colour scale for all renderers; bottom: the difference from each renderer's "
          "mean over the wall, one scale for all. To see: {}; and whether a map has a slope. The 95 % interval of no "
          "mean is wider than ± {} % of it (grey: no run has a K_z1); each is shown where the mouse rests.",
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
  return {
      fmt::format("fig1{}-steady-{}", scenario == 1 ? 2 : 3, scenario),
      svg.whole("steady stiffness over the wall", end),
      fmt::format("Scenario {}: K_zs = 1 / |mean C_zs| at each query point (after the paper's Fig. {}), one "
                  "logarithmic colour scale; each is shown with its 95 % interval where the mouse rests. To see: {}.{}",
                  scenario, scenario == 1 ? 12 : 13, join(ranges, ", "),
                  unresolved > 0 ? fmt::format(" Grey: not resolved, {} of the {} points shown: the mean compliance "
                                               "is below two standard errors, so the stiffness may be infinite.",
                                               unresolved, study.labels.size() * study.plan.points())
                                 : "")};
}

// ---- K_z1 along y, torques -----------------------------------------------------------------------------------------

Figure alongYFigure(const Study& study, const Findings& findings) {
  const auto side = static_cast<std::size_t>(study.plan.grid);
  std::vector<double> ys;
  for (std::size_t i = 0; i < side; ++i) ys.push_back(1e3 * queryPoint(study.plan, i * side).y());
  struct Row {
    std::string name;
    Style style;
    std::vector<double> means, lows, highs;
  };
  // Means over x at each y, with the lowest and the highest of them.
  const auto rowOf = [&](const std::vector<double>& values) {
    Row row;
    row.means = rowMeans(study, values);
    for (std::size_t i = 0; i < side; ++i) {
      const auto [low, high] = std::minmax_element(values.begin() + static_cast<std::ptrdiff_t>(i * side),
                                                   values.begin() + static_cast<std::ptrdiff_t>((i + 1) * side));
      row.lows.push_back(*low);
      row.highs.push_back(*high);
    }
    return row;
  };
  std::vector<Row> stiffness, torque;
  Extent percents, torques;
  for (std::size_t c = 0; c < study.labels.size(); ++c) {
    std::vector<double> k = over(findings.survey[c], [](const SurveyPoint& p) { return p.stiffness; });
    const double mean = spreadOf(k).mean;
    for (double& v : k) percents.see(v = 100.0 * (v / mean - 1.0));
    stiffness.push_back(rowOf(k));
    stiffness.back().name = study.labels[c].title;
    stiffness.back().style = {colourOf(study, c), 2.0, study.labels[c].kind == ColumnKind::scheduled};
  }
  const std::size_t hold = study.column(ColumnKind::hold), shown = hold < study.labels.size() ? hold : 0;
  const char* const colours[] = {kBlue, kOrange, kGreen, kVermilion};
  for (int joint = 0; joint < study.mechanism->joints(); ++joint) {
    const Row row = rowOf(over(findings.survey[shown], [&](const SurveyPoint& p) { return p.peak[joint]; }));
    for (const double v : row.highs) torques.see(v);
    // Joints that work alike, as mirror images do, share a curve.
    const auto alike = std::find_if(torque.begin(), torque.end(), [&](const Row& other) {
      return std::equal(row.means.begin(), row.means.end(), other.means.begin(),
                        [](double a, double b) { return std::abs(a - b) <= 0.005 * std::abs(b); });
    });
    if (alike != torque.end()) {
      alike->name += fmt::format(", q_{}", joint + 1);
      continue;
    }
    torque.push_back(row);
    torque.back().name = fmt::format("q_{}", joint + 1);
    torque.back().style = {colours[(torque.size() - 1) % 4], 2.0, torque.size() > 4};
  }
  Svg svg;
  constexpr double kWide = 310.0, kHigh = 270.0, kLefts[] = {72.0, 474.0};
  const auto legendOf = [](const std::vector<Row>& rows) {
    std::vector<LegendEntry> entries;
    for (const Row& row : rows) entries.push_back({row.name, row.style});
    return entries;
  };
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
      fmt::format(
          "Pushes without noise; lines are means over x, bands reach from the lowest to the highest over x (the same "
          "every time: no interval). Left: K_z1 for {:.0f} N along y, from each renderer's mean. Right: largest "
          "torque of each joint for {:.0f} N with {}; the motors' limit is {} N m. To see: which way the stiffness "
          "runs along y, and how far below their limit the motors stay.",
          kSurveyForce, kHardForce, escape(study.labels[shown].title),
          givenText(study.mechanism->limits().torque.minCoeff()))};
}

Figure torqueFigure(const Study& study) {
  const std::size_t hold = study.column(ColumnKind::hold);
  const int last = study.mechanism->joints() - 1;
  const auto side = static_cast<std::size_t>(study.plan.grid);
  const std::size_t middle = side / 2,
                    shown[] = {(side >= 5 ? 1 : 0) * side + middle, (side - (side >= 5 ? 2 : 1)) * side + middle};
  constexpr double kForce = 13.0, kFrom = 0.95, kTo = 1.4;  // N, as in the paper; s
  Extent extent;
  std::vector<double> times[2], torques[2];
  std::vector<LegendEntry> entries;
  const Style styles[] = {{kVermilion, 1.6}, {kBlue, 1.6}};
  for (int i = 0; i < 2; ++i) {
    StudyRun run = runAt(study.plan, 0);
    run.scenario = 1;
    run.column = hold;
    run.point = shown[i];
    run.force = kForce;
    (void)performRun(study.plan, run, [&](const TickRecord& t) {
      if (t.time < kFrom || t.time > kTo) return;
      times[i].push_back(t.time);
      torques[i].push_back(t.torque[last]);
      extent.see(t.torque[last]);
    });
    entries.push_back({"at " + pointText(study, shown[i]) + " mm", styles[i]});
  }
  Svg svg;
  constexpr double kLeft = 72.0, kWide = Svg::kWidth - kLeft - 18.0, kHigh = 270.0;
  const double top = addLegend(svg, {kLeft, 0.0}, kWide, entries) + 8.0;
  Panel panel(svg, {kLeft, top}, kWide, kHigh, {"time (s)", kFrom, kTo},
              extent.axis(fmt::format("torque of joint {} (N m)", last + 1), 0.08));
  for (int i = 0; i < 2; ++i) panel.curve(times[i], torques[i], styles[i]);
  return {"fig11-torque", svg.whole("torque at two query points", top + kHigh + 46.0),
          fmt::format(
              "Torque of joint {} under a step of {:.0f} N at 1 s with {}, at two query points with the same noise "
              "(after the paper's Fig. 11). To see: at which of them the joint works harder; the motor's limit is {} "
              "N m.",
              last + 1, kForce, escape(study.labels[hold].title), givenText(study.mechanism->limits().torque[last]))};
}

// ---- the impedance wall's stability (RQ 2) -------------------------------------------------------------------------

Figure stabilityFigure(const Study& study) {
  const WallDevice device = wallDeviceOf(study);
  constexpr int kColumns = 62, kRows = 40, kDelays = 4;
  constexpr const char *kStable = "#9cc9e6", *kUnstable = "#f0b27a";
  Axis kAxis{"rendered stiffness K (kN/m)", 0.5, 100.0, true}, bAxis{"rendered damping B (N s/m)", 0.1, 100.0, true};
  // From edge to edge, a cell to every two.
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
    double begin = 0.0, most = 0.0;  // of what is stable: where it begins along a row; the largest K
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
    // b = K Ts / 2 + B.
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
          "Where a wall that is rendered as a spring K with a damper B is stable on this device (simulated: the "
          "motion after a push of 12 N dies out within 3 s; effective mass {} kg, mechanical damping {} N s/m, ticks "
          "of {} ms), and the bound of eq. 16, left of and below which a wall is passive. To see: how much beyond the "
          "bound is stable, and what delay, of which eq. 16 says nothing, leaves of it: the stiffest stable K of all "
          "is {} kN/m at 0, 1, 2 and 3 ticks.",
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
          "steps; a method that misses an event is not drawn. Dashed: the error that is allowed, {} %. To see: which "
          "method is the fastest below it.",
          nameOf(c.reference.integrator), c.reference.substeps, givenText(100.0 * c.allowed))};
}

}  // namespace

WallDevice wallDeviceOf(const Study& study) {
  const std::size_t spring = study.column(ColumnKind::impedance);
  const double damping = study.labels[spring < study.labels.size() ? spring : 0].damping;
  const Kinematics& home = study.mechanism->home();
  return {effectiveMass(home, home.pose.position, Vec3::UnitZ()), damping, study.plan.setup.period};
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
