#include "study/figures.hpp"

#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "enamel/control/impedance_map.hpp"
#include "enamel/core/file.hpp"

extern char** environ;

namespace enamel::app {
namespace {

// Colours that colour-blind people can tell apart (Okabe and Ito 2008).
constexpr const char* kBlue = "#0072B2";
constexpr const char* kVermilion = "#D55E00";
constexpr const char* kGreen = "#009E73";
constexpr const char* kOrange = "#E69F00";
constexpr const char* kInk = "#1F262E";
constexpr const char* kMuted = "#66707C";

constexpr const char* kPurple = "#CC79A7";

const char* colourOf(ColumnKind kind) {
  switch (kind) {
    case ColumnKind::positionControl: return kBlue;
    case ColumnKind::hold: return kGreen;
    case ColumnKind::impedance: return kVermilion;
    case ColumnKind::passivity: return kMuted;
    case ColumnKind::scheduled: return kOrange;
    case ColumnKind::edge:
    case ColumnKind::rival:
    case ColumnKind::plugin: break;
  }
  return kPurple;
}

// ---- axes --------------------------------------------------------------------------------------------------------

// Steps of 1, 2 or 5 times a power of ten, about `count` of them.
double niceStep(double span, int count) {
  const double raw = span / count, power = std::pow(10.0, std::floor(std::log10(raw)));
  return raw < 1.5 * power ? power : raw < 3.5 * power ? 2.0 * power : raw < 7.5 * power ? 5.0 * power : 10.0 * power;
}

Json axis(const std::string& title, double low, double high, int count = 5) {
  Json json{{"title", title}, {"range", {low, high}}, {"ticks", Json::array()}, {"labels", Json::array()}};
  const double step = niceStep(high - low, count);
  for (auto i = std::llround(std::ceil(low / step - 1e-9)); static_cast<double>(i) * step <= high + 1e-9 * step; ++i) {
    json["ticks"].push_back(static_cast<double>(i) * step);
    json["labels"].push_back(fmt::format("{:.6g}", static_cast<double>(i) * step));
  }
  return json;
}

// Logarithmic: places are powers of ten, labels at 1, 2 and 5 of each decade (or the decades alone).
Json logAxis(const std::string& title, double low, double high, double scale = 1.0) {
  Json json{{"title", title}, {"range", {low, high}}, {"ticks", Json::array()}, {"labels", Json::array()}};
  for (int decade = static_cast<int>(std::floor(low)); decade <= high; ++decade)
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double place = decade + std::log10(factor);
      if (place < low - 1e-9 || place > high + 1e-9 || (high - low > 2.2 && factor != 1.0)) continue;
      json["ticks"].push_back(place);
      json["labels"].push_back(fmt::format("{:.6g}", scale * std::pow(10.0, place)));
    }
  return json;
}

Json without(Json axisJson) {  // an axis that shares its numbers with the one below or beside it
  axisJson["title"] = "";
  for (Json& label : axisJson["labels"]) label = "";
  return axisJson;
}

struct Extent {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void see(double value) {
    if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
  }
  void widen(double share) {
    if (!(low <= high)) low = 0.0, high = 1.0;
    const double more = high > low ? share * (high - low) : 0.05 * std::max(1e-3, std::abs(high));
    low -= more;
    high += more;
  }
};

Json curve(const char* colour, bool dashed = false, double width = 3.0) {
  return {{"x", Json::array()}, {"y", Json::array()}, {"colour", colour}, {"dash", dashed}, {"width", width}};
}

Json entry(const std::string& name, const char* colour, bool dashed = false) {
  return {{"name", name}, {"colour", colour}, {"dash", dashed}};
}

Json horizontal(double low, double high, double y, const char* colour) {
  Json line = curve(colour, true, 2.0);
  line["x"] = {low, high};
  line["y"] = {y, y};
  return line;
}

// ---- Fig. 6: the device and the query points -----------------------------------------------------------------------

Figure sceneFigure(const Study& study) {
  const std::vector<Bar> bars = study.mechanism->bars(Pose{});
  const auto vec = [](const Vec3& v) { return Json{v.x(), v.y(), v.z()}; };
  Json scene;
  const auto rod = [&](const Vec3& from, const Vec3& to, double radius, const char* colour) {
    scene["rods"].push_back({{"from", vec(from)}, {"to", vec(to)}, {"radius_mm", radius}, {"colour", colour}});
  };
  const auto ball = [&](const Vec3& at, double radius, const char* colour) {
    scene["balls"].push_back({{"at", vec(at)}, {"radius_mm", radius}, {"colour", colour}});
  };
  const auto label = [&](const Vec3& at, const std::string& text, double dx, double dy, const char* colour = kInk) {
    scene["labels"].push_back({{"at", vec(at)}, {"text", text}, {"offset", {dx, dy}}, {"colour", colour}});
  };
  // Link after link of a chain becomes thinner and lighter; joints go to the chains in turn.
  int chains = 0;
  for (const Bar& bar : bars) chains = std::max(chains, bar.chain + 1);
  std::vector<int> links(static_cast<std::size_t>(chains), 0);
  std::vector<Vec3> tips(static_cast<std::size_t>(chains), Vec3::Zero());
  for (const Bar& bar : bars) {
    if (bar.chain < 0) continue;
    const int link = links[static_cast<std::size_t>(bar.chain)]++;
    tips[static_cast<std::size_t>(bar.chain)] = bar.to;
    rod(bar.from, bar.to, link == 0 ? 4.0 : 3.4, link == 0 ? "#55606E" : "#8C97A4");
    ball(bar.to, 5.0, "#333C47");
    if (link > 0) continue;
    ball(bar.from, 8.0, "#333C47");
    std::string text = fmt::format("chain {}:", bar.chain + 1);
    const int each = study.mechanism->joints() / chains;
    for (int j = 0; j < each; ++j) text += fmt::format("{} q{}", j > 0 ? "," : "", bar.chain * each + j + 1);
    label(bar.from, text, bar.from.x() < -0.02 ? -110.0 : 64.0, bar.from.x() < -0.02 ? -60.0 : 10.0, kMuted);
  }
  for (const Vec3& tip : tips) rod(tip, Vec3(0.0, 0.0, 0.010), 3.0, "#6C7785");
  rod(Vec3(0, 0, 0.004), Vec3(0, 0, 0.062), 6.0, "#2F6F73");
  const double w = study.plan.halfWidth, pane = w + 0.004;
  scene["faces"].push_back(
      {{"corners", {{-pane, -pane, 0}, {pane, -pane, 0}, {pane, pane, 0}, {-pane, pane, 0}}}, {"colour", "#F3EAD6"}});
  scene["faces"].push_back(
      {{"corners", {{pane, -pane, 0}, {-pane, -pane, 0}, {-pane, pane, 0}, {pane, pane, 0}}}, {"colour", "#F3EAD6"}});
  const double corners[4][2] = {{-pane, -pane}, {pane, -pane}, {pane, pane}, {-pane, pane}};
  for (int i = 0; i < 4; ++i)
    scene["lines"].push_back({{"from", {corners[i][0], corners[i][1], 0.0}},
                              {"to", {corners[(i + 1) % 4][0], corners[(i + 1) % 4][1], 0.0}},
                              {"colour", "#9C8A5E"},
                              {"width", 2.0}});
  for (std::size_t p = 0; p < study.plan.points(); ++p)
    ball(queryPoint(study.plan, p), study.plan.grid <= 15 ? 0.9 : 0.5, kVermilion);
  Eigen::AlignedBox<double, 3> box(Vec3(-pane, -pane, 0.0), Vec3(pane, pane, 0.062));
  for (const Bar& bar : bars) box.extend(bar.from).extend(bar.to);
  const Vec3 origin = box.min().cwiseMin(Vec3(0, 0, 0)).cwiseProduct(Vec3(1, 1, 0)) - Vec3(0.02, 0.02, 0.0);
  const char* axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const Vec3 tip = origin + 0.035 * Vec3::Unit(i);
    rod(origin, tip, 0.9, kInk);
    scene["cones"].push_back(
        {{"from", vec(tip + 0.007 * Vec3::Unit(i))}, {"to", vec(tip)}, {"radius_mm", 2.2}, {"colour", kInk}});
    label(tip + 0.010 * Vec3::Unit(i), axes[i], i == 2 ? -24.0 : 0.0, i == 1 ? 0.0 : 14.0);
  }
  label(Vec3(pane, -pane, 0.0), "wall z = 0", -190.0, 44.0, "#7A6A3E");
  const Vec3 focus = box.center();
  const double height = 1.3 * std::max(box.sizes().head<2>().norm() / 1.6, box.sizes().y() + 0.4 * box.sizes().z());
  scene["camera"] = {{"eye", vec(focus + Vec3(0.36, 0.24, 0.61))}, {"focus", vec(focus)}, {"height", height}};
  Figure figure{"fig06-scene", "", {}};
  figure.caption = fmt::format(
      "The device at home and the {} query points on the wall z = 0 (after Fig. 6): x and y from {:.4g} to "
      "{:.4g} mm.",
      study.plan.points(), -1e3 * w, 1e3 * w);
  figure.description = {{"size", {1600, 1000}}, {"scene", scene}};
  return figure;
}

// ---- Fig. 8, 9: typical responses -----------------------------------------------------------------------------------

Figure responseFigure(const Study& study, int scenario) {
  const StudyPlan& plan = study.plan;
  const double from = 0.9, to = plan.setup.duration;
  // Away from home, where nothing is special.
  const auto side = static_cast<std::size_t>(plan.grid), middle = (7 * side / 10) * side + side / 4;
  Json force = curve(kInk, false, 2.0), panels = Json::array();
  struct Response {
    std::string title;
    const char* colour;
    Json depth;
    Extent extent;
  };
  std::vector<Response> responses;
  Extent forceExtent;
  StudyRun run;
  for (std::size_t c = 0; c < plan.columns.size(); ++c) {
    // The scheduled hold would lie on the other.
    if (study.labels[c].kind == ColumnKind::scheduled && study.column(ColumnKind::hold) < plan.columns.size()) continue;
    Extent extent;
    Json depth = curve(colourOf(study.labels[c].kind), false, 2.5);
    for (std::size_t i = 0; i < plan.size(); ++i) {
      run = runAt(plan, i);
      if (run.scenario == scenario && run.column == c && run.point == middle) break;
    }
    (void)performRun(plan, run, [&](const TickRecord& t) {
      if (t.time < from) return;
      depth["x"].push_back(t.time);
      depth["y"].push_back(1e3 * t.pose.position.z());
      extent.see(1e3 * t.pose.position.z());
      if (!responses.empty()) return;
      force["x"].push_back(t.time);
      force["y"].push_back(-t.person[2]);
      forceExtent.see(-t.person[2]);
    });
    responses.push_back({study.labels[c].title, colourOf(study.labels[c].kind), depth, extent});
  }
  const int rows = 1 + static_cast<int>(responses.size());
  const double height = 300.0, gap = 44.0, left = 190.0, width = 1350.0;
  int row = 0;
  const auto add = [&](const std::string& title, Extent extent, Json curves, Json legend) {
    extent.widen(0.08);
    const bool last = row + 1 == rows;
    Json x = axis("time (s)", from, to, 10);
    Json panel{{"place", {left, 24.0 + row * (height + gap), width, height}},
               {"x", last ? x : without(x)},
               {"y", axis(title, extent.low, extent.high, 4)},
               {"curves", std::move(curves)}};
    if (!legend.is_null()) panel["legend"] = std::move(legend);
    panels.push_back(panel);
    ++row;
  };
  add("force (N)", forceExtent, Json::array({force}), nullptr);
  for (const Response& response : responses)
    add("z (mm)", response.extent, Json::array({horizontal(from, to, 0.0, kMuted), response.depth}),
        {{"corner", "bottom right"}, {"entries", Json::array({entry(response.title, response.colour)})}});
  Figure figure{fmt::format("fig0{}-response-{}", scenario == 1 ? 8 : 9, scenario), "", {}};
  figure.caption = fmt::format(
      "Scenario {}: a typical run at {} mm, F<sub>c</sub> = {:.1f} N (after Fig. {}). Top: the person's force into the "
      "wall; below: position of the tool with each renderer, the wall at 0 (dashed). Their scales differ.",
      scenario, pointText(study, middle), run.force, scenario == 1 ? 8 : 9);
  figure.description = {{"size", {1600, static_cast<int>(24 + rows * height + (rows - 1) * gap + 116)}},
                        {"panels", panels}};
  return figure;
}

// ---- maps over the wall
// -----------------------------------------------------------------------------------------------

Json mapCells(const Study& study, const std::vector<double>& values, double low, double high) {
  const double half = 1e3 * study.plan.halfWidth,
               step = study.plan.grid > 1 ? 2.0 * half / (study.plan.grid - 1) : 2.0 * half;
  const double edge = study.plan.grid > 1 ? -half - 0.5 * step : -half;
  Json cells{{"x", {edge, step}},       {"y", {edge, step}},    {"columns", study.plan.grid},
             {"values", Json::array()}, {"scale", {low, high}}, {"palette", "viridis"}};
  for (const double value : values) cells["values"].push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  return cells;
}

struct MapRow {
  std::vector<std::vector<double>> values;  // a map a column
  Json bar;                                 // axis of the colour bar
};

// Rows of maps, a column a renderer, one colour scale a row.
Json mapPanels(const Study& study, const std::vector<std::string>& titles, const std::vector<MapRow>& rows,
               Json& size) {
  const double side = 370.0, gap = 44.0, left = 140.0, top = 62.0, between = 60.0;
  const double half = 1e3 * study.plan.halfWidth,
               step = study.plan.grid > 1 ? 2.0 * half / (study.plan.grid - 1) : 2.0 * half;
  const double edge = study.plan.grid > 1 ? half + 0.5 * step : half;
  Json panels = Json::array();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double y = top + static_cast<double>(r) * (side + between);
    const double low = rows[r].bar.at("range")[0], high = rows[r].bar.at("range")[1];
    for (std::size_t c = 0; c < titles.size(); ++c) {
      Json xAxis = axis("x (mm)", -edge, edge, 5), yAxis = axis("y (mm)", -edge, edge, 5);
      Json panel{{"place", {left + static_cast<double>(c) * (side + gap), y, side, side}},
                 {"x", r + 1 == rows.size() ? xAxis : without(xAxis)},
                 {"y", c == 0 ? yAxis : without(yAxis)},
                 {"cells", mapCells(study, rows[r].values[c], low, high)}};
      if (r == 0) panel["title"] = titles[c];
      panels.push_back(panel);
    }
    // The colour bar.
    Json bar = rows[r].bar, cells{{"x", {0.0, 1.0}},
                                  {"columns", 1},
                                  {"values", Json::array()},
                                  {"scale", {low, high}},
                                  {"palette", "viridis"}};
    constexpr int kSteps = 128;
    cells["y"] = {low, (high - low) / kSteps};
    for (int i = 0; i < kSteps; ++i) cells["values"].push_back(low + (high - low) * (i + 0.5) / kSteps);
    bar["side"] = "right";
    panels.push_back({{"place", {left + static_cast<double>(titles.size()) * (side + gap) - 10.0, y, 34.0, side}},
                      {"x", {{"range", {0.0, 1.0}}, {"ticks", Json::array()}, {"labels", Json::array()}}},
                      {"y", bar},
                      {"cells", cells}});
  }
  size = {static_cast<int>(left + static_cast<double>(titles.size()) * (side + gap) + 206.0),
          static_cast<int>(top + static_cast<double>(rows.size()) * (side + between) - between + 116.0)};
  return panels;
}

template <typename Value>
std::vector<double> valuesOf(const Study& study, const Findings& findings, int scenario, std::size_t column,
                             const Value& value) {
  std::vector<double> values(study.plan.points(), std::nan(""));
  for (const PointStatistics& p : findings.points)
    if (p.scenario == scenario && p.column == column) values[p.point] = value(p);
  return values;
}

std::vector<std::string> columnTitles(const Study& study) {
  std::vector<std::string> titles;
  for (const ColumnLabel& label : study.labels) titles.push_back(label.title);
  return titles;
}

Figure firstImpactMap(const Study& study, const Findings& findings) {
  MapRow absolute, relative;
  Extent extent, share;
  for (std::size_t c = 0; c < study.plan.columns.size(); ++c) {
    std::vector<double> k = valuesOf(study, findings, 1, c,
                                     [](const PointStatistics& p) { return p.of(&PushMetrics::firstStiffness).mean; });
    double sum = 0.0, count = 0.0;
    for (const double v : k)
      if (std::isfinite(v)) sum += v, count += 1.0;
    std::vector<double> percent = k;
    for (double& v : percent) share.see(v = 100.0 * (v / (sum / count) - 1.0));
    for (double& v : k) extent.see(v = std::log10(1e-3 * v));
    absolute.values.push_back(k);
    relative.values.push_back(percent);
  }
  extent.widen(0.02);
  share.widen(0.0);
  absolute.bar = logAxis("mean K_z1 (kN/m)", extent.low, extent.high);
  relative.bar = axis("from the wall's mean (%)", share.low, share.high, 5);
  Figure figure{"fig10-first-impact", "", {}};
  Json size;
  figure.description["panels"] = mapPanels(study, columnTitles(study), {absolute, relative}, size);
  figure.description["size"] = size;
  figure.caption = fmt::format(
      "Scenario 1: mean of K<sub>z1</sub> over the runs that have one of {} at each query point (after Fig. 10). {} "
      "Top: "
      "one logarithmic scale for all renderers; bottom: the difference from each renderer's mean over the wall, one "
      "scale for all.",
      study.plan.runs, kFirstImpactText);
  return figure;
}

Figure steadyMap(const Study& study, const Findings& findings, int scenario) {
  MapRow row;
  Extent extent;
  int unresolved = 0;
  for (std::size_t c = 0; c < study.plan.columns.size(); ++c) {
    std::vector<double> k = valuesOf(study, findings, scenario, c, [](const PointStatistics& p) {
      return p.steadyStiffness ? std::log10(1e-3 * *p.steadyStiffness) : std::nan("");
    });
    for (const double v : k) extent.see(v), unresolved += !std::isfinite(v);
    row.values.push_back(k);
  }
  extent.widen(0.02);
  row.bar = logAxis("K_zs (kN/m)", extent.low, extent.high);
  Figure figure{fmt::format("fig1{}-steady-{}", scenario == 1 ? 2 : 3, scenario), "", {}};
  Json size;
  figure.description["panels"] = mapPanels(study, columnTitles(study), {row}, size);
  figure.description["size"] = size;
  figure.caption = fmt::format(
      "Scenario {}: K<sub>zs</sub> = 1 / |mean C<sub>zs</sub>| at each query point (after Fig. {}), one logarithmic "
      "scale.{}",
      scenario, scenario == 1 ? 12 : 13,
      unresolved > 0
          ? fmt::format(" Grey: not resolved at {} points, the mean compliance is below two standard errors.",
                        unresolved)
          : "");
  return figure;
}

// ---- K_z1 along y, torques
// ----------------------------------------------------------------------------------------------

Figure alongYFigure(const Study& study, const Findings& findings) {
  const auto side = static_cast<std::size_t>(study.plan.grid);
  Json stiffness = Json::array(), stiffnessEntries = Json::array(), torque = Json::array(),
       torqueEntries = Json::array();
  Extent stiffnessExtent, torqueExtent;
  std::vector<double> ys;
  for (std::size_t i = 0; i < side; ++i) ys.push_back(1e3 * queryPoint(study.plan, i * side).y());
  for (std::size_t c = 0; c < study.plan.columns.size(); ++c) {
    const ColumnLabel& label = study.labels[c];
    if (label.kind == ColumnKind::impedance) continue;
    const bool dashed = label.kind == ColumnKind::scheduled;
    Json line = curve(colourOf(label.kind), dashed, 3.5);
    line["x"] = ys;
    const auto means = rowMeans(study, over(findings.survey[c], [](const SurveyPoint& p) { return p.stiffness; }));
    for (const double v : means) {
      const double percent = 100.0 * (v / spreadOf(means).mean - 1.0);
      line["y"].push_back(percent);
      stiffnessExtent.see(percent);
    }
    stiffness.push_back(line);
    stiffnessEntries.push_back(entry(label.title, colourOf(label.kind), dashed));
  }
  const std::size_t hold = study.column(ColumnKind::hold);
  const std::size_t shown = hold < study.plan.columns.size() ? hold : 0;
  struct JointCurve {
    std::string names;
    std::vector<double> peaks;
  };
  std::vector<JointCurve> joints;  // joints that work alike, as mirror images do, share one
  for (int joint = 0; joint < study.mechanism->joints(); ++joint) {
    const auto peaks =
        rowMeans(study, over(findings.survey[shown], [&](const SurveyPoint& p) { return p.peak[joint]; }));
    for (const double peak : peaks) torqueExtent.see(peak);
    const auto alike = std::find_if(joints.begin(), joints.end(), [&](const JointCurve& other) {
      return std::equal(peaks.begin(), peaks.end(), other.peaks.begin(),
                        [](double a, double b) { return std::abs(a - b) <= 0.005 * std::abs(b); });
    });
    if (alike == joints.end())
      joints.push_back({fmt::format("q{}", joint + 1), peaks});
    else
      alike->names += fmt::format(", q{}", joint + 1);
  }
  const char* const colours[] = {kBlue, kOrange, kGreen, kVermilion};
  for (std::size_t i = 0; i < joints.size(); ++i) {
    Json line = curve(colours[i % 4], i >= 4, 3.5);
    line["x"] = ys;
    line["y"] = joints[i].peaks;
    torque.push_back(line);
    torqueEntries.push_back(entry(joints[i].names, colours[i % 4], i >= 4));
  }
  stiffnessExtent.widen(0.1);
  torqueExtent.see(0.0);
  torqueExtent.widen(0.06);
  torqueExtent.low = 0.0;
  const double half = 1e3 * study.plan.halfWidth;
  Figure figure{"along-y", "", {}};
  figure.description["size"] = {1600, 690};
  figure.description["panels"] = {{{"place", {150, 80, 590, 490}},
                                   {"x", axis("y (mm)", -half, half, 5)},
                                   {"y", axis("K_z1 from its mean (%)", stiffnessExtent.low, stiffnessExtent.high, 5)},
                                   {"curves", stiffness},
                                   {"legend", {{"corner", "above"}, {"entries", stiffnessEntries}}}},
                                  {{"place", {960, 80, 590, 490}},
                                   {"x", axis("y (mm)", -half, half, 5)},
                                   {"y", axis("largest torque (N m)", 0.0, 1.08 * torqueExtent.high, 5)},
                                   {"curves", torque},
                                   {"legend", {{"corner", "above"}, {"entries", torqueEntries}}}}};
  figure.caption = fmt::format(
      "Without noise, means over x. Left: K<sub>z1</sub> for {:.0f} N along y, from each renderer's mean. Right: "
      "largest torque of each joint for "
      "{:.0f} N with {}; the motors' limit is {:.3g} N m.",
      kSurveyForce, kHardForce, study.labels[shown].title, study.mechanism->limits().torque.minCoeff());
  return figure;
}

Figure torqueFigure(const Study& study) {
  const std::size_t hold = study.column(ColumnKind::hold);
  const int last = study.mechanism->joints() - 1;
  const auto side = static_cast<std::size_t>(study.plan.grid);
  const std::size_t middle = side / 2, low = (side >= 5 ? 1 : 0) * side + middle,
                    high = (side - (side >= 5 ? 2 : 1)) * side + middle;
  constexpr double kForce = 13.0;  // N, as in the paper
  Json curves = Json::array(), entries = Json::array();
  Extent extent;
  const double from = 0.95, to = 1.4;
  const std::size_t shown[] = {low, high};
  for (int i = 0; i < 2; ++i) {
    StudyRun run = runAt(study.plan, 0);
    run.scenario = 1;
    run.column = hold;
    run.point = shown[i];
    run.force = kForce;
    Json line = curve(i == 0 ? kVermilion : kBlue, false, 3.0);
    (void)performRun(study.plan, run, [&](const TickRecord& t) {
      if (t.time < from || t.time > to) return;
      line["x"].push_back(t.time);
      line["y"].push_back(t.torque[last]);
      extent.see(t.torque[last]);
    });
    curves.push_back(line);
    entries.push_back(entry(fmt::format("query point {} mm", pointText(study, shown[i])), i == 0 ? kVermilion : kBlue));
  }
  extent.widen(0.1);
  Figure figure{"fig11-torque", "", {}};
  figure.description["size"] = {1600, 690};
  figure.description["panels"] = {
      {{"place", {170, 80, 1380, 490}},
       {"x", axis("time (s)", from, to, 9)},
       {"y", axis(fmt::format("torque of joint {} (N m)", last + 1), extent.low, extent.high, 5)},
       {"curves", curves},
       {"legend", {{"corner", "above"}, {"entries", entries}}}}};
  figure.caption = fmt::format(
      "Torque of joint {} under {:.0f} N at two query points with the same noise, {} (after Fig. 11). The "
      "motor's limit is {:.3g} N m.",
      last + 1, kForce, study.labels[hold].title, study.mechanism->limits().torque[last]);
  return figure;
}

// ---- the impedance wall's stability (RQ 2)
// -------------------------------------------------------------------------------

Figure stabilityFigure(const Study& study) {
  const WallDevice device = wallDeviceOf(study);
  std::vector<double> stiffnesses, dampings;
  constexpr int kColumns = 62, kRows = 40;
  const double k0 = std::log10(500.0), k1 = 5.0, b0 = -1.0, b1 = 2.0;
  const double dk = (k1 - k0) / kColumns, db = (b1 - b0) / kRows;
  for (int i = 0; i < kColumns; ++i) stiffnesses.push_back(std::pow(10.0, k0 + dk * (i + 0.5)));
  for (int i = 0; i < kRows; ++i) dampings.push_back(std::pow(10.0, b0 + db * (i + 0.5)));
  const std::vector<WallStability> map = mapWallStability(device, stiffnesses, dampings, {0, 1, 2, 3});
  Json panels = Json::array();
  const double side = 590.0, height = 400.0;
  for (int delay = 0; delay < 4; ++delay) {
    Json cells{{"x", {k0, dk}},
               {"y", {b0, db}},
               {"columns", kColumns},
               {"values", Json::array()},
               {"palette", {"#F0B27A", "#9CC9E6"}}};
    for (const WallStability& w : map)
      if (w.wall.delay == delay) cells["values"].push_back(w.stable ? 1 : 0);
    // b = K Ts / 2 + B, on axes of logarithms.
    Json bound = curve(kInk, false, 4.0);
    const double available = device.damping;
    for (int i = 0; i <= 200; ++i) {
      const double k = k0 + (k1 - k0) * i / 200.0, b = available - 0.5 * std::pow(10.0, k) * device.period;
      if (b < std::pow(10.0, b0)) {
        bound["x"].push_back(std::log10(2.0 * (available - std::pow(10.0, b0)) / device.period));
        bound["y"].push_back(b0);
        break;
      }
      bound["x"].push_back(k);
      bound["y"].push_back(std::log10(b));
    }
    const int column = delay % 2, row = delay / 2;
    Json x = logAxis("rendered stiffness K (kN/m)", k0, k1, 1e-3), y = logAxis("rendered damping B (N s/m)", b0, b1);
    Json panel{{"place", {150.0 + column * (side + 90.0), 120.0 + row * (height + 70.0), side, height}},
               {"title", delay == 0   ? "no delay"
                         : delay == 1 ? "1 tick of delay"
                                      : fmt::format("{} ticks of delay", delay)},
               {"x", row == 1 ? x : without(x)},
               {"y", column == 0 ? y : without(y)},
               {"cells", cells},
               {"curves", {bound}}};
    if (delay == 0)
      panel["legend"] = {{"corner", "above"},
                         {"lift", 106.0},
                         {"entries",
                          {{{"name", "stable"}, {"colour", "#9CC9E6"}, {"box", true}},
                           {{"name", "unstable"}, {"colour", "#F0B27A"}, {"box", true}},
                           entry("eq. 16", kInk)}}};
    panels.push_back(panel);
  }
  Figure figure{"impedance-stability", "", {}};
  figure.description["size"] = {1480, static_cast<int>(120 + 2 * height + 70 + 116)};
  figure.description["panels"] = panels;
  figure.caption = fmt::format(
      "Where a spring-damper wall is stable on this device (simulated: the motion after a push of 12 N dies out within "
      "3 s; effective mass {:.3g} kg, mechanical damping "
      "{:.3g} "
      "N s/m, ticks of {:.3g} ms), and the bound of eq. 16, b &gt; K T<sub>s</sub>/2 + |B|, left of and below the "
      "line. "
      "Eq. 16 says nothing about delay.",
      device.mass, device.damping, 1e3 * device.period);
  return figure;
}

// ---- speed against error
// ---------------------------------------------------------------------------------------------------

Figure convergenceFigure(const Convergence& c) {
  const struct {
    Integrator integrator;
    const char* colour;
  } shown[] = {
      {Integrator::semiImplicitEuler, kVermilion}, {Integrator::midpoint, kOrange}, {Integrator::rungeKutta4, kBlue}};
  Json metricCurves = Json::array(), pathCurves = Json::array(), entries = Json::array();
  Extent time, metric, path;
  for (const auto& s : shown) {
    Json metricLine = curve(s.colour, false, 3.0), pathLine = metricLine;
    for (const MethodError& m : c.methods) {
      if (m.method.integrator != s.integrator) continue;
      const double x = std::log10(1e3 * m.secondsPerSecond);
      if (!std::isfinite(m.worst) || !(m.worst > 0.0) || !(m.trajectory > 0.0)) continue;
      metricLine["x"].push_back(x);
      metricLine["y"].push_back(std::log10(m.worst));
      pathLine["x"].push_back(x);
      pathLine["y"].push_back(std::log10(m.trajectory));
      time.see(x);
      metric.see(std::log10(m.worst));
      path.see(std::log10(m.trajectory));
    }
    for (auto* list : {&metricCurves, &pathCurves}) {
      Json line = list == &metricCurves ? metricLine : pathLine, marks = line;
      marks["marks"] = true;
      marks["width"] = 1.0;
      list->push_back(line);
      list->push_back(marks);
    }
    entries.push_back(entry(nameOf(s.integrator), s.colour));
  }
  metric.see(std::log10(c.allowed));
  time.widen(0.12);
  metric.widen(0.08);
  path.widen(0.08);
  const auto powers = [](const std::string& title, const Extent& e) {
    Json json{{"title", title}, {"range", {e.low, e.high}}, {"ticks", Json::array()}, {"labels", Json::array()}};
    for (int i = static_cast<int>(std::ceil(e.low)); i <= e.high; i += 2) {
      json["ticks"].push_back(i);
      json["labels"].push_back(fmt::format("1e{}", i));
    }
    return json;
  };
  metricCurves.insert(metricCurves.begin(), horizontal(time.low, time.high, std::log10(c.allowed), kInk));
  Figure figure{"convergence", "", {}};
  figure.description["size"] = {1600, 700};
  const Json x = logAxis("processor time (ms per simulated s)", time.low, time.high);
  figure.description["panels"] = {{{"place", {180, 80, 570, 500}},
                                   {"x", x},
                                   {"y", powers("largest relative error of a metric", metric)},
                                   {"curves", metricCurves},
                                   {"legend", {{"corner", "above"}, {"entries", entries}}}},
                                  {{"place", {990, 80, 570, 500}},
                                   {"x", x},
                                   {"y", powers("largest error of position (m)", path)},
                                   {"curves", pathCurves}}};
  figure.caption = fmt::format(
      "Speed against error of the integration: 1, 2, 4 and 8 steps a tick from left to right, against {} with {} "
      "steps. "
      "Dashed: the error that is allowed, {:.2g} %.",
      nameOf(c.reference.integrator), c.reference.substeps, 100.0 * c.allowed);
  return figure;
}

std::string programBeside(const char* name) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? std::string() : (self.parent_path() / name).string();
}

}  // namespace

WallDevice wallDeviceOf(const Study& study) {
  const std::size_t spring = study.column(ColumnKind::impedance);
  const double damping = study.labels[spring < study.labels.size() ? spring : 0].damping;
  const Kinematics& home = study.mechanism->home();
  return {effectiveMass(home, home.pose.position, Vec3::UnitZ()), damping, study.plan.setup.period};
}

std::vector<Figure> figuresOf(const Study& study, const Findings& findings) {
  const auto has = [&study](int scenario) {
    return std::count(study.plan.scenarios.begin(), study.plan.scenarios.end(), scenario) > 0;
  };
  std::vector<Figure> figures;
  if (findings.whole) {
    figures.push_back(sceneFigure(study));
    for (const int scenario : study.plan.scenarios) figures.push_back(responseFigure(study, scenario));
    if (has(1)) figures.push_back(firstImpactMap(study, findings));
    if (study.plan.grid > 1) figures.push_back(alongYFigure(study, findings));
    if (study.column(ColumnKind::hold) < study.plan.columns.size()) figures.push_back(torqueFigure(study));
    for (const int scenario : study.plan.scenarios) figures.push_back(steadyMap(study, findings, scenario));
    if (wallDeviceOf(study).damping > 0.0) figures.push_back(stabilityFigure(study));
  }
  if (findings.convergence) figures.push_back(convergenceFigure(*findings.convergence));
  for (Figure& figure : figures) figure.description["name"] = figure.name;
  return figures;
}

std::string missingProgram() {
  const std::string program = programBeside("enamel-figures");
  return !program.empty() && access(program.c_str(), X_OK) == 0
             ? ""
             : "enamel-figures is not there (it is built where VTK is)";
}

std::string drawFigures(const std::vector<Figure>& figures, const std::string& folder) {
  std::string program = programBeside("enamel-figures");
  Json all;
  for (const Figure& figure : figures) all["figures"].push_back(figure.description);
  std::string input = folder + "/figures.json", output = folder;
  writeFile(input, all.dump());
  char* arguments[] = {program.data(), input.data(), output.data(), nullptr};
  pid_t child = 0;
  int status = 0;
  const bool ran = posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments, environ) == 0 &&
                   waitpid(child, &status, 0) == child;
  std::filesystem::remove(input);
  if (!ran || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return "enamel-figures could not draw them (its message is above)";
  return "";
}

}  // namespace enamel::app
