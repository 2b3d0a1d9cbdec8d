#include "compare/scores.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/compare.hpp"
#include "enamel/core/error.hpp"

namespace enamel::app {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

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

std::string cell(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

}  // namespace

Score::Score() : chatter(kNone), energy(kNone), rank(kNone) {}

double Score::figure(const std::string& task, const std::string& name) const {
  for (const WallFigure& f : tasks)
    if (f.trial == task && f.figure == name) return f.lost > 0 ? std::numeric_limits<double>::infinity() : f.value;
  return kNone;
}

double meanOf(const std::vector<double>& values) { return spreadOf(values).mean; }

double deepestOf(const std::vector<double>& depths) {
  double most = 0.0;
  for (const double depth : depths) most = std::max(most, depth);
  return most;
}

const std::vector<Criterion>& criteria() {
  static const std::vector<Criterion> all = {
      {"depth", "µm", [](const Score& s) { return meanOf(s.depth); }, 1e6, 0.0, false},
      {"chatter", "N m", [](const Score& s) { return s.chatter; }, 1.0, 0.05, false},
      {"drag", "%", [](const Score& s) { return s.drag(); }, 1.0, 3.5, false},
      {"pull", "N", [](const Score& s) { return s.pull(); }, 1.0, 0.1, false},
      {"energy given", "mJ", [](const Score& s) { return s.energy; }, 1e3, 1e-3, false},
      {"share of the limit", "%", [](const Score& s) { return s.share; }, 100.0, 0.0, true},
  };
  return all;
}

std::vector<std::string> wallTasksOf(const std::vector<std::string>& tasks) {
  const auto names = [](const std::string& task, const std::string& text) {
    return text != kPush && task.find(text) != std::string::npos;
  };
  const std::vector<std::string> all = wallTrialNames();
  std::string known = kPush;
  for (const std::string& task : all) known += ", " + task;
  for (const std::string& text : tasks)
    if (text != kPush && std::none_of(all.begin(), all.end(), [&](const auto& task) { return names(task, text); }))
      throw Error("no task matches --tasks " + text + ": there are " + known);
  std::vector<std::string> chosen;
  for (const std::string& task : all)
    if (std::any_of(tasks.begin(), tasks.end(), [&](const auto& text) { return names(task, text); }))
      chosen.push_back(task);
  return chosen;
}

void addPushes(const std::vector<StudyResult>& runs, Condition& condition) {
  std::vector<Score>& scores = condition.scores;
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
}

void addWallTasks(const std::vector<std::string>& tasks, Condition& condition) {
  const StudyPlan& plan = condition.study.plan;
  const PushSetup& push = plan.setup;
  for (std::size_t c = 0; c < plan.columns.size(); ++c) {
    const StudyColumn& column = plan.columns[c];
    WallTrialSetup setup;
    setup.plant = column.plant;
    setup.model = column.model ? column.model : column.plant;
    setup.renderer = [&column] { return column.make(0); };
    setup.makePlant = column.makePlant;
    setup.period = column.period > 0.0 ? column.period : push.period;
    const int ticks = static_cast<int>(std::lround(push.period / setup.period));
    setup.delay = {push.delay.low * ticks, push.delay.high * ticks};
    setup.noise = push.person.noise;
    setup.runs = plan.runs;
    setup.seed = push.seed;
    for (const std::string& task : tasks)
      for (const WallFigure& figure : runWallTrials(setup, task, condition.study.options.threads))
        condition.scores[c].tasks.push_back(figure);
  }
}

void rank(std::vector<Score>& scores) {
  for (Score& score : scores) score.rank = 0.0;
  for (const Criterion& criterion : criteria()) {
    const std::vector<double> ranks = ranksBy(criterion, scores);
    for (std::size_t c = 0; c < scores.size(); ++c) scores[c].rank += ranks[c] / static_cast<double>(criteria().size());
  }
}

std::size_t bestOf(const std::vector<Score>& scores) {
  const auto best =
      std::min_element(scores.begin(), scores.end(), [](const Score& a, const Score& b) { return a.rank < b.rank; });
  return static_cast<std::size_t>(best - scores.begin());
}

std::string comparisonTable(const std::vector<Condition>& conditions) {
  std::string text =
      "plant,delay,renderer,runs,lost,K_z1 [N/m],deviation K_z1 [N/m],runs with K_z1,depth [m],"
      "deviation depth [m],chatter [N m],drag [%],pull [N],energy [J],share,rank\n";
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

std::string tasksTable(const std::vector<Condition>& conditions) {
  std::string text = "plant,delay,renderer,task,figure,unit,value,runs lost\n";
  for (const Condition& c : conditions)
    for (std::size_t i = 0; i < c.scores.size(); ++i)
      for (const WallFigure& f : c.scores[i].tasks)
        text += fmt::format("{},{},{},{},{},{},{},{}\n", c.plant, c.delay, c.study.plan.columns[i].name, f.trial,
                            f.figure, f.unit, cell(f.value), f.lost);
  return text;
}

void printTasks(const Condition& condition) {
  const Study& study = condition.study;
  const double share = forceShare(*study.mechanism);
  fmt::print("{}: plant {}, delay {}, the worst of {} runs; noise {:.3g} N, forces {:.3g} of what the names say\n",
             study.mechanism->name(), condition.plant, condition.delay, study.plan.runs,
             study.plan.setup.person.noise * share, share);
  fmt::print("{:<16} {:<28} {:<4}", "", "", "");
  for (const StudyColumn& column : study.plan.columns) fmt::print(" {:>18}", column.name);
  fmt::print("\n");
  for (std::size_t row = 0; row < condition.scores.front().tasks.size(); ++row) {
    const WallFigure& named = condition.scores.front().tasks[row];
    fmt::print("{:<16} {:<28} {:<4}", named.trial, named.figure, named.unit);
    for (const Score& score : condition.scores) {
      const WallFigure& f = score.tasks[row];
      const std::string value = std::isnan(f.value) ? "-" : fmt::format("{:.3g}", f.value);
      fmt::print(" {:>18}", f.lost > 0 ? fmt::format("{} ({} lost)", value, f.lost) : value);
    }
    fmt::print("\n");
  }
}

}  // namespace enamel::app
