#include "compare/page.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

#include "compare/page_parts.hpp"
#include "enamel/study/controllers.hpp"
#include "enamel/study/welch.hpp"
#include "study/box_plot.hpp"
#include "study/numbers.hpp"

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

// `all`: the conditions that share the same axes.
void addBoxes(Page& page, const std::vector<const Condition*>& conditions, const std::vector<Condition>& all) {
  const Condition& any = *conditions.front();
  BoxPlot stiffness, depth;
  stiffness.yLabel = "K_z1, kN/m";
  depth.yLabel = "largest penetration, mm";
  depth.line = 1e3 * kTooDeep;
  for (std::size_t i = 0; i < any.scores.size(); ++i) stiffness.series.push_back(any.title(i));
  depth.series = stiffness.series;
  for (const Condition* c : conditions) {
    stiffness.groups.push_back(delayText(c->delay));
    stiffness.values.emplace_back();
    depth.values.emplace_back();
    for (const RendererScore& s : c->scores) {
      stiffness.values.back().push_back(s.stiffness);
      depth.values.back().push_back(s.depth);
      for (double& value : depth.values.back().back()) value *= 1e3;
      for (double& value : stiffness.values.back().back()) value *= 1e-3;
    }
  }
  depth.groups = stiffness.groups;
  for (const Condition& c : all)
    for (const RendererScore& s : c.scores) {
      for (const double value : s.stiffness)
        if (value > 0.0) stiffness.extent.see(1e-3 * value);
      for (const double value : s.depth)
        if (value > 0.0) depth.extent.see(1e3 * value);
    }
  const std::string& where = plantTitle(any.plant);
  page.figure(svgOf(stiffness), fmt::format("First impact stiffness on {}, scenario 1: higher is better. Boxes: "
                                            "quartiles of the runs that have a first impact.",
                                            where));
  page.figure(svgOf(depth), fmt::format("Largest penetration of a run on {}, scenario 1 (as in the paper's Fig. 15): "
                                        "lower is better. Dashed: the limit of Table II, 1 mm.",
                                        where));
}

void addTests(Page& page, const std::vector<const Condition*>& conditions) {
  std::vector<std::vector<std::string>> rows;
  for (const Condition* c : conditions) {
    const std::size_t ours = c->study.column(ColumnKind::positionControl);
    if (ours == c->scores.size()) continue;
    for (std::size_t i = 0; i < c->scores.size(); ++i) {
      if (i == ours) continue;
      const WelchTest t = welchTest(spreadOf(c->scores[ours].depth), spreadOf(c->scores[i].depth));
      rows.push_back({escape(c->title(i)), delayText(c->delay), meanText(spreadOf(c->scores[ours].depth), 1e6),
                      meanText(spreadOf(c->scores[i].depth), 1e6), scoreText(t.t), scoreText(t.freedom), pText(t.p),
                      scoreText(t.effect)});
    }
  }
  page.table({"position control against", "delay", "its depth, µm", "the rival's, µm", "t", "degrees of freedom", "p",
              "effect (Cohen's d)"},
             rows);
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
  page.heading("Summary");
  for (const std::string& plant : options.plants) page.paragraph(sentenceOf(onPlant(conditions, plant)));
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
  page.heading("Significance of the differences");
  page.paragraph("Welch's test of the largest penetration in the runs of scenario 1.");
  for (const std::string& plant : options.plants) {
    page.paragraph("<b>" + plantTitle(plant) + "</b>");
    addTests(page, onPlant(conditions, plant));
  }
  addPaper(page, conditions);
}

}  // namespace

const std::string& plantTitle(const std::string& plant) {
  static const std::map<std::string, std::string> titles = {{kClosedForm, "the ideal device"},
                                                            {kMultibody, "the device in Simbody"},
                                                            {kImperfect, "the imperfect plant"},
                                                            {kImperfectStiff, "the imperfect plant with stiff cables"}};
  return titles.at(plant);
}

std::string scoreText(double value) { return std::isinf(value) ? "lost" : numberText(value); }

std::string pText(double p) { return std::isnan(p) ? "–" : p < 1e-4 ? "&lt; 0.0001" : fmt::format("{:.4f}", p); }

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
  double least = std::numeric_limits<double>::infinity(), most = 0.0, p = 0.0;
  int lost = 0, runs = 0, compared = 0;
  for (const Condition* c : conditions) {
    const std::size_t ours = c->study.column(ColumnKind::positionControl);
    if (ours == c->scores.size()) return text;
    const RendererScore& mine = c->scores[ours];
    lost += mine.lost;
    runs += mine.runs;
    const RendererScore* rival = nullptr;
    for (std::size_t i = 0; i < c->scores.size(); ++i)
      if (const RendererScore& s = c->scores[i]; i != ours && s.lost == 0 && s.stiffness.size() > 1 &&
                                                 (rival == nullptr || meanOf(s.stiffness) > meanOf(rival->stiffness)))
        rival = &s;
    if (rival == nullptr || mine.lost > 0 || mine.stiffness.size() < 2) continue;
    const double ratio = meanOf(mine.stiffness) / meanOf(rival->stiffness);
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    p = std::max(p, welchTest(spreadOf(mine.stiffness), spreadOf(rival->stiffness)).p);
    ++compared;
  }
  if (compared > 0)
    text += fmt::format(
        " The walls of position control are {} times as stiff as those of the stiffest rival that loses no run ({} "
        "delay{}; Welch: p {} {:.1g}).",
        fmt::format(compared == 1 ? "{:.2g}" : "{:.2g} to {:.2g}", least, most), compared, compared == 1 ? "" : "s",
        p < 1e-4 ? "&lt;" : "up to", std::max(p, 1e-4));
  if (lost > 0) text += fmt::format(" Position control loses {} of {} runs.", lost, runs);
  return text;
}

std::string pageOf(const CompareOptions& options, const std::vector<Condition>& conditions) {
  Page page;
  const Study& any = conditions.front().study;
  const StudyPlan& plan = any.plan;
  const bool pushes = conditions.front().scores.front().runs > 0;
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
