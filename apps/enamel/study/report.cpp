#include "study/report.hpp"

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "design_results.hpp"
#include "study/numbers.hpp"
#include "study/page.hpp"

namespace enamel::app {
namespace {

std::string percent(double share) { return numberText(100.0 * share) + " %"; }

const WallSummary* wallOf(const Study& study, const Findings& findings, int scenario, ColumnKind kind) {
  for (const WallSummary& w : findings.walls)
    if (w.scenario == scenario && w.column == study.column(kind)) return &w;
  return nullptr;
}

// ---- what was done -------------------------------------------------------------------------------------------------

std::string definitionOf(const Study& study, std::size_t column) {
  const ImpedanceOptions& spring = study.impedance;
  const std::string wall = fmt::format("a spring of {} N/m", givenText(spring.stiffness));
  switch (study.labels[column].kind) {
    case ColumnKind::positionControl:
      return "Enamel's own: a servo in contact space. It holds the tool on the wall's surface along the normal, "
             "pushes and never pulls, and lets the tool slide.";
    case ColumnKind::hold:
      return "the paper's proposal: a linear-quadratic servo with integrators, designed once at home, holds every "
             "joint where it was at the touch.";
    case ColumnKind::scheduled: return "hold with a servo designed at every query point instead of once at home.";
    case ColumnKind::impedance:
      return "the paper's baseline: " + wall +
             " (K_r) stands for the wall; its force follows from the depth of the tool.";
    case ColumnKind::passivity:
      return wall + " and a damper that takes back the energy that the spring was seen to make.";
    case ColumnKind::edge: return "a spring whose ticks are a quarter as long, as stiff as eq. 16 (below) allows.";
    case ColumnKind::rival: return "a rival law with the values that were found for this device and delay.";
    case ColumnKind::plugin: break;
  }
  return "a renderer from a shared library.";
}

void addTerms(Page& page, const Study& study) {
  const StudyPlan& plan = study.plan;
  const PushSetup& setup = plan.setup;
  const auto has = [&](int scenario) { return std::count(plan.scenarios.begin(), plan.scenarios.end(), scenario) > 0; };
  page.heading("What was done");
  page.paragraph(fmt::format(
      "A haptic device is a small robot that a person holds by its <b>tool</b>. Its <b>renderer</b> is the law that "
      "commands the motors at every <b>tick</b> ({} ms) so that the tool stops where it touches something that is not "
      "there: here <b>the wall</b>, the plane z = 0, with the person above it. At each of {} <b>query points</b> on "
      "the wall a person was simulated who pushes the tool into it, {} times with other forces and other noise, the "
      "same for every renderer.",
      givenText(1e3 * setup.period), plan.points(), plan.runs));
  std::vector<std::pair<std::string, std::string>> terms;
  terms.emplace_back(
      "Conditions",
      fmt::format("the delay from a measurement to the torque that answers it: {}; the person leans on the wall with "
                  "{} N before the push (preload); joint angles are {}; the random numbers are those of seed {}. Home "
                  "is the pose in the middle of the workspace, with the tool's centre at x = y = z = 0. A motor "
                  "saturates where it is asked for more than its limit. The guard stops a renderer that becomes "
                  "unsafe.",
                  delayText(study.options.delay), givenText(study.options.preload),
                  study.options.encoders ? "read in the steps of the encoders" : "known exactly", setup.seed));
  for (std::size_t c = 0; c < study.labels.size(); ++c)
    terms.emplace_back("Renderer: " + escape(study.labels[c].title), definitionOf(study, c));
  const std::string noise = givenText(setup.person.noise);
  if (has(1))
    terms.emplace_back(
        "Scenario 1",
        fmt::format("a step: at 1 s the person's force jumps to F_c, drawn evenly from {} to {} N for each run, and "
                    "stays, with white noise of {} N (standard deviation), to the end at {} s.",
                    givenText(plan.lowestForce), givenText(plan.highestForce), noise, givenText(setup.duration)));
  if (has(2))
    terms.emplace_back(
        "Scenario 2",
        fmt::format(
            "a hand: through a spring of {} N/m and a damper of {} N s/m its movement brings a force that rises "
            "smoothly from 1 s to 2 s to F_c{}; white noise of {} N from 2 s to the end at {} s.",
            givenText(kPaperGrip.stiffness), givenText(kPaperGrip.damping),
            has(1) ? "" : fmt::format(" ({} to {} N)", givenText(plan.lowestForce), givenText(plan.highestForce)),
            noise, givenText(setup.duration)));
  terms.emplace_back("Depth", "how far the tool's centre is inside the wall; penetration is the same.");
  if (has(1)) {
    terms.emplace_back(
        "First impact: D_z1 and K_z1",
        "D_z1 is the deepest point of the continuous motion, between ticks too, up to its first return, from the mean "
        "depth in the 0.1 s before the step; the stiffness K_z1 is the force then over D_z1. A push that rings, slips "
        "or never returns has none.");
    terms.emplace_back(
        "Share of the limit",
        "K_z1 over the largest that physics allows without a force sensor, for the push's force, preload and largest "
        "delay, and a step at the beginning of a tick; a shorter delay or a step inside a tick can exceed it.");
  }
  terms.emplace_back(
      "Steady state: D_zs, C_zs and K_zs",
      fmt::format("D_zs is the mean depth {}, signed; the compliance C_zs is D_zs over F_c; the stiffness K_zs is 1 "
                  "over the magnitude of the mean C_zs of a point's runs. That mean can be zero: a K_zs is resolved, "
                  "and given, only where it exceeds two standard errors.",
                  has(1) && has(2) ? "from 1 s (scenario 1) or 2 s (scenario 2) to the end"
                  : has(1)         ? "from 1 s to the end"
                                   : "from 2 s to the end"));
  terms.emplace_back(
      "Eq. 16 of the paper",
      "a rendered spring K_r with a damper B_r is passive (gives no energy that it has not received), and so stable, "
      "where b_m &gt; K_r T_s / 2 + |B_r|: b_m is the device's own damping along the wall's normal, T_s the tick.");
  terms.emplace_back(
      "a ± b",
      fmt::format(
          "a mean over the runs of a query point and its 95 % interval by Student's t, both rounded to the interval's "
          "second digit; “a (b to c)” is an interval with unequal arms. The lowest or highest of the {} points has "
          "the interval of its own mean, which does not count that it was chosen. What has no interval is no mean: "
          "the largest of all runs, or one simulation without noise.",
          plan.points()));
  page.terms(terms);
}

// ---- Table IV ------------------------------------------------------------------------------------------------------

const PointStatistics& pointOf(const Findings& findings, const WallSummary& wall, std::size_t point) {
  const auto found = std::find_if(findings.points.begin(), findings.points.end(), [&](const PointStatistics& p) {
    return p.scenario == wall.scenario && p.column == wall.column && p.point == point;
  });
  return *found;  // every wall has all of its points
}

void addTableFour(Page& page, const Study& study, const Findings& findings) {
  page.heading("Extreme values over the wall");
  struct Row {
    int scenario;
    bool lowest, first;
    const char* paper;
    const char* cosimulation;
  };
  const Row rows[] = {{1, true, true, "17 174", "16 743 (13 367)"},  {1, false, true, "3112.6", "5360.2"},
                      {1, true, false, "92 387", "34 306 (54 634)"}, {1, false, false, "6180.5", "6302.2"},
                      {2, true, false, "65 002", "22 463 (20 299)"}, {2, false, false, "6202.1", "6342.4"}};
  std::vector<std::string> head{"N/m", "paper", "paper, co-simulation"};
  const std::size_t none = study.labels.size();
  const bool paper = study.column(ColumnKind::hold) < none || study.column(ColumnKind::impedance) < none,
             scheduled = study.column(ColumnKind::scheduled) < none,
             ours = study.column(ColumnKind::positionControl) < none;
  if (paper) head.push_back("here, as in the paper (hold, impedance)");
  if (scheduled) head.push_back("here, hold designed at each point");
  if (ours) head.push_back("here, position control in contact space");
  std::vector<std::vector<std::string>> cells;
  for (const Row& row : rows) {
    if (std::count(study.plan.scenarios.begin(), study.plan.scenarios.end(), row.scenario) == 0) continue;
    std::vector<std::string> line{
        fmt::format("Scenario {}: {} K_z{} of the {}", row.scenario, row.lowest ? "lowest" : "highest",
                    row.first ? "1" : "s", row.lowest ? "servo" : "impedance"),
        row.paper, row.cosimulation};
    const auto measured = [&](ColumnKind kind) {
      const WallSummary* w = wallOf(study, findings, row.scenario, kind);
      if (w == nullptr) return std::string("–");
      const std::optional<Extreme>& e = row.first ? (row.lowest ? w->lowestFirst : w->highestFirst)
                                                  : (row.lowest ? w->lowestSteady : w->highestSteady);
      if (!e) return std::string(row.first ? "no run has one" : "unresolved");
      const PointStatistics& p = pointOf(findings, *w, e->point);
      std::string text =
          row.first ? meanText(p.of(&PushMetrics::firstStiffness)) : steadyText(p.of(&PushMetrics::steadyCompliance));
      text += " <small>at " + pointText(study, e->point) + " mm";
      if (!row.first && w->unresolved > 0)
        text += fmt::format("; {} of {} points unresolved", w->unresolved, study.plan.points());
      return text + "</small>";
    };
    if (paper) line.push_back(measured(row.lowest ? ColumnKind::hold : ColumnKind::impedance));
    if (scheduled) line.push_back(row.lowest ? measured(ColumnKind::scheduled) : "–");
    if (ours) line.push_back(row.lowest ? measured(ColumnKind::positionControl) : "–");
    cells.push_back(line);
  }
  page.table(
      head, cells,
      "The form of the paper's Table IV: lowest and highest of the query points' means, at (x, y). In brackets in the "
      "paper's co-simulation: with a random delay. The paper gives no intervals.");
  page.note(
      "The paper's servo is hold; position control is none of the paper's. The paper's device is not ours: compare "
      "magnitudes and order.");
}

// ---- more measures -------------------------------------------------------------------------------------------------

void addMeasures(Page& page, const Study& study, const Findings& findings) {
  page.heading("Beside the paper's metrics");
  for (const int scenario : study.plan.scenarios) {
    std::vector<const WallSummary*> walls;
    for (const WallSummary& w : findings.walls)
      if (w.scenario == scenario) walls.push_back(&w);
    std::vector<std::string> head{""};
    for (const WallSummary* w : walls) head.push_back(escape(study.labels[w->column].title));
    std::vector<std::vector<std::string>> rows;
    const auto row = [&](const std::string& name, const std::string& meaning, const auto& cell) {
      std::vector<std::string> cells{name + (scenario == study.plan.scenarios.front() && !meaning.empty()
                                                 ? " <small>" + meaning + "</small>"
                                                 : "")};
      for (const WallSummary* w : walls) cells.push_back(anyFinished(study, *w) ? cell(*w) : "–");
      rows.push_back(cells);
    };
    // The worst of the points' means, of a spread that a point has.
    const auto worst = [&](const auto& spread, bool lowest, double scale) {
      return [&findings, spread, lowest, scale](const WallSummary& w) {
        Spread found;
        for (const PointStatistics& p : findings.points) {
          if (p.scenario != w.scenario || p.column != w.column) continue;
          const Spread s = spread(p);
          if (std::isfinite(s.mean) && (found.count == 0 || (std::abs(s.mean) < std::abs(found.mean)) == lowest))
            found = s;
        }
        found.mean = std::abs(found.mean);
        return meanText(found, scale);
      };
    };
    const auto mean = [&](const MetricMember& member, const std::string& meaning, bool lowest = false) {
      const Metric& m = allMetrics()[indexOf(member)];
      row(fmt::format("{} {}, {}", lowest ? "lowest" : "largest", m.symbol, m.displayUnit), meaning,
          worst([member](const PointStatistics& p) { return p.of(member); }, lowest, m.displayScale));
    };
    row("plant's damping, N s/m",
        "mechanical, along z at home, of the device file and <code>--device-damping</code> together",
        [&](const WallSummary& w) { return givenText(study.labels[w.column].damping); });
    row("largest |C_zs|, µm/N", "of the mean",
        worst([](const PointStatistics& p) { return p.of(&PushMetrics::steadyCompliance); }, false, 1e6));
    row("lowest F_c / rms depth, N/m", "over the steady state, which cannot be zero by chance as D_zs can",
        worst([](const PointStatistics& p) { return p.forceOverRms; }, true, 1.0));
    row("lowest F_c / depth 95 %, N/m", "the depth that 95 % of the steady state's ticks stay below",
        worst([](const PointStatistics& p) { return p.forceOver95; }, true, 1.0));
    row("largest depth, mm", "of all runs", [](const WallSummary& w) { return numberText(1e3 * w.largestDepth); });
    row("largest drift, mm", "across the normal from the start, of all runs",
        [](const WallSummary& w) { return numberText(1e3 * w.drift); });
    mean(&PushMetrics::bounce, "the largest gap above the rest from the onset of the push on");
    mean(&PushMetrics::chatter, "standard deviation of the torque over the last second, the worst joint");
    mean(&PushMetrics::saturatedShare, "of all ticks: some motor gives all that it can");
    mean(&PushMetrics::tangentialForce, "rms of the rendered force across the normal in the steady state");
    if (scenario == 1) {
      row("uniformity of K_z1",
          fmt::format("(largest − smallest) / mean over the wall, without noise, F_c = {:.0f} N", kSurveyForce),
          [&](const WallSummary& w) {
            const double u = uniformityOf(findings.survey[w.column]);
            return std::isfinite(u) ? percent(u) : std::string("–");
          });
      mean(&PushMetrics::limitShare, "", true);
      row("runs without K_z1", "", [](const WallSummary& w) {
        const std::string without = withoutFirstText(w);
        return without.empty() ? std::string("0") : without;
      });
    }
    std::vector<std::string> lost{"runs lost"};
    for (const WallSummary* w : walls) lost.push_back(w->failed == 0 ? "0" : lostText(*w));
    rows.push_back(lost);
    page.table(head, rows,
               fmt::format("Scenario {}: the worst query point's mean, or where it says so the largest of all runs; a "
                           "run is lost where the device leaves its workspace or the guard stops it.",
                           scenario));
  }
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
        "<b>K_z1 along y.</b> The paper's rises with y. Here K_z1 of hold (no noise, {:.0f} N, means over x) {} from "
        "y = {} to {} mm: {} to {} kN/m.",
        kSurveyForce, trend(k.front(), k.back()), givenText(-1e3 * study.plan.halfWidth),
        givenText(1e3 * study.plan.halfWidth), numberText(1e-3 * k.front()), numberText(1e-3 * k.back())));
    Eigen::Index heaviest = 0;
    gravity.maxCoeff(&heaviest);
    items.push_back(fmt::format(
        "<b>Saturation.</b> {}Under {:.0f} N {}; the most loaded is joint {} with at most {:.2f} of {:.3g} N m. "
        "Gravity takes at most {:.3f} N m (joint {}{}). With motors that never saturate K_z1 changes by at most "
        "{:.2g} %: saturation {} the reason for the trend.",
        study.isTau() ? "The paper suspects joint 6, which carries most of its device's weight. " : "", kHardForce,
        saturatedText.empty() ? "no joint saturates" : "motors saturate (" + saturatedText + ")", most + 1, peak[most],
        limit, gravity[heaviest], heaviest + 1, study.isTau() ? fmt::format("; joint 6: {:.3f}", gravity[5]) : "",
        100.0 * unlimitedDifference, unlimitedDifference < 0.01 ? "is not" : "is part of"));
    // A correlation says which way, not why: the reason is given where the numbers are those that it predicts.
    std::string reason = fmt::format(
        "<b>Reason.</b> Over the wall K_z1 is correlated by {:.2f} with the device's effective mass (what a force "
        "along the normal has to move) and by {:.2f} with the inverse of the lever |dz/dq| of the joints{}.",
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
          "rest comes from a servo that was designed at home.",
          s.back() > s.front() ? "rises" : "falls", percent(std::abs(s.back() / s.front() - 1.0)),
          percent(std::abs(k.back() / k.front() - 1.0)), 100.0 * gone);
    }
    items.push_back(reason);
    const auto low = rowMeans(study, over(points, [&](const SurveyPoint& p) { return p.peak[joints - 1]; }));
    if (study.isTau())
      items.push_back(fmt::format(
          "<b>Joint 6.</b> {}: its largest torque under {:.0f} N is {:.3f} N m at the lowest y and {:.3f} N m at the "
          "highest.",
          low.front() > low.back() ? "As in the paper, it works harder at the bottom"
                                   : "Other than in the paper, it works harder at the top",
          kHardForce, low.front(), low.back()));
  }
  if (spring < none) {
    const std::vector<double> k = row(spring, stiffness);
    items.push_back(
        fmt::format("<b>Impedance.</b> {}: uniformity {} without noise; the first impact reaches {} of the {:.0f} N/m "
                    "that are rendered.",
                    uniformityOf(findings.survey[spring]) < 0.05 ? "As in the paper the map is flat"
                                                                 : "Other than in the paper the map is not flat",
                    percent(uniformityOf(findings.survey[spring])),
                    percent(spreadOf(k).mean / study.impedance.stiffness), study.impedance.stiffness));
  }
  for (const WallSummary& w : findings.walls) {
    if (w.column != hold || !w.lowestSteady) continue;
    items.push_back(fmt::format(
        "<b>K_zs, scenario {}.</b> Lowest {} N/m, the paper's is {} N/m: the servo's integrators take the mean "
        "penetration to zero, what is left is {}.",
        w.scenario, steadyText(pointOf(findings, w, w.lowestSteady->point).of(&PushMetrics::steadyCompliance)),
        w.scenario == 1 ? "92 387" : "65 002",
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
                    numberText(1e3 * m.secondsPerSecond), numberText(m.trajectory, 2),
                    std::isfinite(m.worst) ? numberText(m.worst, 2) : "other events",
                    m.worst < c.allowed ? "met" : "not met"});
  page.table({"integrator", "steps a tick", "ms per simulated s", "largest error of position, m",
              "largest relative error of a metric", fmt::format("below {:.2g} %", 100.0 * c.allowed)},
             rows,
             "Methods of integration between ticks; “other events” where a run misses an event of the reference.");
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
      "renderer and scenario; {} with half as many steps differs by {}. Processor time of one thread, whole loop.",
      nameOf(c.reference.integrator), c.reference.substeps, nameOf(c.reference.integrator),
      numberText(c.referenceError, 2)));
}

void addSettings(Page& page, const Study& study) {
  page.heading("Settings");
  std::vector<std::vector<std::string>> cells;
  const auto manifest = nlohmann::ordered_json::parse(study.manifest);
  for (const auto& [key, value] : manifest.items())
    cells.push_back({escape(key), value.is_string() ? escape(value.get<std::string>()) : escape(value.dump())});
  page.table({"setting", "value"}, cells, "Everything that the numbers depend on.");
}

}  // namespace

std::string reportOf(const Study& study, const Findings& findings, const std::vector<Figure>& figures) {
  Page page;
  const auto figure = [&](const std::string& prefix) {
    for (const Figure& f : figures)
      if (f.name.rfind(prefix, 0) == 0) page.figure(f.svg, f.caption);
  };
  if (findings.whole) {
    addTerms(page, study);
    figure("fig06");
    page.heading("Typical responses");
    figure("fig08");
    figure("fig09");
    if (!findings.claims.empty()) {
      page.heading("Does the paper's ordering hold here, for its servo (hold) and for position control?");
      std::vector<std::vector<std::string>> claims;
      for (const Claim& c : findings.claims)
        claims.push_back({escape(c.text), escape(c.measured), c.holds ? "holds" : "does not hold"});
      page.table({"claim", "measured", ""}, claims,
                 "The claims of the paper's section VI, each with its number at the worst query point.");
    }
    if (std::any_of(study.labels.begin(), study.labels.end(),
                    [](const ColumnLabel& label) { return label.kind != ColumnKind::plugin; }))
      addTableFour(page, study, findings);
    addMeasures(page, study, findings);

    page.heading("First impact over the wall");
    figure("fig10");
    addDifferences(page, study, findings);
    figure("along-y");
    figure("fig11");
    page.heading("Steady state over the wall");
    figure("fig12");
    figure("fig13");

    if (study.home) {
      page.heading("Requirements on the servo (the paper's Table II)");
      std::vector<std::vector<std::string>> rows;
      for (const Requirement& r : requirementsOf(*study.home, devicePlant(study.design, Pose{})))
        rows.push_back({escape(r.name), numberText(r.worst()) + " " + r.unit, givenText(r.limit) + " " + r.unit,
                        r.met() ? "met" : "not met"});
      page.table(
          {"requirement", "worst of joints or axes", "limit", ""}, rows,
          fmt::format("The servo of hold {}, on its linear model at home: steps of 0.01 rad, of 10 N and of 0.1 N m.",
                      study.gainFor != kHold ? "with the paper's weights, designed at home" : "from --gain"));
      page.note(fmt::format(
          "The limits do not fit each other (0.001 rad at a lever of 0.1 m is 0.1 mm, not 1 mm){}: <code>enamel "
          "design --tune</code> finds what ours can do.",
          study.gainFor != kHold ? ", and these weights were found for another device" : ""));
    }

    const WallDevice wall = wallDeviceOf(study);
    const double required = requiredDamping(study.impedance, wall.period);
    if (wall.damping > 0.0) {
      page.heading("How stiff can a spring be rendered?");
      figure("impedance-stability");
      const double passive = 2.0 * wall.damping / wall.period;
      std::string text = fmt::format("With {} N s/m of damping eq. 16 allows a spring of {} N/m.",
                                     givenText(wall.damping), givenText(passive));
      for (const ColumnKind kind : {ColumnKind::hold, ColumnKind::positionControl})
        if (const WallSummary* servo = wallOf(study, findings, 1, kind); servo && servo->lowestFirst) {
          const Spread& k = pointOf(findings, *servo, servo->lowestFirst->point).of(&PushMetrics::firstStiffness);
          text += fmt::format(
              " On a plant with {} N s/m {} stops the first impact with at least {} N/m, {} times as much{}.",
              givenText(study.labels[servo->column].damping), study.labels[servo->column].title, meanText(k),
              meanText(k, 1.0 / passive), kind == ColumnKind::hold ? " (research question 2)" : "");
        }
      page.paragraph(text);
    }
    if (study.column(ColumnKind::impedance) < study.labels.size())
      page.note(
          fmt::format("The spring of this study, {} N/m, needs more than {} N s/m (eq. 16); its plant has {} N s/m.",
                      givenText(study.impedance.stiffness), givenText(required), givenText(wall.damping)));
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
      fmt::format("{}; {} query points, {} runs each. After “A Position-Control Based Approach to Haptic Rendering of "
                  "Stiff Objects” (“the paper”), sections V and VI; the copy that Enamel follows names neither its "
                  "authors nor its year or DOI.",
                  escape(nameOf(study.device)), study.plan.points(), study.plan.runs));
}

}  // namespace enamel::app
