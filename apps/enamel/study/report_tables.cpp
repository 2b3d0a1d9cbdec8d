#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"
#include "study/report_parts.hpp"

namespace enamel::app {

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
      if (!e) return std::string(row.first ? "no run has K_z1" : "unresolved");
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
  page.table(head, cells,
             "In the form of the paper's Table IV: the lowest and highest of the query points' means, at (x, y). "
             "Values in brackets in the paper's co-simulation are with a random delay. The paper gives no intervals.");
  page.note(
      "The paper's servo is hold; the paper does not have Enamel's position control. The paper uses another device: "
      "compare only magnitudes and order.");
}

void addMeasures(Page& page, const Study& study, const Findings& findings) {
  page.heading("Further metrics");
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
    // Return the worst of the points' means.
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
    row("lowest F_c / rms depth, N/m", "rms over the steady state; unlike D_zs it cannot be zero by chance",
        worst([](const PointStatistics& p) { return p.forceOverRms; }, true, 1.0));
    row("lowest F_c / depth 95 %, N/m", "95 % of the ticks of the steady state are less deep",
        worst([](const PointStatistics& p) { return p.forceOver95; }, true, 1.0));
    row("largest depth, mm", "of all runs", [](const WallSummary& w) { return numberText(1e3 * w.largestDepth); });
    row("largest drift, mm", "distance from the start across the normal, of all runs",
        [](const WallSummary& w) { return numberText(1e3 * w.drift); });
    mean(&PushMetrics::bounce, "largest gap above the rest, from the onset of the push");
    mean(&PushMetrics::chatter, "standard deviation of the torque over the last second, of the worst joint");
    mean(&PushMetrics::saturatedShare, "of all ticks: at least one motor is at its limit");
    mean(&PushMetrics::tangentialForce, "rms of the rendered force across the normal in the steady state");
    if (scenario == 1) {
      row("uniformity of K_z1",
          fmt::format("(largest − smallest) / mean over the wall, without noise, F_c = {:.0f} N", kSurveyForce),
          [&](const WallSummary& w) {
            const double u = uniformityOf(findings.survey[w.column]);
            return std::isfinite(u) ? percent(u) : std::string("–");
          });
      mean(&PushMetrics::depthStiffness, "force divided by the deepest point in the 0.1 s after the step", true);
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
               fmt::format("Scenario {}: the mean of the worst query point, or the largest of all runs if the row says "
                           "so. A run is lost if the device leaves its workspace or the guard stops it.",
                           scenario));
  }
}

}  // namespace enamel::app
