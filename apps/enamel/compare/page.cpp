#include "compare/page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>

#include "compare/page_parts.hpp"
#include "enamel/study/controllers.hpp"
#include "study/figures.hpp"
#include "study/numbers.hpp"
#include "study/pairs.hpp"

namespace enamel::app {
namespace {

void addRanks(Page& page, const std::vector<const Condition*>& conditions) {
  std::vector<std::string> head{"renderer"};
  for (const Condition* c : conditions) head.push_back(delayText(c->delay));
  head.push_back("mean rank");
  std::vector<std::pair<double, std::vector<std::string>>> rows;
  for (std::size_t i = 0; i < conditions.front()->scores.size(); ++i) {
    std::vector<std::string> row{escape(conditions.front()->title(i))};
    double mean = 0.0;
    for (const Condition* c : conditions) {
      const RendererScore& s = c->scores[i];
      mean += s.rank / static_cast<double>(conditions.size());
      row.push_back(fmt::format("{:.1f}{}", s.rank, s.lost > 0 ? fmt::format(" ({} of {} lost)", s.lost, s.runs) : ""));
    }
    row.push_back(fmt::format("{:.1f}", mean));
    rows.emplace_back(mean, row);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::vector<std::string>> cells;
  for (const auto& row : rows) cells.push_back(row.second);
  page.table(head, cells);
}

void addFeel(Page& page, const Condition& condition) {
  std::vector<std::string> head{delayText(condition.delay), "K_z1, N/m", "K_d, N/m"};
  for (const ComparisonCriterion& c : comparisonCriteria()) head.push_back(fmt::format("{}, {}", c.name, c.unit));
  head.insert(head.end(), {"impact 0.2 m/s: bounce, µm", "corner: depth, µm", "lost"});
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < condition.scores.size(); ++i) {
    const RendererScore& s = condition.scores[i];
    std::vector<std::string> row{escape(condition.title(i)), meanText(spreadOf(s.stiffness)),
                                 meanText(spreadOf(s.depthStiffness))};
    for (const ComparisonCriterion& c : comparisonCriteria()) row.push_back(scoreText(c.scale * c.value(s)));
    row.push_back(scoreText(s.figure("impact 0.2 m/s", "bounce")));
    row.push_back(scoreText(s.figure("corner", "depth")));
    row.push_back(fmt::format("{} of {}", s.lost, s.runs));
    rows.push_back(row);
  }
  page.table(head, rows);
}

// Return the boxes of a quantity in the runs of each delay and renderer, on the range of all conditions.
Json boxPanel(const std::vector<const Condition*>& conditions, const std::vector<Condition>& all, const char* title,
              std::vector<double> RendererScore::*member, double scale) {
  double low = HUGE_VAL, high = 0.0;
  for (const Condition& c : all)
    for (const RendererScore& s : c.scores)
      for (const double v : s.*member)
        if (v > 0.0) low = std::min(low, scale * v), high = std::max(high, scale * v);
  Json boxes = Json::array(), names = Json::array();
  for (const Condition* c : conditions) {
    names.push_back(delayText(c->delay));
    for (std::size_t i = 0; i < c->scores.size(); ++i) {
      std::vector<double> values = c->scores[i].*member;
      for (double& v : values) v *= scale;
      boxes.push_back(boxOf(names.back(), c->title(i), c->study.labels[i].style, values));
    }
  }
  const Json y = high > 0.0 ? axis(title, 0.8 * low, 1.25 * high, true) : axis(title, true);
  return panel("", 760, 300, {{"names", names}}, y, Json::array({{{"type", "boxes"}, {"boxes", boxes}}}));
}

void addBoxes(Page& page, const std::vector<const Condition*>& conditions, const std::vector<Condition>& all) {
  const Condition& any = *conditions.front();
  const Json legend = legendOf(any.study, true);
  const std::string where = plantTitle(any.plant);
  const Json stiffness = boxPanel(conditions, all, "K_d (kN/m)", &RendererScore::depthStiffness, 1e-3);
  Json depth = boxPanel(conditions, all, "largest penetration (mm)", &RendererScore::depth, 1e3);
  depth["layers"].push_back(level(1e3 * kTooDeep, dashed(viewer::kInk)));
  page.figure(
      "stiffness-" + any.plant, figure("stiffness", 1, legend, Json::array({stiffness})),
      fmt::format("Stiffness K_d of the runs of scenario 1 on {}: higher is better. Boxes: median and quartiles.",
                  where));
  page.figure(
      "depth-" + any.plant, figure("largest penetration", 1, legend, Json::array({depth})),
      fmt::format("Largest penetration of a run on {}, scenario 1 (as in the paper's Fig. 15): lower is better. "
                  "Dashed: the limit of Table II, 1 mm.",
                  where));
}

std::string verdictOf(const Condition& c, const PairedComparison& k) {
  const StudyPlan& plan = c.study.plan;
  const bool isLost = static_cast<std::size_t>(k.lostB) == plan.points() * static_cast<std::size_t>(plan.runs);
  return isLost && k.lostA < k.lostB ? "the rival loses every run" : verdictText(k.verdict);
}

// Add the paired comparisons of a plant: a row for each rival and delay.
void addTests(Page& page, const std::vector<const Condition*>& conditions) {
  std::vector<std::vector<std::string>> rows;
  Json intervals = Json::array(), names = Json::array();
  for (const Condition* c : conditions)
    for (const PairedComparison& k : c->pairs) {
      if (!isStiffness(k.question)) continue;
      const auto depth = std::find_if(c->pairs.begin(), c->pairs.end(), [&k](const PairedComparison& other) {
        return other.b == k.b && !isStiffness(other.question);
      });
      rows.push_back({escape(c->title(k.b)), delayText(c->delay), timesText(k.wall), pText(k.wallAdjusted),
                      numberText(k.wall.effect, 2),
                      fmt::format("{} / {} / {}", k.count(PairedVerdict::better), k.count(PairedVerdict::worse),
                                  k.count(PairedVerdict::undecided)),
                      timesText(depth->wall), fmt::format("{} / {}", k.lostA, k.lostB), verdictOf(*c, k)});
      if (!std::isfinite(k.wall.half)) continue;
      names.push_back(c->title(k.b) + ", " + delayText(c->delay));
      const Json ends =
          numbers({std::exp(k.wall.mean), std::exp(k.wall.mean - k.wall.half), std::exp(k.wall.mean + k.wall.half)});
      intervals.push_back(
          {{"name", names.back()},
           {"mean", ends[0]},
           {"low", ends[1]},
           {"high", ends[2]},
           {"colour", colourText(c->study.labels[k.b].style.colour)},
           {"text", names.back().get<std::string>() + ": " + timesText(k.wall) + " times, " + verdictText(k.verdict)}});
    }
  if (rows.empty()) return;
  const std::string reference = escape(conditions.front()->title(conditions.front()->pairs.front().a)),
                    plant = plantTitle(conditions.front()->plant);
  if (!intervals.empty())
    page.figure(
        "pairs-" + conditions.front()->plant,
        figure("paired ratios of stiffness", 1, Json::array(),
               Json::array({panel("", 480, 20.0 * static_cast<double>(names.size()) + 10.0,
                                  axis("K_d over that of the rival", true), {{"names", names}},
                                  {{{"type", "intervals"}, {"rows", intervals}},
                                   {{"type", "mark"}, {"x", 1.0}, {"dash", {6, 4}}, {"width", 1}}})})),
        fmt::format("K_d of {} divided by that of each rival on {}, in pairs of runs with the same random numbers, "
                    "with 95 % intervals. Right of the dashed line {} is stiffer.",
                    reference, plant, reference));
  page.table(
      {reference + " against", "delay", "times as stiff (K_d), 95 %", "p, Holm", "d_z",
       "points: better / worse / not decided", "times as deep, 95 %", "runs lost", "verdict"},
      rows,
      "Scenario 1 on " + plant +
          ": geometric means of paired ratios, Student's intervals over the runs at the query points, p adjusted "
          "for all rows of all plants. d_z: mean over standard deviation of the logarithms at a point.");
}

// Add every figure of the tasks besides the push: one table for each condition.
void addTasks(Page& page, const std::vector<Condition>& conditions) {
  if (conditions.front().scores.front().trials.empty()) return;
  page.heading("Every other task");
  page.paragraph(
      "Each number is of the worst run, or the mean if the name of the row says so. The number of lost runs is in "
      "brackets.");
  for (const Condition& c : conditions) {
    std::vector<std::string> head{plantTitle(c.plant) + ", " + delayText(c.delay)};
    for (std::size_t i = 0; i < c.scores.size(); ++i) head.push_back(escape(c.title(i)));
    std::vector<std::vector<std::string>> rows;
    for (std::size_t row = 0; row < c.scores.front().trials.size(); ++row) {
      const WallFigure& named = c.scores.front().trials[row];
      std::vector<std::string> cells{
          fmt::format("{}: {}{}{}", named.trial, named.figure, *named.unit ? ", " : "", named.unit)};
      for (const RendererScore& score : c.scores) {
        const WallFigure& f = score.trials[row];
        cells.push_back(numberText(f.value) + (f.lost > 0 ? fmt::format(" ({})", f.lost) : ""));
      }
      rows.push_back(cells);
    }
    page.table(head, rows);
  }
}

void addTuned(Page& page, const StudyOptions& options) {
  if (options.tuned.empty()) return;
  std::vector<std::string> items;
  const ControllerFile file = loadControllers(options.tuned);
  page.heading("The tuned values");
  page.paragraph(
      "Found on " + escape(file.model) +
      " by <code>enamel design --rivals</code>, with the same search and the same limits for each controller.");
  for (const ControllerValues& found : file.controllers) {
    const ControllerSpec& spec = rivalSpec(found.controller);
    std::string text =
        fmt::format("{}, delay {}: ", spec.title,
                    found.delayLow == found.delayHigh ? fmt::format("{}", found.delayLow)
                                                      : fmt::format("{}..{}", found.delayLow, found.delayHigh));
    for (std::size_t i = 0; i < found.values.size(); ++i)
      text += fmt::format("{}{} {:.4g} {}", i > 0 ? ", " : "", spec.parameters[i].name, found.values[i],
                          spec.parameters[i].unit);
    items.push_back(text);
  }
  page.list(items);
}

void addRanking(Page& page, const CompareOptions& options, const std::vector<Condition>& conditions) {
  page.heading("Ranking");
  page.paragraph(
      "Rank 1 is the best. The rank is the mean of six ranks of what a hand feels. These are the depth of the tool, "
      "the chatter of the motors, and the drag of a frictionless wall. The others are the pull after a release, the "
      "energy that the wall gives, and the stiffness as a share of the physical limit. A renderer that loses runs "
      "ranks behind those that "
      "lose fewer. Values that a hand does not feel count as zero: chatter below 0.05 N m, drag below 3.5 %, a pull "
      "below 0.1 N, energy below 1 mJ.");
  for (const std::string& plant : options.plants) {
    const std::vector<const Condition*> here = onPlant(conditions, plant);
    std::string name = plantTitle(plant);
    name[0] = static_cast<char>(std::toupper(name[0]));
    page.heading(name);
    addRanks(page, here);
    addBoxes(page, here, conditions);
    for (const Condition* c : here) addFeel(page, *c);
  }
  page.note(
      "K_z1, depth, energy and share are of scenario 1, with the 95 % interval of the mean if there is one. Drag is "
      "the tangential force divided by the normal force while a hand slides at 0.1 m/s. Pull is the largest pulling "
      "force while a push of 12 N turns into a pull of 1 N. Drag and pull are the worst of as many runs as a point "
      "has. Delays are in ticks.");
  addPaper(page, conditions);
}

}  // namespace

std::string scoreText(double value) { return std::isinf(value) ? "lost" : numberText(value); }

std::vector<const Condition*> onPlant(const std::vector<Condition>& conditions, const std::string& plant) {
  std::vector<const Condition*> found;
  for (const Condition& c : conditions)
    if (c.plant == plant) found.push_back(&c);
  return found;
}

// Summary in one sentence, from the ranks, the stiffnesses and their tests.
std::string sentenceOf(const std::vector<const Condition*>& conditions) {
  std::map<std::string, int> firsts;
  for (const Condition* c : conditions) ++firsts[escape(c->title(bestOf(c->scores)))];
  std::string winners;
  for (const auto& [title, count] : firsts)
    winners += fmt::format("{}{} ranks first at {} of {} delays", winners.empty() ? "" : ", ", title, count,
                           conditions.size());
  std::string text = fmt::format("On {}: {}.", plantTitle(conditions.front()->plant), winners);
  double least = HUGE_VAL, most = 0.0;
  int lost = 0, runs = 0, compared = 0, open = 0;
  for (const Condition* c : conditions) {
    const std::size_t ours = c->study.column(ColumnKind::positionControl);
    if (ours == c->scores.size()) return text;
    lost += c->scores[ours].lost;
    runs += c->scores[ours].runs;
    const PairedComparison* rival = nullptr;  // the stiffest one that loses no run
    for (const PairedComparison& k : c->pairs)
      if (isStiffness(k.question) && c->scores[ours].lost == 0 && c->scores[k.b].lost == 0 &&
          std::isfinite(k.wall.half) && (rival == nullptr || k.wall.mean < rival->wall.mean))
        rival = &k;
    if (rival == nullptr) continue;
    ++compared;
    open += rival->verdict == PairedVerdict::undecided;
    least = std::min(least, std::exp(rival->wall.mean));
    most = std::max(most, std::exp(rival->wall.mean));
  }
  if (compared > 0)
    text += fmt::format(
        " The walls of position control are {} times as stiff (K_d) as those of the stiffest rival that loses no run "
        "({} "
        "delay{}{}).",
        fmt::format(compared == 1 ? "{:.2g}" : "{:.2g} to {:.2g}", least, most), compared, compared == 1 ? "" : "s",
        open > 0 ? fmt::format("; not decided at {}", open) : "; no 95 % interval contains 1");
  if (lost > 0) text += fmt::format(" Position control loses {} of {} runs.", lost, runs);
  return text;
}

namespace {

// The first screen: which renderer is stiffer, by how much, where not, and what that assumes.
void addSummary(Page& page, const CompareOptions& options, const std::vector<Condition>& conditions) {
  std::vector<std::string> items;
  for (const std::string& plant : options.plants) items.push_back(sentenceOf(onPlant(conditions, plant)));
  std::vector<std::string> others;
  for (const Condition& c : conditions)
    for (const PairedComparison& k : c.pairs)
      if (isStiffness(k.question) && k.verdict != PairedVerdict::better)
        others.push_back(fmt::format("{} on {}, {} ({})", escape(c.title(k.b)), plantTitle(c.plant), delayText(c.delay),
                                     verdictOf(c, k)));
  if (!conditions.front().pairs.empty())
    items.push_back("Rivals that " + escape(conditions.front().title(conditions.front().pairs.front().a)) +
                    " is not found to beat in stiffness: " + (others.empty() ? "none" : join(others, "; ")) + ".");
  page.paragraph(
      fmt::format("Compared in simulation: {} renderers on a virtual wall. A simulated person pushes the tool into the "
                  "wall with the "
                  "same random forces for every renderer. Stiffness K_d is the force of a sudden push divided by the "
                  "depth that the "
                  "tool reaches in 0.1 s.",
                  conditions.front().scores.size()));
  page.list(items);
  for (const std::string& plant : options.plants) addTests(page, onPlant(conditions, plant));
}

void addOrigin(Page& page, const Study& any, const std::vector<Condition>& conditions) {
  page.note(
      "All results are from simulation; no hardware was involved. Intervals have 95 % and cover the random forces "
      "and noise at these query points, not other devices.");
  page.note("Command: <code class=\"command\">" + escape(shellText("compare", any.options.arguments)) + "</code>");
  page.note(fmt::format("Enamel {}, seed {}, device file with CRC-32 {}.", ENAMEL_VERSION, any.plan.setup.seed,
                        Json::parse(any.manifest).at("device").at("CRC-32").get<std::string>()));
  if (conditions.front().scores.front().runs > 0) page.download("compare.csv", comparisonTable(conditions));
  page.download("tasks.csv", tasksTable(conditions));
}

}  // namespace

std::string pageOf(const CompareOptions& options, const std::vector<Condition>& conditions) {
  Page page;
  const Study& any = conditions.front().study;
  const StudyPlan& plan = any.plan;
  const bool pushes = conditions.front().scores.front().runs > 0;
  if (pushes) addSummary(page, options, conditions);
  addOrigin(page, any, conditions);
  if (pushes) addRanking(page, options, conditions);
  addTasks(page, conditions);
  addTuned(page, any.options);
  return page.whole(
      "Enamel: renderers compared",
      fmt::format("{}, renderers designed on {}; {} a renderer, plant and delay; encoders, preload {} N, seed {}",
                  escape(nameOf(any.device)), escape(nameOf(any.designDevice)),
                  pushes ? fmt::format("{} x {} points x {} runs x {} scenarios", plan.grid, plan.grid, plan.runs,
                                       plan.scenarios.size())
                         : fmt::format("{} runs a task", plan.runs),
                  any.options.preload, any.options.seed));
}

}  // namespace enamel::app
