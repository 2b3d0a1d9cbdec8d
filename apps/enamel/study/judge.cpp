#include "study/judge.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/study/controllers.hpp"
#include "enamel/study/wall_trials.hpp"
#include "enamel/study/welch.hpp"
#include "json_matrices.hpp"
#include "study/box_plot.hpp"
#include "study/numbers.hpp"
#include "study/page.hpp"
#include "study/study.hpp"

namespace enamel::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kTooDeep = 1e-3;  // m: what the paper allows
constexpr const char* kTrials[] = {"impact", "release", "slide", "corner"};

// How a law did on a plant at a delay. Scenario 1, but for the runs that were lost.
struct Score {
  int runs = 0, lost = 0;                  // left the workspace, stopped by the guard, or unstable on the wall
  std::vector<double> stiffness, depth;    // K_z1, N/m; largest penetration, m
  std::vector<double> depthOfHand;         // the same of scenario 2
  double share = 0.0;                      // of the limit, mean; a run without K_z1 has none of it
  double chatter = kNone, energy = kNone;  // means; N m; given to the tool, J
  std::vector<WallFigure> trials;
  double rank = kNone;  // mean over kCriteria

  double figure(const std::string& trial, const std::string& name) const {
    for (const WallFigure& f : trials)
      if (f.trial == trial && f.figure == name) return f.lost > 0 ? std::numeric_limits<double>::infinity() : f.value;
    return kNone;
  }
  double drag() const { return figure("slide", "tangential force"); }
  double pull() const { return figure("release", "pull"); }
};

double meanOf(const std::vector<double>& values) { return spreadOf(values).mean; }

// `felt`: below it a hand feels nothing (in SI or %): the chatter that the search allows, half of the smallest
// difference of force that is noticed (7 %: Pang, Tan and Durlach 1991), and what we take for the pull and the
// energy.
struct Criterion {
  const char *name, *unit;
  double (*value)(const Score&);
  double scale;  // to the unit
  double felt;
  bool moreIsBetter;
};
const Criterion kCriteria[] = {
    {"depth", "µm", [](const Score& s) { return meanOf(s.depth); }, 1e6, 0.0, false},
    {"chatter", "N m", [](const Score& s) { return s.chatter; }, 1.0, 0.05, false},
    {"drag", "%", [](const Score& s) { return s.drag(); }, 1.0, 3.5, false},
    {"pull", "N", [](const Score& s) { return s.pull(); }, 1.0, 0.1, false},
    {"energy given", "mJ", [](const Score& s) { return s.energy; }, 1e3, 1e-3, false},
    {"share of the limit", "%", [](const Score& s) { return s.share; }, 100.0, 0.0, true},
};

// One plant at one delay.
struct Condition {
  std::string plant, delay;
  Study study;
  std::vector<PointStatistics> points;
  std::vector<WallSummary> walls;
  std::vector<Score> scores;  // by column
};

const std::map<std::string, std::string>& plantTitles() {
  static const std::map<std::string, std::string> titles = {{kClosedForm, "the ideal device"},
                                                            {kMultibody, "the device in Simbody"},
                                                            {kReal, "the real device"},
                                                            {kRealStiff, "the real device with stiff cables"}};
  return titles;
}

std::vector<Score> scoresOf(const Study& study, const std::vector<StudyResult>& runs) {
  std::vector<Score> scores(study.plan.columns.size());
  std::vector<std::vector<double>> chatter(scores.size()), energy(scores.size());
  std::vector<int> steps(scores.size());
  for (const StudyResult& run : runs) {
    Score& score = scores[run.run.column];
    ++score.runs;
    const bool first = run.run.scenario == 1;
    steps[run.run.column] += first;
    if (run.status != Status::ok || run.metrics.verdict == FirstImpactVerdict::unstable) {
      ++score.lost;
      continue;
    }
    chatter[run.run.column].push_back(run.metrics.chatter);
    if (!first) {
      score.depthOfHand.push_back(run.metrics.largestDepth);
      continue;
    }
    energy[run.run.column].push_back(std::max(0.0, run.metrics.work));
    score.depth.push_back(run.metrics.largestDepth);
    score.share += run.metrics.limitShare.value_or(0.0);
    if (run.metrics.firstStiffness) score.stiffness.push_back(*run.metrics.firstStiffness);
  }
  for (std::size_t c = 0; c < scores.size(); ++c) {
    scores[c].share /= std::max(1, steps[c]);
    scores[c].chatter = meanOf(chatter[c]);
    scores[c].energy = meanOf(energy[c]);
  }
  return scores;
}

void addTrials(const Study& study, std::vector<Score>& scores) {
  const PushSetup& push = study.plan.setup;
  for (std::size_t c = 0; c < scores.size(); ++c) {
    const StudyColumn& column = study.plan.columns[c];
    WallTrialSetup setup;
    setup.plant = setup.model = column.plant;
    setup.renderer = [&column] { return column.make(0); };
    setup.makePlant = column.makePlant;
    setup.period = column.period > 0.0 ? column.period : push.period;
    const int ticks = static_cast<int>(std::lround(push.period / setup.period));
    setup.delay = {push.delay.low * ticks, push.delay.high * ticks};
    setup.runs = study.plan.runs;
    setup.seed = push.seed;
    for (const char* trial : kTrials)
      for (const WallFigure& figure : runWallTrials(setup, trial, study.options.threads))
        scores[c].trials.push_back(figure);
  }
}

// Ranks from 1, those that are equal share theirs. A law that lost runs stands behind all that lost fewer.
std::vector<double> ranksBy(const Criterion& criterion, const std::vector<Score>& scores) {
  const auto key = [&](const Score& s) {
    const double value = criterion.value(s);
    if (std::isnan(value)) return std::make_pair(s.lost, std::numeric_limits<double>::infinity());
    return std::make_pair(s.lost, criterion.moreIsBetter ? -value : std::max(value, criterion.felt));
  };
  std::vector<double> ranks;
  for (const Score& mine : scores) {
    double before = 0.0, equal = 0.0;
    for (const Score& other : scores) {
      before += key(other) < key(mine);
      equal += key(other) == key(mine);
    }
    ranks.push_back(before + 0.5 * (equal + 1.0));
  }
  return ranks;
}

void rank(std::vector<Score>& scores) {
  for (Score& score : scores) score.rank = 0.0;
  for (const Criterion& criterion : kCriteria) {
    const std::vector<double> ranks = ranksBy(criterion, scores);
    for (std::size_t c = 0; c < scores.size(); ++c) scores[c].rank += ranks[c] / std::size(kCriteria);
  }
}

std::size_t bestOf(const std::vector<Score>& scores) {
  const auto best =
      std::min_element(scores.begin(), scores.end(), [](const Score& a, const Score& b) { return a.rank < b.rank; });
  return static_cast<std::size_t>(best - scores.begin());
}

std::string number(double value) { return std::isinf(value) ? "lost" : numberText(value); }

std::string pText(double p) { return std::isnan(p) ? "–" : p < 1e-4 ? "&lt; 0.0001" : fmt::format("{:.4f}", p); }

const std::string& titleOf(const Condition& condition, std::size_t column) {
  return condition.study.labels[column].title;
}

std::vector<const Condition*> onPlant(const std::vector<Condition>& conditions, const std::string& plant) {
  std::vector<const Condition*> found;
  for (const Condition& c : conditions)
    if (c.plant == plant) found.push_back(&c);
  return found;
}

std::size_t columnNamed(const Condition& condition, const std::string& name) {
  const auto& columns = condition.study.plan.columns;
  std::size_t c = 0;
  while (c < columns.size() && columns[c].name != name) ++c;
  return c;
}

// For a reader in a hurry: computed from the ranks, the stiffnesses and their tests.
std::string sentenceOf(const std::vector<const Condition*>& conditions) {
  std::map<std::string, int> firsts;
  for (const Condition* c : conditions) ++firsts[titleOf(*c, bestOf(c->scores))];
  std::string winners;
  for (const auto& [title, count] : firsts)
    winners += fmt::format("{}{} ranks first at {} of {} delays", winners.empty() ? "" : ", ", title, count,
                           conditions.size());
  std::string text = fmt::format("On {}: {}.", plantTitles().at(conditions.front()->plant), winners);
  double least = std::numeric_limits<double>::infinity(), most = 0.0, p = 0.0;
  int lost = 0, runs = 0, compared = 0;
  for (const Condition* c : conditions) {
    const std::size_t ours = columnNamed(*c, kPositionControl);
    if (ours == c->scores.size()) return text;
    const Score& mine = c->scores[ours];
    lost += mine.lost;
    runs += mine.runs;
    const Score* rival = nullptr;
    for (std::size_t i = 0; i < c->scores.size(); ++i)
      if (const Score& s = c->scores[i]; i != ours && s.lost == 0 && s.stiffness.size() > 1 &&
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
        " Its walls by position control are {} times as stiff as the stiffest rival that "
        "loses no run ({} delay{}; Welch: p {} {:.1g}).",
        fmt::format(compared == 1 ? "{:.2g}" : "{:.2g} to {:.2g}", least, most), compared, compared == 1 ? "" : "s",
        p < 1e-4 ? "&lt;" : "up to", std::max(p, 1e-4));
  if (lost > 0) text += fmt::format(" Position control loses {} of {} runs.", lost, runs);
  return text;
}

void addRanks(Page& page, const std::vector<const Condition*>& conditions) {
  std::vector<std::string> head{"law"};
  for (const Condition* c : conditions) head.push_back(delayText(c->delay));
  head.push_back("mean rank");
  std::vector<std::pair<double, std::vector<std::string>>> rows;
  for (std::size_t i = 0; i < conditions.front()->scores.size(); ++i) {
    std::vector<std::string> row{titleOf(*conditions.front(), i)};
    double mean = 0.0;
    for (const Condition* c : conditions) {
      const Score& s = c->scores[i];
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
  std::vector<std::string> head{delayText(condition.delay), "K_z1, N/m"};
  for (const Criterion& c : kCriteria) head.push_back(fmt::format("{}, {}", c.name, c.unit));
  head.insert(head.end(), {"impact 0.2 m/s: bounce, µm", "corner: depth, µm", "lost"});
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < condition.scores.size(); ++i) {
    const Score& s = condition.scores[i];
    std::vector<std::string> row{titleOf(condition, i), meanText(spreadOf(s.stiffness))};
    for (const Criterion& c : kCriteria) row.push_back(number(c.scale * c.value(s)));
    row.push_back(number(s.figure("impact 0.2 m/s", "bounce")));
    row.push_back(number(s.figure("corner", "depth")));
    row.push_back(fmt::format("{} of {}", s.lost, s.runs));
    rows.push_back(row);
  }
  page.table(head, rows);
}

// `all`: what has the same axes.
void addBoxes(Page& page, const std::vector<const Condition*>& conditions, const std::vector<Condition>& all) {
  const Condition& any = *conditions.front();
  BoxPlot stiffness, depth;
  stiffness.yLabel = "K_z1, kN/m";
  depth.yLabel = "largest penetration, mm";
  depth.line = 1e3 * kTooDeep;
  for (std::size_t i = 0; i < any.scores.size(); ++i) stiffness.series.push_back(titleOf(any, i));
  depth.series = stiffness.series;
  for (const Condition* c : conditions) {
    stiffness.groups.push_back(delayText(c->delay));
    stiffness.values.emplace_back();
    depth.values.emplace_back();
    for (const Score& s : c->scores) {
      stiffness.values.back().push_back(s.stiffness);
      depth.values.back().push_back(s.depth);
      for (double& value : depth.values.back().back()) value *= 1e3;
      for (double& value : stiffness.values.back().back()) value *= 1e-3;
    }
  }
  depth.groups = stiffness.groups;
  for (const Condition& c : all)
    for (const Score& s : c.scores) {
      for (const double value : s.stiffness)
        if (value > 0.0) stiffness.extent.see(1e-3 * value);
      for (const double value : s.depth)
        if (value > 0.0) depth.extent.see(1e3 * value);
    }
  const std::string& where = plantTitles().at(any.plant);
  page.figure(svgOf(stiffness),
              fmt::format("First impact stiffness on {}, scenario 1: higher is better. Boxes: quartiles "
                          "of the runs that have one.",
                          where));
  page.figure(svgOf(depth),
              fmt::format("Largest penetration of a run on {}, scenario 1 (the form of the paper's Fig. 15): "
                          "lower is better; dashed: the 1 mm of Table II.",
                          where));
}

void addTests(Page& page, const std::vector<const Condition*>& conditions) {
  std::vector<std::vector<std::string>> rows;
  for (const Condition* c : conditions) {
    const std::size_t ours = columnNamed(*c, kPositionControl);
    if (ours == c->scores.size()) continue;
    for (std::size_t i = 0; i < c->scores.size(); ++i) {
      if (i == ours) continue;
      const WelchTest t = welchTest(spreadOf(c->scores[ours].depth), spreadOf(c->scores[i].depth));
      rows.push_back({titleOf(*c, i), delayText(c->delay), meanText(spreadOf(c->scores[ours].depth), 1e6),
                      meanText(spreadOf(c->scores[i].depth), 1e6), number(t.t), number(t.freedom), pText(t.p),
                      number(t.effect)});
    }
  }
  page.table({"position control against", "delay", "its depth, µm", "the rival's, µm", "t", "degrees of freedom", "p",
              "effect (Cohen's d)"},
             rows);
}

// The paper's Table III: the largest penetration of the servos' runs, with a random delay in brackets.
void addTableThree(Page& page, const std::vector<Condition>& conditions) {
  std::vector<std::vector<std::string>> rows;
  const auto isDelayed = [](const Condition& c) { return c.delay.rfind("random", 0) == 0; };
  for (const Condition& c : conditions) {
    if (c.delay != "none") continue;
    const auto delayed = std::find_if(conditions.begin(), conditions.end(), [&](const Condition& other) {
      return other.plant == c.plant && isDelayed(other);
    });
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      const ColumnKind kind = c.study.labels[i].kind;
      if (kind != ColumnKind::hold && kind != ColumnKind::positionControl) continue;
      for (const auto depth : {&Score::depth, &Score::depthOfHand}) {
        const auto cell = [&](auto&& text) {
          return text(c.scores[i]) + (delayed != conditions.end() ? " (" + text(delayed->scores[i]) + ")" : "");
        };
        const auto deepest = [depth](const Score& s) {
          const std::vector<double>& d = s.*depth;
          return d.empty() ? kNone : 1e6 * *std::max_element(d.begin(), d.end());
        };
        rows.push_back({titleOf(c, i), c.plant, depth == &Score::depth ? "1" : "2",
                        cell([&](const Score& s) { return number(1e6 * meanOf(s.*depth)); }),
                        cell([&](const Score& s) { return number(1e6 * spreadOf(s.*depth).deviation); }),
                        cell([&](const Score& s) { return number(deepest(s)); }), cell([&](const Score& s) {
                          const auto deeper = std::count_if((s.*depth).begin(), (s.*depth).end(),
                                                            [](double d) { return d > kTooDeep; });
                          return fmt::format("{} of {}", deeper, (s.*depth).size());
                        }),
                        cell([](const Score& s) { return fmt::format("{}", s.lost); })});
      }
    }
  }
  page.table({"servo", "plant", "scenario", "penetration: mean, µm", "deviation", "deepest", "above 1 mm",
              "lost (both scenarios)"},
             rows);
}

// The paper's Table IV: lowest of the servo against highest of the baseline.
void addTableFour(Page& page, const std::vector<Condition>& conditions) {
  std::vector<std::vector<std::string>> rows;
  const auto extreme = [](const std::optional<Extreme>& e) { return e ? number(e->value) : std::string("–"); };
  for (const Condition& c : conditions)
    for (const WallSummary& servo : c.walls) {
      const ColumnKind kind = c.study.labels[servo.column].kind;
      if (kind != ColumnKind::hold && kind != ColumnKind::positionControl) continue;
      const std::size_t spring = c.study.column(ColumnKind::impedance);
      for (const WallSummary& wall : c.walls) {
        if (wall.scenario != servo.scenario || wall.column != spring) continue;
        const bool first = servo.scenario == 1 && servo.lowestFirst && wall.highestFirst &&
                           servo.lowestFirst->value > wall.highestFirst->value;
        const bool steady =
            servo.lowestSteady && wall.highestSteady && servo.lowestSteady->value > wall.highestSteady->value;
        std::string because;
        for (const std::string& reason : {lostText(servo), withoutFirstText(servo)})
          if (!reason.empty()) because += (because.empty() ? "" : ", ") + reason;
        if (!wall.stable()) because += (because.empty() ? "" : "; ") + ("impedance: " + lostText(wall));
        const bool holds = servo.stable() && steady && (first || servo.scenario == 2);
        rows.push_back({titleOf(c, servo.column), c.plant, delayText(c.delay), fmt::format("{}", servo.scenario),
                        extreme(servo.lowestFirst), extreme(wall.highestFirst), extreme(servo.lowestSteady),
                        extreme(wall.highestSteady),
                        holds                              ? "holds"
                        : wall.stable() || !servo.stable() ? "does not hold"
                                                           : "nothing to compare with",
                        because});
      }
    }
  page.table({"servo", "plant", "delay", "scenario", "its lowest K_z1, N/m", "impedance's highest",
              "its lowest K_zs, N/m", "impedance's highest", "order", "because"},
             rows);
}

void addClaims(Page& page, const std::vector<Condition>& conditions) {
  std::vector<std::string> items;
  for (const Condition& c : conditions) {
    if (const std::size_t hold = c.study.column(ColumnKind::hold);
        c.delay.rfind("random", 0) == 0 && hold < c.scores.size()) {
      const Score& s = c.scores[hold];
      int deep = 0;
      double most = 0.0;
      for (const double depth : s.depth) deep += depth > kTooDeep, most = std::max(most, depth);
      if (s.depth.empty()) {
        items.push_back(fmt::format(
            "“With a random delay 3 of 90 runs pass 1 mm, none 1.1 mm” ({}): every run is lost, "
            "<b>refuted</b> for rates that come from encoders. The paper's are exact: see lib/docs/plants.md.",
            plantTitles().at(c.plant)));
      } else {
        items.push_back(fmt::format(
            "“With a random delay 3 of 90 runs pass 1 mm, none 1.1 mm” ({}): {} of {} runs that were finished pass it, "
            "the deepest reaches {:.2f} mm, and {} of {} are lost: <b>{}</b>. (The paper has exact rates, here they "
            "come from encoders.)",
            plantTitles().at(c.plant), deep, s.depth.size(), 1e3 * most, s.lost, s.runs,
            s.lost == 0 && deep <= 3 && most < 1.1e-3 ? "holds" : "refuted"));
      }
    }
    const std::size_t ours = columnNamed(c, kPositionControl);
    std::size_t spring = columnNamed(c, std::string(kTuned) + kImpedance);
    if (spring == c.scores.size()) spring = columnNamed(c, kImpedance);
    if (c.plant == kClosedForm || ours == c.scores.size() || spring == c.scores.size()) continue;
    const WelchTest t = welchTest(spreadOf(c.scores[ours].stiffness), spreadOf(c.scores[spring].stiffness));
    items.push_back(fmt::format(
        "“Position control is stiffer than impedance” on {}, {}: {} against {} N/m (p {}), "
        "{} against {} runs lost: <b>{}</b>.",
        plantTitles().at(c.plant), delayText(c.delay), meanText(spreadOf(c.scores[ours].stiffness)),
        meanText(spreadOf(c.scores[spring].stiffness)), pText(t.p), c.scores[ours].lost, c.scores[spring].lost,
        !(t.t > 0.0 && t.p < 0.05) ? "does not hold"
        : c.scores[ours].lost == 0 ? "holds"
                                   : "stiffer, but runs are lost"));
  }
  page.list(items);
}

void addLaws(Page& page, const StudyOptions& options) {
  if (options.laws.empty()) return;
  std::vector<std::string> items;
  const ControllerFile file = loadControllers(options.laws);
  page.heading("The laws at their best");
  page.paragraph("Found on " + escape(file.model) +
                 " by <code>enamel design --rivals</code>: the same search under the same limits for each.");
  for (const ControllerValues& found : file.controllers) {
    const ControllerSpec& law = rivalSpec(found.controller);
    std::string text =
        fmt::format("{}, delay {}: ", law.title,
                    found.delayLow == found.delayHigh ? fmt::format("{}", found.delayLow)
                                                      : fmt::format("{}..{}", found.delayLow, found.delayHigh));
    for (std::size_t i = 0; i < found.values.size(); ++i)
      text += fmt::format("{}{} {:.4g} {}", i > 0 ? ", " : "", law.parameters[i].name, found.values[i],
                          law.parameters[i].unit);
    items.push_back(text);
  }
  page.list(items);
}

std::string pageOf(const StudyOptions& options, const std::vector<Condition>& conditions) {
  Page page;
  page.heading("In a hurry");
  for (const std::string& plant : options.plants) page.paragraph(sentenceOf(onPlant(conditions, plant)));
  page.heading("Which law would a user want?");
  page.paragraph(
      "Ranks from 1, the mean over six things that a hand feels: how deep the tool goes, how much the motors chatter, "
      "how "
      "much a frictionless wall drags, whether it pulls when let go, how much energy it gives, and what share of the "
      "stiffness that physics allows it reaches. A law that loses runs stands behind those that lose fewer. What a "
      "hand does not feel is as good as none: chatter below "
      "0.05 N m, drag below 3.5 %, a pull below 0.1 N, energy below 1 mJ.");
  for (const std::string& plant : options.plants) {
    const std::vector<const Condition*> here = onPlant(conditions, plant);
    std::string name = plantTitles().at(plant);
    name[0] = static_cast<char>(std::toupper(name[0]));
    page.heading(name);
    addRanks(page, here);
    addBoxes(page, here, conditions);
    for (const Condition* c : here) addFeel(page, *c);
  }
  page.note(
      "K_z1, depth, energy and share are of scenario 1, each with the 95 % interval of its mean where it has "
      "one; "
      "drag is the tangential over the normal force while a hand slides at 0.1 m/s, pull the strongest while a push of "
      "12 "
      "N turns to a pull of 1 N, both the worst of as many runs as a point has. Delays are in ticks.");
  page.heading("Are the differences real?");
  page.paragraph("Welch's test on the largest penetration of the runs of scenario 1.");
  for (const std::string& plant : options.plants) {
    page.paragraph("<b>" + plantTitles().at(plant) + "</b>");
    addTests(page, onPlant(conditions, plant));
  }
  page.heading("The paper's claims");
  addClaims(page, conditions);
  page.paragraph(
      "Table III: the largest penetration of a run, without delay and, in brackets, with a random one. The paper: all "
      "within 1 mm; with a random delay 3 of 90 above it, none above 1.1 mm.");
  addTableThree(page, conditions);
  page.paragraph(
      "Table IV: the lowest of the servo over the wall against the highest of the paper's spring of 6000 N/m. The "
      "paper: "
      "K_z1 17 174 against 3 112.6, in co-simulation 16 743 (13 367 with a random delay) against 5 360.2; "
      "K_zs 92 387 against 6 180.5, in co-simulation 34 306 (54 634) against 6 302.2.");
  addTableFour(page, conditions);
  addLaws(page, options);
  const StudyPlan& plan = conditions.front().study.plan;
  return page.whole(
      "Enamel: the laws judged",
      fmt::format("{}, laws designed on {}; {} x {} points x {} runs x {} scenarios a law, plant and delay; "
                  "encoders, preload {} N, seed {}",
                  escape(nameOf(conditions.front().study.device)),
                  escape(nameOf(conditions.front().study.designDevice)), plan.grid, plan.grid, plan.runs,
                  plan.scenarios.size(), options.preload, options.seed));
}

std::string tableOf(const std::vector<Condition>& conditions) {
  std::string text =
      "plant,delay,law,runs,lost,K_z1 [N/m],deviation K_z1 [N/m],runs with K_z1,depth [m],"
      "deviation depth [m],chatter [N m],drag [%],pull [N],energy [J],share,rank\n";
  const auto cell = [](double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); };
  for (const Condition& c : conditions)
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      const Score& s = c.scores[i];
      const Spread k = spreadOf(s.stiffness), d = spreadOf(s.depth);
      text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", c.plant, c.delay,
                          c.study.plan.columns[i].name, s.runs, s.lost, cell(k.mean), cell(k.deviation), k.count,
                          cell(d.mean), cell(d.deviation), cell(s.chatter), cell(s.drag()), cell(s.pull()),
                          cell(s.energy), cell(s.share), cell(s.rank));
    }
  return text;
}

// Without the HTML.
std::string plain(std::string text) {
  for (std::size_t at = 0; (at = text.find("&lt;")) != std::string::npos;) text.replace(at, 4, "<");
  return text;
}

}  // namespace

void runJudge(const StudyOptions& asked) {
  StudyOptions options = asked;
  if (options.device.empty()) throw Error("--judge needs --device, with its [imperfections]");
  if (options.plants.empty()) options.plants = {kClosedForm, kRealStiff, kReal};
  if (options.delays.empty()) options.delays = {"none", "constant:1", "constant:2", "constant:3", "random:0..3"};
  std::vector<Condition> conditions;
  for (const std::string& plant : options.plants)
    for (const std::string& delay : options.delays) {
      StudyOptions one = options;
      one.plant = plant;
      one.delay = delay;
      std::string name = plant + '-' + delay;
      std::replace(name.begin(), name.end(), ':', '-');
      one.output = options.output + '/' + name;
      conditions.push_back({plant, delay, prepareStudy(one), {}, {}, {}});
      for (ColumnLabel& label : conditions.back().study.labels) {
        if (label.kind == ColumnKind::hold) label.title = "the paper's hold";
        if (label.kind == ColumnKind::impedance) label.title = "the paper's spring";
        if (label.kind == ColumnKind::edge) label.title = "spring at 4 kHz, at the edge of eq. 16";
      }
    }
  bool complete = true;
  for (const Condition& c : conditions) {
    fmt::print(stderr, "{}, delay {}:\n", c.plant, c.delay);
    complete = completeRuns(c.study) && complete;
  }
  if (!complete) {
    fmt::print("part {} of {} is done; the last one writes the page\n", options.part, options.parts);
    return;
  }
  for (Condition& c : conditions) {
    const std::vector<StudyResult> runs = readRuns(c.study.plan, c.study.path("runs.csv"));
    c.points = pointStatistics(c.study.plan, runs);
    c.walls = summarise(c.study.plan, c.points);
    c.scores = scoresOf(c.study, runs);
    addTrials(c.study, c.scores);
    rank(c.scores);
    writeFile(c.study.path("points.csv"), pointsTable(c.study, c.points));
    writeFile(c.study.path("summary.json"), summaryOf(c.study, c.walls, {}));
  }
  writeFile(options.output + "/judge.csv", tableOf(conditions));
  writeFile(options.output + "/judge.html", pageOf(options, conditions));
  for (const std::string& plant : options.plants) fmt::print("{}\n", plain(sentenceOf(onPlant(conditions, plant))));
  fmt::print("page: {}/judge.html\n", options.output);
}

}  // namespace enamel::app
