// How each renderer did on a plant at a delay, and their ranks.
#pragma once

#include <string>
#include <vector>

#include "enamel/study/wall_trials.hpp"
#include "study/study.hpp"

namespace enamel::app {

/// Figures of a push are of scenario 1, but for the runs that were lost.
struct Score {
  int runs = 0, lost = 0;                ///< left the workspace, stopped by the guard, or unstable on the wall
  std::vector<double> stiffness, depth;  ///< K_z1, N/m; largest penetration, m
  std::vector<double> depthOfHand;       ///< the same of scenario 2
  double share = 0.0;                    ///< of the limit, mean; a run without K_z1 has none of it
  double chatter, energy;                ///< means; N m; given to the tool, J
  std::vector<WallFigure> tasks;         ///< of the wall trials
  double rank;                           ///< mean over criteria()

  Score();
  /// Of a wall trial; infinite where a run was lost, NaN where it was not performed.
  double figure(const std::string& task, const std::string& name) const;
  double drag() const { return figure("slide", "tangential force"); }
  double pull() const { return figure("release", "pull"); }
};

/// What renderers are ranked by.
struct Criterion {
  const char *name, *unit;
  double (*value)(const Score&);
  double scale;  ///< to the unit
  /// Below it a hand feels nothing (in SI or %): the chatter that the search allows, half of the smallest difference
  /// of force that is noticed (7 %: Pang, Tan and Durlach 1991), and what we take for the pull and the energy.
  double felt;
  bool moreIsBetter;
};
const std::vector<Criterion>& criteria();

/// One plant at one delay.
struct Condition {
  std::string plant, delay;
  Study study;
  std::vector<PointStatistics> points;
  std::vector<WallSummary> walls;
  std::vector<Score> scores;  ///< by column

  const std::string& title(std::size_t column) const { return study.labels[column].title; }
};

/// The wall trials that --tasks names. Throws Error: a text that no task has.
std::vector<std::string> wallTasksOf(const std::vector<std::string>& tasks);

/// Figures of the runs of the task kPush into the scores of a condition.
void addPushes(const std::vector<StudyResult>& runs, Condition& condition);

/// Perform wall trials, by their names, with every renderer of a condition.
void addWallTasks(const std::vector<std::string>& tasks, Condition& condition);

/// Ranks from 1, equal ones share theirs. A renderer that lost runs ranks behind all that lost fewer.
void rank(std::vector<Score>& scores);
std::size_t bestOf(const std::vector<Score>& scores);

double meanOf(const std::vector<double>& values);

/// Largest of some depths, m; 0 where there is none.
double deepestOf(const std::vector<double>& depths);

/// compare.csv: a line a plant, delay and renderer; tasks.csv: a line each of their figures too.
std::string comparisonTable(const std::vector<Condition>& conditions);
std::string tasksTable(const std::vector<Condition>& conditions);

/// The figures of the wall trials on the terminal, a column a renderer.
void printTasks(const Condition& condition);

}  // namespace enamel::app
