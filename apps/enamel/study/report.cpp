#include "study/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "design_results.hpp"
#include "enamel/core/file.hpp"
#include "study/page.hpp"

namespace enamel::app {
namespace {

std::string percent(double share, int digits = 1) { return fmt::format("{:.{}f} %", 100.0 * share, digits); }

const WallSummary* wallOf(const Study& study, const Findings& findings, int scenario, ColumnKind kind) {
  for (const WallSummary& w : findings.walls)
    if (w.scenario == scenario && w.column == study.column(kind)) return &w;
  return nullptr;
}

// ---- Table IV ------------------------------------------------------------------------------------------------------

void addTableFour(Page& page, const Study& study, const Findings& findings) {
  page.heading("Extreme values over the wall (the form of Table IV)");
  struct Row {
    int scenario;
    bool lowest, first;
    const char* paper;
    const char* cosimulation;
  };
  const Row rows[] = {{1, true, true, "17 174", "16 743 (13 367)"},  {1, false, true, "3 112.6", "5 360.2"},
                      {1, true, false, "92 387", "34 306 (54 634)"}, {1, false, false, "6 180.5", "6 302.2"},
                      {2, true, false, "65 002", "22 463 (20 299)"}, {2, false, false, "6 202.1", "6 342.4"}};
  std::vector<std::string> head{"N/m, at (x, y) mm", "paper", "paper, co-simulation (with delay)"};
  const std::size_t none = study.labels.size();
  const bool paper = study.column(ColumnKind::hold) < none || study.column(ColumnKind::impedance) < none,
             scheduled = study.column(ColumnKind::scheduled) < none,
             ours = study.column(ColumnKind::positionControl) < none;
  if (paper) head.push_back("Enamel, as in the paper (hold, impedance)");
  if (scheduled) head.push_back("Enamel, hold designed at each point");
  if (ours) head.push_back("Enamel, position control in contact space");
  std::vector<std::vector<std::string>> cells;
  for (const Row& row : rows) {
    std::vector<std::string> line{
        fmt::format("Scenario {}: {} K<sub>z{}</sub>, {}", row.scenario, row.lowest ? "lowest" : "highest",
                    row.first ? "1" : "s", row.lowest ? "servo" : "impedance"),
        row.paper, row.cosimulation};
    const auto measured = [&](ColumnKind kind) {
      const WallSummary* w = wallOf(study, findings, row.scenario, kind);
      if (w == nullptr) return std::string("–");
      const std::optional<Extreme>& e = row.first ? (row.lowest ? w->lowestFirst : w->highestFirst)
                                                  : (row.lowest ? w->lowestSteady : w->highestSteady);
      std::string text = e           ? fmt::format("{:.0f} at {}", e->value, pointText(study, e->point))
                         : row.first ? "no run has one"
                                     : "unresolved";
      if (!row.first && w->unresolved > 0)
        text += fmt::format(" <small>({} of {} points unresolved)</small>", w->unresolved, study.plan.points());
      return text;
    };
    if (paper) line.push_back(measured(row.lowest ? ColumnKind::hold : ColumnKind::impedance));
    if (scheduled) line.push_back(row.lowest ? measured(ColumnKind::scheduled) : "–");
    if (ours) line.push_back(row.lowest ? measured(ColumnKind::positionControl) : "–");
    cells.push_back(line);
  }
  page.table(head, cells);
  page.note(
      "“Lowest” and “highest” are those of the query points' means. The paper's servo is hold; position control is "
      "none of the paper's. The paper's device is not ours: compare magnitudes and order. K<sub>zs</sub> divides by a "
      "signed mean that can be zero, so it is given only where the mean compliance "
      "exceeds two standard errors; the table below has measures without that weakness. " +
      std::string(kFirstImpactText));
}

void addMeasures(Page& page, const Study& study, const Findings& findings) {
  page.heading("Beside the paper's metrics");
  std::vector<std::vector<std::string>> cells;
  for (const WallSummary& w : findings.walls) {
    const std::size_t c = w.column;
    const std::string without = withoutFirstText(w);
    const auto number = [any = anyFinished(study, w)](double value, const char* format) {
      return any && std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "–";
    };
    cells.push_back(
        {fmt::format("{}: {}", w.scenario, escape(study.plan.columns[c].name)),
         fmt::format("{:.3g}", study.labels[c].damping), number(1e3 * w.highestCompliance.value, "{:.3g}"),
         number(w.lowestOverRms, "{:.0f}"), number(w.lowestOver95, "{:.0f}"), number(1e3 * w.largestDepth, "{:.3f}"),
         number(1e3 * w.bounce, "{:.4f}"), number(w.chatter, "{:.3f}"), number(100.0 * w.saturatedShare, "{:.2f}"),
         number(w.tangentialForce, "{:.3f}"), number(1e3 * w.drift, "{:.2f}"),
         w.scenario == 1 && std::isfinite(uniformityOf(findings.survey[c])) ? percent(uniformityOf(findings.survey[c]))
                                                                            : "–",
         w.lowestShare ? percent(w.lowestShare->value) : "–",
         w.scenario != 1   ? "–"
         : without.empty() ? "0"
                           : without,
         fmt::format("{}", w.failed)});
  }
  const auto head = [](const MetricMember& member) {
    const Metric& m = allMetrics()[indexOf(member)];
    return fmt::format("{}, {}", m.symbol, m.displayUnit);
  };
  const auto perForce = [](const MetricMember& member) {
    return fmt::format("lowest mean F<sub>c</sub>/{}, N/m", allMetrics()[indexOf(member)].symbol);
  };
  page.table({"scenario: renderer", "its plant's damping, N s/m", "highest |mean C_zs|, mm/N",
              perForce(&PushMetrics::rmsDepth), perForce(&PushMetrics::depth95), head(&PushMetrics::largestDepth),
              head(&PushMetrics::bounce), head(&PushMetrics::chatter), head(&PushMetrics::saturatedShare),
              head(&PushMetrics::tangentialForce), head(&PushMetrics::drift), "uniformity of K_z1",
              "lowest share of limit", "runs without K_z1", "runs lost"},
             cells);
  page.note(fmt::format(
      "Damping: mechanical, along z at home, of the device file and --device-damping together. Means at the worst "
      "query "
      "point; depth and drift are the largest of all runs. Chatter: standard deviation of the "
      "torque over the last second, the worst joint. Uniformity: (largest - smallest) / mean of K<sub>z1</sub> over "
      "the "
      "wall, without noise, F<sub>c</sub> = {:.0f} N. Bounce: the largest gap above the rest from the onset of the "
      "push on. Share of limit: K<sub>z1</sub> over the largest that physics allows without a force sensor, for the "
      "push's force, preload and largest delay, and a step at the beginning of a tick; a shorter delay or a step "
      "inside a "
      "tick can exceed it. Runs lost: the device left its workspace.",
      kSurveyForce));
}

// ---- where the device differs
// ----------------------------------------------------------------------------------------

// How a value runs over a wall, lowest y against highest.
std::string trend(double low, double high) {
  return fmt::format("{} by {}", high > low ? "rises" : "falls", percent(std::abs(high / low - 1.0)));
}

void addDifferences(Page& page, const Study& study, const Findings& findings) {
  const std::size_t hold = study.column(ColumnKind::hold), spring = study.column(ColumnKind::impedance),
                    scheduled = study.column(ColumnKind::scheduled), none = study.plan.columns.size();
  if (study.plan.grid < 2) return;
  page.heading("Where this device differs from the paper's, and why");
  for (const auto& points : findings.survey)
    if (!std::isfinite(uniformityOf(points))) {
      page.paragraph("At some query points a push has no first impact: no trend is stated.");
      return;
    }
  std::vector<std::string> items;
  const auto stiffness = [](const SurveyPoint& p) { return p.stiffness; };
  const auto row = [&](std::size_t column, const auto& value) {
    return rowMeans(study, over(findings.survey[column], value));
  };
  if (hold < none) {
    const auto& points = findings.survey[hold];
    const std::vector<double> k = row(hold, stiffness),
                              unlimited = row(hold, [](const SurveyPoint&p) { return p.unlimited; });
    const std::vector<double> values = over(points, stiffness);
    const double withMass = correlation(values, over(points, [](const SurveyPoint&p) { return p.mass; })),
                 withLever = correlation(values, over(points, [](const SurveyPoint&p) { return 1.0 / p.lever; }));
    double unlimitedDifference = 0.0;
    for (const SurveyPoint& p : points)
      unlimitedDifference = std::max(unlimitedDifference, std::abs(p.unlimited / p.stiffness - 1.0));
    const int joints = study.mechanism->joints();
    JointVector peak = JointVector::Zero(joints), gravity = peak;
    std::vector<int> saturated(static_cast<std::size_t>(joints), 0);
    for (const SurveyPoint& p : points) {
      peak = peak.cwiseMax(p.peak);
      gravity = gravity.cwiseMax(p.gravity.cwiseAbs());
      for (int j = 0; j < joints; ++j) saturated[static_cast<std::size_t>(j)] += p.cutTicks[j] > 0.0;
    }
    Eigen::Index most = 0;
    peak.maxCoeff(&most);
    std::string saturatedText;
    for (int j = 0; j < joints; ++j)
      if (const int count = saturated[static_cast<std::size_t>(j)]; count > 0)
        saturatedText += fmt::format("{}joint {} at {} of {} points", saturatedText.empty() ? "" : ", ", j + 1, count,
                                     study.plan.points());
    const double limit = study.mechanism->limits().torque[most];
    items.push_back(fmt::format(
        "<b>K<sub>z1</sub> along y.</b> The paper's rises with y. Here K<sub>z1</sub> of hold (no noise, {:.0f} "
        "N, means over x) {} from y = {:.4g} to {:.4g} mm: {:.2f} to {:.2f} kN/m.",
        kSurveyForce, trend(k.front(), k.back()), -1e3 * study.plan.halfWidth, 1e3 * study.plan.halfWidth,
        1e-3 * k.front(), 1e-3 * k.back()));
    Eigen::Index heaviest = 0;
    gravity.maxCoeff(&heaviest);
    items.push_back(fmt::format(
        "<b>Saturation.</b> {}Under {:.0f} N {}; the most loaded is joint {} with at most {:.2f} of {:.3g} N m. "
        "Gravity "
        "takes at most {:.3f} N m (joint {}{}). With motors that never saturate K<sub>z1</sub> changes by at most "
        "{:.2g} "
        "%: saturation {} the reason for the trend.",
        study.isTau() ? "The paper suspects joint 6, which carries most of its device's weight. " : "", kHardForce,
        saturatedText.empty() ? "no joint saturates" : "motors saturate (" + saturatedText + ")", most + 1, peak[most],
        limit, gravity[heaviest], heaviest + 1, study.isTau() ? fmt::format("; joint 6: {:.3f}", gravity[5]) : "",
        100.0 * unlimitedDifference, unlimitedDifference < 0.01 ? "is not" : "is part of"));
    // A correlation says which way, not why: the reason is given where the numbers are those that it predicts.
    std::string reason = fmt::format(
        "<b>Reason.</b> Over the wall K<sub>z1</sub> is correlated by {:.2f} with the device's effective mass along "
        "the "
        "normal and by {:.2f} with the inverse of the lever |dz/dq| of the joints{}.",
        withMass, withLever,
        withMass > 0.7 && withLever > 0.7
            ? ": the servo is stiff in the joints, and the same joint stiffness holds less where the joints move the "
              "tool more"
            : "");
    if (scheduled < none) {
      const std::vector<double> s = row(scheduled, stiffness);
      const double gone = (s.back() / s.front() - 1.0) / (k.back() / k.front() - 1.0);
      reason += fmt::format(
          " A servo designed at every query point {} by {} instead of {}: {:.0f} % of the trend is the device's, the "
          "rest "
          "comes from a servo that was designed at home.",
          s.back() > s.front() ? "rises" : "falls", percent(std::abs(s.back() / s.front() - 1.0)),
          percent(std::abs(k.back() / k.front() - 1.0)), 100.0 * gone);
    }
    items.push_back(reason);
    const auto low = rowMeans(study, over(points, [&](const SurveyPoint& p) { return p.peak[joints - 1]; }));
    if (study.isTau())
      items.push_back(fmt::format(
          "<b>Joint 6.</b> {}: its largest torque under {:.0f} N is {:.3f} N m at the lowest y and {:.3f} N "
          "m at the highest.",
          low.front() > low.back() ? "As in the paper, it works harder at the bottom"
                                   : "Other than in the paper, it works harder at the top",
          kHardForce, low.front(), low.back()));
  }
  if (spring < none) {
    const std::vector<double> k = row(spring, stiffness);
    items.push_back(
        fmt::format("<b>Impedance.</b> {}: uniformity {} without noise; the first impact "
                    "reaches {} of the "
                    "{:.0f} N/m that are rendered.",
                    uniformityOf(findings.survey[spring]) < 0.05 ? "As in the paper the map is flat"
                                                                 : "Other than in the paper the map is not flat",
                    percent(uniformityOf(findings.survey[spring])),
                    percent(spreadOf(k).mean / study.impedance.stiffness, 0), study.impedance.stiffness));
  }
  for (const WallSummary& w : findings.walls) {
    if (w.column != hold || !w.lowestSteady) continue;
    items.push_back(fmt::format(
        "<b>K<sub>zs</sub>, scenario {}.</b> Lowest {:.3g} N/m, the paper's is {}: the servo's integrators take the "
        "mean "
        "penetration to zero, what is left is {}.",
        w.scenario, w.lowestSteady->value, w.scenario == 1 ? "92 387 N/m" : "65 002 N/m",
        w.scenario == 1 ? "the first impact averaged over 2 s"
        : w.unresolved > 0
            ? fmt::format("noise, so that {} of {} points are not resolved at all", w.unresolved, study.plan.points())
            : std::string("noise")));
  }
  page.list(items);
}

void addConvergence(Page& page, const Study& study, const Convergence& c) {
  std::vector<std::vector<std::string>> rows;
  for (const MethodError& m : c.methods)
    rows.push_back({nameOf(m.method.integrator), std::to_string(m.method.substeps),
                    fmt::format("{:.2f}", 1e3 * m.secondsPerSecond), fmt::format("{:.1e}", m.trajectory),
                    std::isfinite(m.worst) ? fmt::format("{:.1e}", m.worst) : "other events",
                    m.worst < c.allowed ? "met" : "not met"});
  page.table({"integrator", "steps a tick", "ms per simulated s", "largest error of position, m",
              "largest relative error of a metric", fmt::format("below {:.2g} %", 100.0 * c.allowed)},
             rows);
  const PushSetup& setup = study.plan.setup;
  if (c.cheapest < c.methods.size()) {
    const IntegrationMethod& m = c.methods[c.cheapest].method;
    const bool same = m.integrator == setup.integrator && m.substeps == setup.substeps;
    page.paragraph(fmt::format(
        "The cheapest with an error below {:.2g} % in every metric is {} with {} step{} a tick; the study uses {}.",
        100.0 * c.allowed, nameOf(m.integrator), m.substeps, m.substeps > 1 ? "s" : "",
        same ? "it: it is the default" : fmt::format("{} with {}", nameOf(setup.integrator), setup.substeps)));
  } else {
    page.paragraph(fmt::format("No method keeps the error of every metric below {:.2g} %.", 100.0 * c.allowed));
  }
  page.note(fmt::format(
      "Errors against {} with {} steps a tick, relative to the largest value of the metric over the runs of the same "
      "renderer and scenario; {} with half as many steps differs by {:.1e}. Processor time of one thread, whole loop.",
      nameOf(c.reference.integrator), c.reference.substeps, nameOf(c.reference.integrator), c.referenceError));
}

void addSettings(Page& page, const Study& study) {
  page.heading("Settings");
  std::vector<std::vector<std::string>> cells;
  const Json manifest = Json::parse(study.manifest);
  for (const auto& [key, value] : manifest.items())
    cells.push_back({escape(key), value.is_string() ? escape(value.get<std::string>()) : escape(value.dump())});
  page.table({"setting", "value"}, cells);
}

}  // namespace

std::string reportOf(const Study& study, const Findings& findings, const std::vector<Figure>& figures,
                     const std::string& folder, const std::string& withoutFigures) {
  Page page;
  const auto figure = [&](const std::string& prefix) {
    for (const Figure& f : figures) {
      if (f.name.rfind(prefix, 0) != 0 || !withoutFigures.empty()) continue;
      page.figure(readFile(folder + '/' + f.name + ".png"), f.name, f.caption);
    }
  };
  if (!withoutFigures.empty()) page.note("Without figures: " + escape(withoutFigures) + ".");
  if (findings.whole) {
    if (!findings.claims.empty()) {
      page.heading("Does the paper's ordering hold here, for its servo (hold) and for position control?");
      std::vector<std::vector<std::string>> claims;
      for (const Claim& c : findings.claims)
        claims.push_back({escape(c.text), escape(c.measured), c.holds ? "holds" : "does not hold"});
      page.table({"claim", "measured", ""}, claims);
    }
    if (std::any_of(study.labels.begin(), study.labels.end(),
                    [](const ColumnLabel& label) { return label.kind != ColumnKind::plugin; }))
      addTableFour(page, study, findings);
    addMeasures(page, study, findings);

    page.heading("Set-up");
    figure("fig06");
    page.heading("Typical responses");
    figure("fig08");
    figure("fig09");
    page.heading("First impact over the wall");
    figure("fig10");
    addDifferences(page, study, findings);
    figure("along-y");
    figure("fig11");
    page.heading("Steady state over the wall");
    figure("fig12");
    figure("fig13");

    if (study.home) {
      page.heading("Requirements on the servo (Table II)");
      std::vector<std::vector<std::string>> rows;
      for (const Requirement& r : requirementsOf(*study.home, devicePlant(study.design, Pose{})))
        rows.push_back({escape(r.name), fmt::format("{:.4g} {}", r.worst(), r.unit),
                        fmt::format("{:.4g} {}", r.limit, r.unit), r.met() ? "met" : "not met"});
      page.table({"requirement", "worst of joints or axes", "limit", ""}, rows);
      page.note(fmt::format(
          "The servo of hold {}, on its linear model at home; steps of 0.01 rad, of 10 N and of 0.1 N m. The limits do "
          "not fit "
          "each other (0.001 rad at a lever of 0.1 m is 0.1 mm, not 1 mm){}: `enamel design --tune` finds what ours "
          "can "
          "do.",
          study.gainFor != kHold ? "with the paper's weights, designed at home" : "from --gain",
          study.gainFor != kHold ? ", and these weights were found for another device" : ""));
    }

    const WallDevice wall = wallDeviceOf(study);
    const double required = requiredDamping(study.impedance, wall.period);
    if (wall.damping > 0.0) {
      page.heading("How stiff can a spring be rendered?");
      figure("impedance-stability");
      const double passive = 2.0 * wall.damping / wall.period;
      std::string text =
          fmt::format("With {:.3g} N s/m of damping eq. 16 allows a spring of {:.0f} N/m.", wall.damping, passive);
      for (const ColumnKind kind : {ColumnKind::hold, ColumnKind::positionControl})
        if (const WallSummary* servo = wallOf(study, findings, 1, kind); servo && servo->lowestFirst)
          text += fmt::format(
              " On a plant with {:.3g} N s/m {} stops the first impact with at least {:.0f} N/m, {:.1f} times as "
              "much{}.",
              study.labels[servo->column].damping, study.labels[servo->column].title, servo->lowestFirst->value,
              servo->lowestFirst->value / passive, kind == ColumnKind::hold ? " (research question 2)" : "");
      page.paragraph(text);
    }
    if (study.column(ColumnKind::impedance) < study.labels.size())
      page.note(
          fmt::format("The spring of this study, {:.0f} N/m, needs more than {:.3g} N s/m (eq. 16); its plant has "
                      "{:.3g} N s/m.",
                      study.impedance.stiffness, required, wall.damping));
  }

  if (findings.convergence) {
    page.heading("Speed against error");
    figure("convergence");
    addConvergence(page, study, *findings.convergence);
  }
  addSettings(page, study);
  std::string title;
  for (const ColumnLabel& label : study.labels) title += (title.empty() ? "" : ", ") + label.title;
  return page.whole(
      findings.whole ? "On a stiff wall: " + escape(title) : "Speed against error of the integration",
      escape(fmt::format(
          "{}; {} query points, {} runs each, preload {} N, delay {}, encoders {}, seed {}. After “A Position-Control "
          "Based Approach to Haptic Rendering of Stiff Objects”, sections V and VI.",
          nameOf(study.device), study.plan.points(), study.plan.runs, study.options.preload, study.options.delay,
          study.options.encoders ? "on" : "off", study.plan.setup.seed)));
}

}  // namespace enamel::app
