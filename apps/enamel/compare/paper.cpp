#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/page_parts.hpp"
#include "study/numbers.hpp"
#include "study/pairs.hpp"

namespace enamel::app {
namespace {

double deepestOf(const std::vector<double>& depths) {
  double most = 0.0;
  for (const double depth : depths) most = std::max(most, depth);
  return most;
}

// The paper's Table III: largest penetration of the runs; values with a random delay are in brackets.
void addTableThree(Page& page, const std::vector<Condition>& conditions) {
  std::vector<std::vector<std::string>> rows;
  const auto isDelayed = [](const Condition& c) { return c.delay.rfind("random", 0) == 0; };
  for (const Condition& c : conditions) {
    if (c.delay != "none") continue;
    const auto delayed = std::find_if(conditions.begin(), conditions.end(), [&](const Condition& other) {
      return other.plant == c.plant && isDelayed(other);
    });
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      if (!isPositionBased(c.study.labels[i].kind)) continue;
      for (const auto depth : {&RendererScore::depth, &RendererScore::depthOfHand}) {
        const auto cell = [&](auto&& text) {
          return text(c.scores[i]) + (delayed != conditions.end() ? " (" + text(delayed->scores[i]) + ")" : "");
        };
        const auto deepest = [depth](const RendererScore& s) {
          const std::vector<double>& d = s.*depth;
          return d.empty() ? std::numeric_limits<double>::quiet_NaN() : 1e6 * deepestOf(d);
        };
        rows.push_back(
            {escape(c.title(i)), c.plant, depth == &RendererScore::depth ? "1" : "2",
             cell([&](const RendererScore& s) { return scoreText(1e6 * meanOf(s.*depth)); }),
             cell([&](const RendererScore& s) { return scoreText(1e6 * spreadOf(s.*depth).deviation); }),
             cell([&](const RendererScore& s) { return scoreText(deepest(s)); }), cell([&](const RendererScore& s) {
               const auto deeper =
                   std::count_if((s.*depth).begin(), (s.*depth).end(), [](double d) { return d > kTooDeep; });
               return fmt::format("{} of {}", deeper, (s.*depth).size());
             }),
             cell([](const RendererScore& s) { return fmt::format("{}", s.lost); })});
      }
    }
  }
  page.table({"renderer", "plant", "scenario", "penetration: mean, µm", "deviation", "deepest", "above 1 mm",
              "lost (both scenarios)"},
             rows);
}

// Check the paper's claim about a random delay for one condition.
std::string delayClaim(const Condition& c, const RendererScore& s) {
  const auto deep = std::count_if(s.depth.begin(), s.depth.end(), [](double depth) { return depth > kTooDeep; });
  const double most = deepestOf(s.depth);
  if (s.depth.empty())
    return fmt::format(
        "“With a random delay, 3 of 90 runs exceed 1 mm, none exceeds 1.1 mm” ({}): every run is lost, <b>refuted</b> "
        "for rates from encoders. The paper uses exact rates: see lib/docs/plants.md.",
        plantTitle(c.plant));
  return fmt::format(
      "“With a random delay, 3 of 90 runs exceed 1 mm, none exceeds 1.1 mm” ({}): {} of {} finished runs exceed 1 mm, "
      "and the deepest reaches {:.2f} mm. {} of {} runs are lost: <b>{}</b>. (The paper uses exact rates, here they "
      "come from encoders.)",
      plantTitle(c.plant), deep, s.depth.size(), 1e3 * most, s.lost, s.runs,
      s.lost == 0 && deep <= 3 && most < 1.1e-3 ? "holds" : "refuted");
}

std::string stiffnessClaim(const Condition& c, const PairedComparison& k) {
  return fmt::format(
      "“Position control is stiffer than impedance” on {}, {}: {} times as stiff as {} (K_d), {} against {} runs lost: "
      "<b>{}</b>.",
      plantTitle(c.plant), delayText(c.delay), timesText(k.wall), escape(c.title(k.b)), k.lostA, k.lostB,
      k.verdict == PairedVerdict::better  ? "holds"
      : k.verdict == PairedVerdict::worse ? "does not hold"
                                          : "not decided");
}

std::size_t columnNamed(const Condition& condition, const std::string& name) {
  const auto& columns = condition.study.plan.columns;
  std::size_t c = 0;
  while (c < columns.size() && columns[c].name != name) ++c;
  return c;
}

void addClaims(Page& page, const std::vector<Condition>& conditions) {
  std::vector<std::string> items;
  for (const Condition& c : conditions) {
    const std::size_t hold = c.study.column(ColumnKind::hold), ours = c.study.column(ColumnKind::positionControl),
                      none = c.scores.size();
    if (c.delay.rfind("random", 0) == 0 && hold < none) items.push_back(delayClaim(c, c.scores[hold]));
    std::size_t spring = columnNamed(c, std::string(kTuned) + kImpedance);
    if (spring == none) spring = columnNamed(c, kImpedance);
    for (const PairedComparison& k : c.pairs)
      if (c.plant != kClosedForm && k.a == ours && k.b == spring && isStiffness(k.question))
        items.push_back(stiffnessClaim(c, k));
  }
  page.list(items);
}

}  // namespace

bool isPositionBased(ColumnKind kind) { return kind == ColumnKind::hold || kind == ColumnKind::positionControl; }

void addPaper(Page& page, const std::vector<Condition>& conditions) {
  page.heading("The paper's claims");
  addClaims(page, conditions);
  page.paragraph(
      "Table III: the largest penetration of a run without delay and, in brackets, with a random delay. In the paper, "
      "all runs stay within 1 mm; with a random delay, 3 of 90 exceed it and none exceeds 1.1 mm.");
  addTableThree(page, conditions);
}

}  // namespace enamel::app
