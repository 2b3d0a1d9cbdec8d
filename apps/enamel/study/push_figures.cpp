#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "study/figure_parts.hpp"
#include "study/numbers.hpp"

namespace enamel::app {
namespace {

constexpr double kShownFrom = 0.9;  // s
constexpr double kPanelLeft = 66.0, kPanelWide = Svg::kWidth - kPanelLeft - 18.0, kPanelHigh = 96.0;

struct Curve {
  std::string title, colour;
  std::vector<double> times, values;
  Extent extent;
  bool lost = false;
};

// One run of every renderer at a query point, mm.
struct Responses {
  StudyRun run;  // the last run
  Curve force{"", kInk, {}, {}, {}};
  std::vector<Curve> depths;
  Extent all;  // range of all depths
};

Responses responsesAt(const Study& study, int scenario, std::size_t point) {
  const StudyPlan& plan = study.plan;
  Responses r;
  for (std::size_t c = 0; c < plan.columns.size(); ++c) {
    for (std::size_t i = 0; i < plan.size(); ++i) {
      r.run = runAt(plan, i);
      if (r.run.scenario == scenario && r.run.column == c && r.run.point == point) break;
    }
    Curve depth{study.labels[c].title, colourOf(study, c), {}, {}, {}};
    const StudyResult result = performRun(plan, r.run, [&](const TickRecord& t) {
      if (t.time < kShownFrom) return;
      depth.times.push_back(t.time);
      depth.values.push_back(1e3 * t.pose.position.z());
      depth.extent.see(depth.values.back());
      r.all.see(depth.values.back());
      if (!r.depths.empty()) return;
      r.force.times.push_back(t.time);
      r.force.values.push_back(-t.handWrench[2]);
      r.force.extent.see(-t.handWrench[2]);
    });
    depth.lost = result.status != Status::ok;
    r.depths.push_back(depth);
  }
  r.all.see(0.0);
  return r;
}

Axis depthAxis(const Responses& r) { return r.all.axis("z (mm)", 0.06); }

// Add a panel for the force and one for each renderer. Return their lower end.
double addResponses(Svg& svg, double top, const Responses& r, double to) {
  Axis time{"time (s)", kShownFrom, to, false, false};
  const auto add = [&](const std::string& title, const Curve& curve, const Axis& y) {
    Panel panel(svg, {kPanelLeft, top}, kPanelWide, kPanelHigh, time, y, title);
    panel.level(0.0, {kMuted, 1.0, true});
    panel.curve(curve.times, curve.values, {curve.colour, 1.3});
    top += kPanelHigh + 28.0;
  };
  add("the person's force", r.force, r.force.extent.axis("force (N)", 0.08));
  for (const Curve& depth : r.depths) {
    time.numbers = &depth == &r.depths.back();
    add(depth.title, depth, depthAxis(r));
  }
  return top;
}

const Curve& stillestOf(const std::vector<Curve>& depths) {
  return *std::min_element(depths.begin(), depths.end(), [](const Curve& a, const Curve& b) {
    return a.extent.high - a.extent.low < b.extent.high - b.extent.low;
  });
}

// Show the first impact in scenario 1. In scenario 2, magnify all curves to the range of the calmest one, in um.
void addCloseUp(Svg& svg, double top, bool step, const Responses& r, double to) {
  const Curve& stillest = stillestOf(r.depths);
  Extent still;
  still.see(1e3 * stillest.extent.low);
  still.see(1e3 * stillest.extent.high);
  Axis near{"time (s)", kShownFrom, to, false, true};
  if (step) near.low = 0.99, near.high = 1.15;
  Panel panel(svg, {kPanelLeft, top}, kPanelWide, 2.0 * kPanelHigh, near,
              step ? depthAxis(r) : still.axis("z (µm)", 0.06),
              step ? "all renderers at the step, same scale of z" : "all renderers on the scale of " + stillest.title);
  for (Curve depth : r.depths) {
    if (!step)
      for (double& value : depth.values) value *= 1e3;
    panel.curve(depth.times, depth.values, {depth.colour, step ? 1.6 : 1.0});
  }
  panel.level(0.0, {kMuted, 1.0, true});
}

}  // namespace

// ---- Fig. 6: the device and the query points -----------------------------------------------------------------------

Figure deviceFigure(const Study& study) {
  const std::vector<Bar> bars = study.mechanism->bars(Pose{});
  const Vec3 handle(0.0, 0.0, 0.062);  // length for the drawing only; the device file has no handle
  const double pane = study.plan.halfWidth + 0.004;
  Eigen::AlignedBox<double, 3> box(Vec3(-pane, -pane, 0.0), Vec3(pane, pane, handle.z()));
  for (const Bar& bar : bars) box.extend(bar.from).extend(bar.to);
  constexpr double kLeft = 62.0, kTop = 26.0, kGap = 22.0, kMargin = 12.0;  // margins of the axes: mm
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
    // Assume that each chain has the same number of consecutive joints.
    std::string text = fmt::format("chain {}:", bar.chain + 1);
    const int each = study.mechanism->joints() / chains;
    for (int j = 0; j < each; ++j) text += fmt::format("{} q_{}", j > 0 ? "," : "", bar.chain * each + j + 1);
    // Place the label where it hides no query points.
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
  svg.openGroup("paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"3\"");  // a white outline keeps labels readable
  for (const auto& [at, text, anchor] : labels) svg.text(at, text, anchor, kMuted);
  svg.closeGroup();
  return {"fig06-device", svg.whole("the device and the query points", kTop + scale * size.y() + 46.0),
          fmt::format("The device at home, to scale, and the {} query points (red) on the wall z = 0 (yellowish; after "
                      "the paper's Fig. 6). Dark: the first link of each chain with its motors' joints q; light: the "
                      "second; green: the tool's handle. In the view from the side, the person pushes the tool to the "
                      "left. Every push begins on the wall. The points cover x and y from {} to {} mm.",
                      study.plan.points(), givenText(-edgeOf(study)), givenText(edgeOf(study)))};
}

// ---- Fig. 8, 9: typical responses ----------------------------------------------------------------------------------

Figure responseFigure(const Study& study, int scenario) {
  const StudyPlan& plan = study.plan;
  const bool step = scenario == 1;
  // A point away from home, which would be a special case.
  const auto side = static_cast<std::size_t>(plan.grid), middle = (7 * side / 10) * side + side / 4;
  const Responses r = responsesAt(study, scenario, middle);
  Svg svg;
  double top = addResponses(svg, 24.0, r, plan.setup.duration) + 40.0;
  std::vector<LegendEntry> entries;
  std::vector<std::string> deepest;
  for (const Curve& depth : r.depths) {
    entries.push_back({depth.title, {depth.colour, 2.5}});
    deepest.push_back(fmt::format("{} mm ({}{})", numberText(-depth.extent.low, 2), escape(depth.title),
                                  depth.lost ? ": the run was lost there" : ""));
  }
  addCloseUp(svg, top, step, r, plan.setup.duration);
  top += 2.0 * kPanelHigh + 46.0;
  top += addLegend(svg, {kPanelLeft, top}, kPanelWide, entries);
  return {
      fmt::format("fig0{}-response-{}", step ? 8 : 9, scenario),
      svg.whole(fmt::format("responses in scenario {}", scenario), top),
      fmt::format("Scenario {}: one typical run at {} mm with F_c = {:.1f} N (after the paper's Fig. {}). Top: the "
                  "person's force into the wall. Below: the position of the tool with each renderer, on one scale; the "
                  "wall is dashed, its inside is below. Bottom: {}. Largest depths: {}.",
                  scenario, pointText(study, middle), r.run.force, step ? 8 : 9,
                  step ? "the first 0.15 s after the step"
                       : fmt::format("the same, magnified to the range of {}; curves are cut off outside this range",
                                     escape(stillestOf(r.depths).title)),
                  join(deepest, ", "))};
}

// ---- Fig. 11 --------------------------------------------------------------------------------------------------------

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
              "(after the paper's Fig. 11). The figure shows at which point the torque is larger. The motor's limit is "
              "{} N m.",
              last + 1, kForce, escape(study.labels[hold].title), givenText(study.mechanism->limits().effort[last]))};
}

}  // namespace enamel::app
