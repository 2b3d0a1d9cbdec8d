#include "study/figures.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"

namespace enamel::app {
namespace {

// ---- the impedance wall's stability (RQ 2) -------------------------------------------------------------------------

constexpr int kDelays = 4;
constexpr unsigned kStable = 0x9CC9E6, kUnstable = 0xF0B27A;

// Return the edges of `count` cells of a logarithmic axis.
std::vector<double> edgesOf(double low, double high, int count) {
  std::vector<double> edges;
  for (int i = 0; i <= count; ++i) edges.push_back(low * std::pow(high / low, static_cast<double>(i) / count));
  return edges;
}

std::vector<double> middlesOf(const std::vector<double>& edges, double scale) {
  std::vector<double> middles;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) middles.push_back(scale * std::sqrt(edges[i] * edges[i + 1]));
  return middles;
}

Figure stabilityFigure(const Study& study) {
  const WallDevice device = wallDeviceOf(study);
  const std::vector<double> ks = edgesOf(0.5, 100.0, 62), bs = edgesOf(0.1, 100.0, 40);  // kN/m, N s/m
  const std::vector<WallStability> map = mapWallStability(device, middlesOf(ks, 1e3), middlesOf(bs, 1.0), {0, 1, 2, 3});
  std::vector<double> boundKs, boundBs;  // eq. 16: b = K Ts / 2 + B
  for (int s = 0; s <= 200; ++s) {
    boundBs.push_back(bs.front() * std::pow(device.damping / bs.front(), s / 200.0));
    boundKs.push_back(1e-3 * 2.0 * (device.damping - boundBs.back()) / device.period);
  }
  Json panels = Json::array();
  std::vector<std::string> stiffest;
  for (int delay = 0; delay < kDelays; ++delay) {
    Json cells = Json::array();
    double most = 0.0;  // kN/m
    const std::size_t columns = ks.size() - 1;
    std::vector<const WallStability*> walls;
    for (const WallStability& w : map)
      if (w.wall.delay == delay) walls.push_back(&w);
    for (std::size_t from = 0, to = 0; from < walls.size(); from = to) {  // equal cells of a row are one box
      const std::size_t row = from / columns;
      while (to < walls.size() && to / columns == row && walls[to]->stable == walls[from]->stable) ++to;
      if (walls[from]->stable) most = std::max(most, 1e-3 * walls[to - 1]->wall.stiffness);
      const Json ends = numbers({ks[from % columns], ks[(to - 1) % columns + 1], bs[row], bs[row + 1]});
      cells.push_back({{"x0", ends[0]},
                       {"x1", ends[1]},
                       {"y0", ends[2]},
                       {"y1", ends[3]},
                       {"colour", colourText(walls[from]->stable ? kStable : kUnstable)}});
    }
    stiffest.push_back(most > 0.0 ? numberText(most, 2) : "none");
    Json x = axis("rendered stiffness K (kN/m)", ks.front(), ks.back(), true),
         y = axis("rendered damping B (N s/m)", bs.front(), bs.back(), true);
    x["numbers"] = delay >= 2;
    y["numbers"] = delay % 2 == 0;
    panels.push_back({{"title", "delay: " + delayText(delay == 0 ? "none" : fmt::format("constant:{}", delay))},
                      {"width", 345},
                      {"height", 220},
                      {"x", x},
                      {"y", y},
                      {"layers",
                       {{{"type", "cells"}, {"cells", cells}},
                        line("bound of eq. 16: K (kN/m)", numbers(boundKs), boundBs, {viewer::kInk, {}, 2.5})}}});
  }
  return {
      "impedance-stability",
      {{"label", "stability of a spring-damper wall"},
       {"columns", 2},
       {"legend",
        {entry("stable", {kStable}, true), entry("unstable", {kUnstable}, true),
         entry("bound of eq. 16", {viewer::kInk}, true)}},
       {"panels", panels}},
      fmt::format(
          "Stability of a wall that is rendered as a spring K with a damper B on this device. In simulation, the "
          "motion after a push of 12 N decays within 3 s (effective mass {} kg, mechanical damping {} N s/m, ticks of "
          "{} ms). Walls left of and below the bound of eq. 16 are passive. More walls are stable than eq. 16 allows, "
          "but delay, which eq. 16 ignores, makes them fewer: the largest stable K is {} kN/m at 0, 1, 2 and 3 ticks.",
          numberText(device.mass), givenText(device.damping), givenText(1e3 * device.period), join(stiffest, ", "))};
}

// ---- speed against error -------------------------------------------------------------------------------------------

Figure convergenceFigure(const Convergence& c) {
  const std::pair<Integrator, unsigned> shown[] = {{Integrator::semiImplicitEuler, viewer::kVermilion},
                                                   {Integrator::midpoint, viewer::kOrange},
                                                   {Integrator::rungeKutta4, viewer::kBlue}};
  Json left = Json::array(), right = Json::array(), legend = Json::array();
  left.push_back(level(c.allowed, dashed(viewer::kInk)));
  for (const auto& [integrator, colour] : shown) {
    std::vector<double> times, metrics, paths;
    for (const MethodError& m : c.methods) {
      if (m.method.integrator != integrator || !std::isfinite(m.worst) || !(m.worst > 0.0) || !(m.trajectory > 0.0))
        continue;
      times.push_back(1e3 * m.secondsPerSecond);
      metrics.push_back(m.worst);
      paths.push_back(m.trajectory);
    }
    legend.push_back(entry(nameOf(integrator), {colour}));
    for (const auto& [layers, ys] : {std::pair(&left, &metrics), std::pair(&right, &paths)}) {
      layers->push_back(line(nameOf(integrator), numbers(times), *ys, {colour, {}, 1.6}));
      layers->back()["marks"] = true;
    }
  }
  Json time = axis("processor time (ms per simulated s)", true);
  time["share"] = "time";
  const auto panel = [&time](const char* title, const Json& layers) {
    return Json{{"width", 330}, {"height", 270}, {"x", time}, {"y", axis(title, true)}, {"layers", layers}};
  };
  return {
      "convergence",
      {{"label", "speed against error"},
       {"columns", 2},
       {"legend", legend},
       {"panels", {panel("largest relative error of a metric", left), panel("largest error of position (m)", right)}}},
      fmt::format("Speed against error of the integration: 1, 2, 4 and 8 steps a tick from left to right, against "
                  "{} with {} steps; a method that misses an event is not drawn. Dashed: the allowed error, {} %. "
                  "The best method is the fastest below this line.",
                  nameOf(c.reference.integrator), c.reference.substeps, givenText(100.0 * c.allowed))};
}

}  // namespace

WallDevice wallDeviceOf(const Study& study) {
  const std::size_t spring = study.column(ColumnKind::impedance);
  const double damping = study.labels[spring < study.labels.size() ? spring : 0].damping;
  const Kinematics& home = study.mechanism->home();
  return {effectiveMass(home, home.pose.position, Vec3::UnitZ()), damping, study.plan.setup.period};
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
    const bool hasStep = std::count(scenarios.begin(), scenarios.end(), 1) > 0;
    figures.push_back(stiffnessBoxes(study, findings));
    figures.push_back(deviceFigure(study));
    for (const int scenario : scenarios) figures.push_back(responseFigure(study, scenario));
    if (hasStep) figures.push_back(firstImpactMap(study, findings));
    if (study.column(ColumnKind::hold) < study.plan.columns.size()) figures.push_back(torqueFigure(study));
    for (const int scenario : scenarios) figures.push_back(steadyMap(study, findings, scenario));
    if (wallDeviceOf(study).damping > 0.0) figures.push_back(stabilityFigure(study));
  }
  if (findings.convergence) figures.push_back(convergenceFigure(*findings.convergence));
  return figures;
}

}  // namespace enamel::app
