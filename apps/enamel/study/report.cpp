#include "study/report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "design_results.hpp"
#include "study/numbers.hpp"
#include "study/pairs.hpp"

namespace enamel::app {
namespace {

// Add the figures whose names begin with `prefix`.
void addFigures(Page& page, const std::vector<Figure>& figures, const std::string& prefix) {
  for (const Figure& f : figures)
    if (f.name.rfind(prefix, 0) == 0) page.figure(f.name, f.plot, f.caption);
}

void addClaims(Page& page, const std::vector<Claim>& claims) {
  if (claims.empty()) return;
  page.heading("The paper's claims for its servo (hold) and for position control");
  std::vector<std::vector<std::string>> rows;
  for (const Claim& c : claims) rows.push_back({escape(c.text), escape(c.measured), c.verdict});
  page.table({"claim", "measured", ""}, rows,
             "The claims of the paper's section VI. A claim about query points holds only if the paired difference "
             "excludes the opposite at every one of them (Holm's p below 0.05).");
}

// The paper's Table II.
void addRequirements(Page& page, const Study& study) {
  page.heading("Requirements on the servo (the paper's Table II)");
  std::vector<std::vector<std::string>> rows;
  for (const Requirement& r : requirementsOf(*study.home, devicePlant(study.design, Pose{})))
    rows.push_back({escape(r.name), numberText(r.worst()) + " " + r.unit, givenText(r.limit) + " " + r.unit,
                    r.met() ? "met" : "not met"});
  page.table(
      {"requirement", "worst of joints or axes", "limit", ""}, rows,
      fmt::format("The servo of hold {}, on its linear model at home: steps of 0.01 rad, of 10 N and of 0.1 N m.",
                  study.options.gain.empty() ? "with the paper's weights, designed at home" : "from --gain"));
  page.note(
      fmt::format("The limits are inconsistent: 0.001 rad at a lever of 0.1 m is 0.1 mm, not 1 mm{}. <code>enamel "
                  "design --tune</code> finds the best servo for this device.",
                  study.options.gain.empty() ? ". The paper's weights were found for another device" : ""));
}

void addSpringLimits(Page& page, const Study& study, const std::vector<Figure>& figures) {
  const ImpedanceOptions& spring = study.options.impedance;
  const WallDevice wall = wallDeviceOf(study);
  if (wall.damping > 0.0) {
    page.heading("The stiffest passive spring");
    addFigures(page, figures, "impedance-stability");
    page.paragraph(fmt::format("With {} N s/m of damping eq. 16 allows a spring of {} N/m.", givenText(wall.damping),
                               givenText(2.0 * wall.damping / wall.period)));
  }
  if (study.column(ColumnKind::impedance) < study.labels.size())
    page.note(fmt::format(
        "The spring of this study, {} N/m, needs more than {} N s/m (eq. 16); its plant has {} N s/m.",
        givenText(spring.stiffness), givenText(requiredDamping(spring, wall.period)), givenText(wall.damping)));
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
             rows, "Methods of integration between ticks; “other events”: a run misses an event of the reference.");
  const PushSetup& setup = study.plan.setup;
  if (c.cheapest < c.methods.size()) {
    const IntegrationMethod& m = c.methods[c.cheapest].method;
    const bool same = m.integrator == setup.integrator && m.substeps == setup.substeps;
    page.paragraph(
        fmt::format("The cheapest method with an error below {:.2g} % in every metric is {} with {} step{} a tick; the "
                    "study uses {}.",
                    100.0 * c.allowed, nameOf(m.integrator), m.substeps, m.substeps > 1 ? "s" : "",
                    same ? "it by default" : fmt::format("{} with {}", nameOf(setup.integrator), setup.substeps)));
  } else {
    page.paragraph(fmt::format("No method keeps the error of every metric below {:.2g} %.", 100.0 * c.allowed));
  }
  page.note(fmt::format(
      "Errors against {} with {} steps a tick, relative to the largest value of the metric over the runs of the same "
      "renderer and scenario; {} with half as many steps differs by {}. The processor time is that of one thread for "
      "the whole loop.",
      nameOf(c.reference.integrator), c.reference.substeps, nameOf(c.reference.integrator),
      numberText(c.referenceError, 2)));
}

void addSettings(Page& page, const Study& study) {
  page.heading("Settings");
  std::vector<std::vector<std::string>> cells;
  const auto manifest = nlohmann::ordered_json::parse(study.manifest);
  for (const auto& [key, value] : manifest.items())
    cells.push_back({escape(key), value.is_string() ? escape(value.get<std::string>()) : escape(value.dump())});
  page.table({"setting", "value"}, cells, "All settings that the numbers depend on.");
}

// The first screen: what was compared, which is stiffer, by how much, where not, and what that assumes.
void addSummary(Page& page, const Study& study, const Findings& findings, const std::vector<Figure>& figures) {
  std::vector<std::string> names, items;
  for (const ColumnLabel& label : study.labels) names.push_back("<b>" + escape(label.title) + "</b>");
  page.paragraph(fmt::format(
      "Compared in simulation: {}, on a virtual wall. A simulated person pushes the tool into the wall at {} query "
      "points, {} times at each, with the same random forces for every renderer. Stiffness is the force of a push "
      "divided by the depth that the tool reaches in 0.1 s (K_d), or divided by the rms depth if a hand presses.",
      join(names, ", "), study.plan.points(), study.plan.runs));
  std::vector<std::string> worse;
  for (const PairedComparison& c : findings.pairs) {
    if (isStiffness(c.question)) items.push_back(stiffnessSentence(study, c));
    if (isStiffness(c.question) || c.verdict != PairedVerdict::worse) continue;
    const std::string text = std::string(allMetrics()[indexOf(c.question.metric)].symbol) + " (against " +
                             escape(study.labels[c.b].title) + ")";
    if (std::find(worse.begin(), worse.end(), text) == worse.end()) worse.push_back(text);
  }
  if (!worse.empty())
    items.push_back("Where " + escape(study.labels[referenceOf(study)].title) + " is worse: " + join(worse, ", ") +
                    ".");
  if (findings.pairs.empty()) items.emplace_back("One renderer: there is nothing to compare.");
  page.list(items);
  addFigures(page, figures, "stiffness");
  page.note(assumptionsOf(study) +
            " Intervals have 95 % and cover the random forces and noise at these query points, not other devices.");
  page.note("Command: <code class=\"command\">" + escape(shellText("study", study.options.arguments)) + "</code>");
  const auto device = Json::parse(study.manifest).at("device");
  page.note(
      fmt::format("Enamel {}, seed {}, device file with CRC-32 {}. <code>enamel study --verify FOLDER</code> repeats "
                  "a sample of the runs.",
                  ENAMEL_VERSION, study.plan.setup.seed, device.at("CRC-32").get<std::string>()));
  page.download("points.csv", pointsTable(study, findings.points));
}

// All sections except the convergence.
void addFindings(Page& page, const Study& study, const Findings& findings, const std::vector<Figure>& figures) {
  addSummary(page, study, findings, figures);
  addTerms(page, study);
  addFigures(page, figures, "fig06");
  page.heading("Typical responses");
  addFigures(page, figures, "fig08");
  addFigures(page, figures, "fig09");
  if (!findings.pairs.empty()) {
    page.heading("Paired differences");
    addPairs(page, study, findings.pairs,
             "Each run is paired with the run of the other renderer that has the same random numbers. A ratio is the "
             "geometric mean over pairs. Intervals: Student's t, for the mean over the query points. p: that the mean "
             "is zero, adjusted by Holm for all rows. d_z: mean over standard deviation of the differences at a point. "
             "A point counts as better or worse only if its p, adjusted for all points and renderers of the row's "
             "question, is below 0.05.");
  }
  addClaims(page, findings.claims);
  addMeasures(page, study, findings);
  page.heading("First impact over the wall");
  addFigures(page, figures, "fig10");
  addFigures(page, figures, "fig11");
  page.heading("Steady state over the wall");
  addFigures(page, figures, "fig12");
  addFigures(page, figures, "fig13");
  if (study.home) addRequirements(page, study);
  addSpringLimits(page, study, figures);
}

}  // namespace

std::string reportOf(const Study& study, const Findings& findings, const std::vector<Figure>& figures) {
  Page page;
  if (findings.whole) addFindings(page, study, findings, figures);
  if (findings.convergence) {
    page.heading("Speed against error");
    addFigures(page, figures, "convergence");
    addConvergence(page, study, *findings.convergence);
  }
  addSettings(page, study);
  std::string title;
  for (const ColumnLabel& label : study.labels) title += (title.empty() ? "" : ", ") + label.title;
  return page.whole(
      findings.whole ? "On a stiff wall: " + escape(title) : "Speed against error of the integration",
      fmt::format("{}; {} query points, {} runs each. After “A Position-Control Based Approach to Haptic Rendering of "
                  "Stiff Objects” (“the paper”), sections V and VI; our copy of the paper does not give its authors, "
                  "year or DOI.",
                  escape(nameOf(study.device)), study.plan.points(), study.plan.runs));
}

}  // namespace enamel::app
