#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"
#include "study/report.hpp"

namespace enamel::app {

constexpr double kRounding = 1e-12;  // SI: smaller values are rounding errors

// The distribution of every metric over the wall: median and range of the means at the query points.
void addMeasures(Page& page, const Study& study, const Findings& findings) {
  page.heading("All metrics over the wall");
  for (const int scenario : study.plan.scenarios) {
    std::vector<const WallSummary*> walls;
    for (const WallSummary& w : findings.walls)
      if (w.scenario == scenario) walls.push_back(&w);
    std::vector<std::string> head{""};
    for (const WallSummary* w : walls) head.push_back(escape(study.labels[w->column].title));
    std::vector<std::vector<std::string>> rows;
    const auto row = [&](const std::string& name, const auto& cell) {
      rows.push_back({name});
      for (const WallSummary* w : walls) rows.back().push_back(cell(*w));
    };
    row("plant's damping, N s/m <small>mechanical, along z at home</small>",
        [&](const WallSummary& w) { return givenText(study.labels[w.column].damping); });
    for (std::size_t m = 0; m < kMetrics; ++m) {
      const Metric& metric = allMetrics()[m];
      const auto text = [&metric](double mean) {
        return numberText(std::abs(mean) < kRounding ? 0.0 : metric.displayScale * mean);
      };
      const auto cell = [&](const WallSummary& w) -> std::string {
        std::vector<double> means;
        for (const PointStatistics& p : findings.points)
          if (p.scenario == scenario && p.column == w.column && std::isfinite(p.metrics[m].mean))
            means.push_back(p.metrics[m].mean);
        if (means.empty()) return "–";
        std::sort(means.begin(), means.end());
        const std::string low = text(means.front()), high = text(means.back());
        return text(means[means.size() / 2]) + (low == high ? "" : " <small>" + low + " to " + high + "</small>");
      };
      if (std::all_of(walls.begin(), walls.end(), [&](const WallSummary* w) { return cell(*w) == "–"; })) continue;
      row(fmt::format("{}{}{} <small>{}</small>", metric.symbol, *metric.displayUnit ? ", " : "", metric.displayUnit,
                      metric.meaning),
          cell);
    }
    row("runs without K_z1", [](const WallSummary& w) {
      const std::string without = withoutFirstText(w);
      return without.empty() ? std::string("0") : without;
    });
    row("runs lost", [](const WallSummary& w) { return w.failed == 0 ? std::string("0") : lostText(w); });
    page.table(head, rows,
               fmt::format("Scenario {}: the median of the means at the query points, and below it their lowest and "
                           "highest. A run is lost if the device leaves its workspace or the guard stops it.",
                           scenario));
  }
}

}  // namespace enamel::app
