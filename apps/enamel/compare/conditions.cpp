#include "compare/conditions.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "compare/compare.hpp"
#include "enamel/core/error.hpp"
#include "study/numbers.hpp"

namespace enamel::app {

std::vector<std::string> wallTasksOf(const std::vector<std::string>& tasks) {
  const auto names = [](const std::string& task, const std::string& text) {
    return text != kPush && task.find(text) != std::string::npos;
  };
  const std::vector<std::string> all = wallTrialNames();
  std::string known = kPush;
  for (const std::string& task : all) known += ", " + task;
  for (const std::string& text : tasks)
    if (text != kPush && std::none_of(all.begin(), all.end(), [&](const auto& task) { return names(task, text); }))
      throw Error("no task matches --tasks " + text + ": must be part of the name of a task: " + known);
  std::vector<std::string> chosen;
  for (const std::string& task : all)
    if (std::any_of(tasks.begin(), tasks.end(), [&](const auto& text) { return names(task, text); }))
      chosen.push_back(task);
  return chosen;
}

std::string comparisonTable(const std::vector<Condition>& conditions) {
  std::string text =
      "plant,delay,renderer,runs,lost,K_z1 [N/m],deviation K_z1 [N/m],runs with K_z1,K_d [N/m],deviation K_d "
      "[N/m],depth [m],"
      "deviation depth [m],chatter [N m],drag [%],pull [N],energy [J],share,rank\n";
  for (const Condition& c : conditions)
    for (std::size_t i = 0; i < c.scores.size(); ++i) {
      const RendererScore& s = c.scores[i];
      const Spread k = spreadOf(s.stiffness), d = spreadOf(s.depth), deep = spreadOf(s.depthStiffness);
      text +=
          fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", c.plant, c.delay,
                      c.study.plan.columns[i].name, s.runs, s.lost, cellText(k.mean), cellText(k.deviation), k.count,
                      cellText(deep.mean), cellText(deep.deviation), cellText(d.mean), cellText(d.deviation),
                      cellText(s.chatter), cellText(s.figure("slide", "tangential force")),
                      cellText(s.figure("release", "pull")), cellText(s.energy), cellText(s.share), cellText(s.rank));
    }
  return text;
}

std::string tasksTable(const std::vector<Condition>& conditions) {
  std::string text = "plant,delay,renderer,task,figure,unit,value,runs lost\n";
  for (const Condition& c : conditions)
    for (std::size_t i = 0; i < c.scores.size(); ++i)
      for (const WallFigure& f : c.scores[i].trials)
        text += fmt::format("{},{},{},{},{},{},{},{}\n", c.plant, c.delay, c.study.plan.columns[i].name, f.trial,
                            f.figure, f.unit, cellText(f.value), f.lost);
  return text;
}

void printTasks(const Condition& condition) {
  const Study& study = condition.study;
  const double share = forceShare(*study.mechanism);
  fmt::print("{}: plant {}, delay {}, the worst of {} runs; noise {:.3g} N, forces scaled by {:.3g}\n",
             study.mechanism->name(), condition.plant, condition.delay, study.plan.runs,
             study.plan.setup.hand.noise * share, share);
  fmt::print("{:<16} {:<28} {:<4}", "", "", "");
  for (const StudyColumn& column : study.plan.columns) fmt::print(" {:>18}", column.name);
  fmt::print("\n");
  for (std::size_t row = 0; row < condition.scores.front().trials.size(); ++row) {
    const WallFigure& named = condition.scores.front().trials[row];
    fmt::print("{:<16} {:<28} {:<4}", named.trial, named.figure, named.unit);
    for (const RendererScore& score : condition.scores) {
      const WallFigure& f = score.trials[row];
      const std::string value = std::isnan(f.value) ? "-" : fmt::format("{:.3g}", f.value);
      fmt::print(" {:>18}", f.lost > 0 ? fmt::format("{} ({} lost)", value, f.lost) : value);
    }
    fmt::print("\n");
  }
}

}  // namespace enamel::app
