#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "study/figures.hpp"
#include "study/numbers.hpp"

namespace enamel::app {
namespace {

constexpr double kShownFrom = 0.9;  // s
constexpr int kPanelWide = 770, kPanelHigh = 96;

struct Curve {
  std::string title;
  Style style;
  std::vector<double> times, values;
  double low = HUGE_VAL, high = -HUGE_VAL;
  bool lost = false;

  void add(double time, double value) {
    times.push_back(time);
    values.push_back(value);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  Json drawn(double scale = 1.0) const {
    std::vector<double> scaled = values;
    for (double& v : scaled) v *= scale;
    const double step = times.size() > 1 ? 1e-9 * std::nearbyint(1e9 * (times[1] - times[0])) : 0.0;
    return line(title, {{"from", times.empty() ? 0.0 : times.front()}, {"step", step}}, scaled, style);
  }
};

// One run of every renderer at a query point, mm.
struct Responses {
  StudyRun run;  // the last run
  Curve force{"the person's force", {viewer::kInk, {}, 1.3}, {}, {}};
  std::vector<Curve> depths;
};

Responses responsesAt(const Study& study, int scenario, std::size_t point) {
  const StudyPlan& plan = study.plan;
  Responses r;
  for (std::size_t c = 0; c < plan.columns.size(); ++c) {
    for (std::size_t i = 0; i < plan.size(); ++i) {
      r.run = runAt(plan, i);
      if (r.run.scenario == scenario && r.run.column == c && r.run.point == point) break;
    }
    Curve depth{study.labels[c].title, study.labels[c].style, {}, {}};
    const StudyResult result = performRun(plan, r.run, [&](const TickRecord& t) {
      if (t.time < kShownFrom) return;
      depth.add(t.time, 1e3 * t.pose.position.z());
      if (r.depths.empty()) r.force.add(t.time, -t.handWrench[2]);
    });
    depth.lost = result.status != Status::ok;
    r.depths.push_back(depth);
  }
  return r;
}

Json panelOf(const std::string& title, int height, const Json& time, const Json& y, Json layers) {
  layers.push_back(level(0.0, dashed(viewer::kMuted)));
  return panel(title, kPanelWide, height, time, y, layers);
}

const Curve& stillestOf(const std::vector<Curve>& depths) {
  return *std::min_element(depths.begin(), depths.end(),
                           [](const Curve& a, const Curve& b) { return a.high - a.low < b.high - b.low; });
}

// Return the panel of all renderers: in scenario 1 the first impact, in scenario 2 the range of the calmest one.
Json closeUp(bool step, const Responses& r, double end) {
  const Curve& stillest = stillestOf(r.depths);
  Json y = axis("z (mm)"), layers = Json::array();
  y["share"] = "z";
  if (!step) {
    const double margin = 60.0 * (stillest.high - stillest.low);
    y = axis("z (µm)", 1e3 * stillest.low - margin, 1e3 * stillest.high + margin);
  }
  for (const Curve& depth : r.depths) layers.push_back(depth.drawn(step ? 1.0 : 1e3));
  return panelOf(
      step ? "all renderers at the step, same scale of z" : "all renderers on the scale of " + stillest.title,
      2 * kPanelHigh, axis("time (s)", step ? 0.99 : kShownFrom, step ? 1.15 : end), y, layers);
}

// ---- the drawing of the device -----------------------------------------------------------------------------------

struct Drawing {
  Json segments[2] = {Json::array(), Json::array()}, texts[2] = {Json::array(), Json::array()};  // front, side
  std::vector<double> joints[3];                                                                 // x, y, z, mm

  void rod(const Vec3& from, const Vec3& to, unsigned colour, double width) {
    for (int view = 0; view < 2; ++view) {
      const int across = view == 0 ? 0 : 2;
      segments[view].push_back(rectangle(1e3 * from[across], 1e3 * to[across], 1e3 * from.y(), 1e3 * to.y()));
      segments[view].back()["colour"] = colourText(colour);
      segments[view].back()["width"] = width;
    }
  }
  void joint(const Vec3& at) {
    for (int i = 0; i < 3; ++i) joints[i].push_back(1e3 * at[i]);
  }
  void label(const Vec3& at, const std::string& text, bool front) {
    const double across = 1e3 * (front ? at.x() : at.z());
    texts[front ? 0 : 1].push_back(
        {{"x", across}, {"y", 1e3 * at.y()}, {"text", text}, {"align", front && across > 0.0 ? "right" : "left"}});
  }
};

void addBars(const Study& study, const std::vector<Bar>& bars, Drawing& drawing) {
  int chains = 0;
  for (const Bar& bar : bars) chains = std::max(chains, bar.chain + 1);
  std::vector<int> links(static_cast<std::size_t>(chains), 0);
  std::vector<Vec3> tips(static_cast<std::size_t>(chains), Vec3::Zero());
  for (const Bar& bar : bars) {
    if (bar.chain < 0) continue;
    const int link = links[static_cast<std::size_t>(bar.chain)]++;
    tips[static_cast<std::size_t>(bar.chain)] = bar.to;
    drawing.rod(bar.from, bar.to, link == 0 ? viewer::kLink1 : viewer::kLink2, link == 0 ? 6.0 : 4.5);
    drawing.joint(bar.to);
    if (link > 0) continue;
    drawing.joint(bar.from);
    // Assume that each chain has the same number of consecutive joints.
    std::string text = fmt::format("chain {}:", bar.chain + 1);
    const int each = study.mechanism->joints() / chains;
    for (int j = 0; j < each; ++j) text += fmt::format("{} q_{}", j > 0 ? "," : "", bar.chain * each + j + 1);
    // Place the label where it hides no query points.
    drawing.label(bar.from, text, std::abs(bar.from.x()) > study.plan.halfWidth);
  }
  for (const Vec3& tip : tips) drawing.rod(tip, Vec3(0.0, 0.0, 0.010), viewer::kPlatform, 3.0);
}

}  // namespace

// ---- Fig. 6: the device and the query points -----------------------------------------------------------------------

Figure deviceFigure(const Study& study) {
  const std::vector<Bar> bars = study.mechanism->bars(Pose{});
  const Vec3 handle(0.0, 0.0, 0.062);  // length for the drawing only; the device file has no handle
  const double pane = study.plan.halfWidth + 0.004;
  Eigen::AlignedBox<double, 3> box(Vec3(-pane, -pane, 0.0), Vec3(pane, pane, handle.z()));
  for (const Bar& bar : bars) box.extend(bar.from).extend(bar.to);
  constexpr double kMargin = 12.0;  // mm
  const Vec3 low = 1e3 * box.min() - Vec3::Constant(kMargin), high = 1e3 * box.max() + Vec3::Constant(kMargin),
             size = high - low;
  const double scale = std::min(720.0 / (size.x() + size.z()), 460.0 / size.y()), edge = 1e3 * pane;
  Drawing drawing;
  addBars(study, bars, drawing);
  drawing.rod(Vec3(0.0, 0.0, 0.004), handle, viewer::kHandle, 8.0);
  std::vector<double> xs, ys;
  std::vector<std::string> names;
  for (std::size_t p = 0; p < study.plan.points(); ++p) {
    const Vec3 at = 1e3 * queryPoint(study.plan, p);
    xs.push_back(at.x());
    ys.push_back(at.y());
    names.push_back(pointText(study, p) + " mm");
  }
  const auto joints = [&drawing](int across) {
    return Json{{"type", "points"},
                {"x", numbers(drawing.joints[across])},
                {"y", numbers(drawing.joints[1])},
                {"colour", colourText(viewer::kInk)},
                {"size", 50}};
  };
  Json wall = rectangle(-edge, edge, -edge, edge), side = rectangle(0.0, 0.0, -edge, edge);
  wall["colour"] = colourText(viewer::kEnamel);
  side["colour"] = colourText(viewer::kEnamelEdge);
  side["width"] = 3;
  const Json points{{"type", "points"},
                    {"x", numbers(xs)},
                    {"y", numbers(ys)},
                    {"texts", names},
                    {"colour", colourText(viewer::kVermilion)},
                    {"size", std::min(16.0, 700.0 / study.plan.grid)}};
  const auto view = [&](const char* title, const char* name, Json layers, int i) {
    const int across = i == 0 ? 0 : 2;
    layers.push_back({{"type", "segments"}, {"segments", drawing.segments[i]}});
    layers.push_back(joints(across));
    if (i == 0) layers.push_back(points);
    layers.push_back({{"type", "texts"}, {"texts", drawing.texts[i]}});
    Json y = axis("y (mm)", low.y(), high.y());
    y["numbers"] = i == 0;
    return panel(title, std::round(scale * size[across]), std::round(scale * size.y()),
                 axis(name, low[across], high[across]), y, layers);
  };
  const Json front = view("facing the wall", "x (mm)",
                          Json::array({{{"type", "cells"}, {"cells", Json::array({wall})}}}), 0),
             aside = view("from the side", "z (mm)",
                          Json::array({{{"type", "segments"}, {"segments", Json::array({side})}}}), 1);
  return {"fig06-device", figure("the device and the query points", 2, Json::array(), {front, aside}),
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
  Json time = axis("time (s)", kShownFrom, plan.setup.duration), z = axis("z (mm)");
  time["numbers"] = false;
  z["share"] = "z";
  Json panels =
      Json::array({panelOf(r.force.title, kPanelHigh, time, axis("force (N)"), Json::array({r.force.drawn()}))});
  std::vector<std::string> deepest;
  for (const Curve& depth : r.depths) {
    time["numbers"] = &depth == &r.depths.back();
    panels.push_back(panelOf(depth.title, kPanelHigh, time, z, Json::array({depth.drawn()})));
    deepest.push_back(fmt::format("{} mm ({}{})", numberText(-depth.low, 2), escape(depth.title),
                                  depth.lost ? ": the run was lost there" : ""));
  }
  panels.push_back(closeUp(step, r, plan.setup.duration));
  return {
      fmt::format("fig0{}-response-{}", step ? 8 : 9, scenario),
      figure(fmt::format("responses in scenario {}", scenario), 1, legendOf(study), panels),
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
  constexpr unsigned kColours[] = {viewer::kVermilion, viewer::kBlue};
  Json layers = Json::array(), legend = Json::array();
  for (int i = 0; i < 2; ++i) {
    Curve torque{"at " + pointText(study, shown[i]) + " mm", {kColours[i], {}, 1.6}, {}, {}};
    StudyRun run = runAt(study.plan, 0);
    run.scenario = 1;
    run.column = hold;
    run.point = shown[i];
    run.force = kForce;
    (void)performRun(study.plan, run, [&](const TickRecord& t) {
      if (t.time >= kFrom && t.time <= kTo) torque.add(t.time, t.torque[last]);
    });
    layers.push_back(torque.drawn());
    legend.push_back(entry(torque.title, torque.style));
  }
  return {"fig11-torque",
          figure("torque at two query points", 1, legend,
                 Json::array({panel("", kPanelWide, 270, axis("time (s)", kFrom, kTo),
                                    axis(fmt::format("torque of joint {} (N m)", last + 1)), layers)})),
          fmt::format(
              "Torque of joint {} under a step of {:.0f} N at 1 s with {}, at two query points with the same noise "
              "(after the paper's Fig. 11). The figure shows at which point the torque is larger. The motor's limit is "
              "{} N m.",
              last + 1, kForce, escape(study.labels[hold].title), givenText(study.mechanism->limits().effort[last]))};
}

}  // namespace enamel::app
