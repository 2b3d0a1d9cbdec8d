// Plants and delays of a comparison, and their results for files and the terminal.
#pragma once

#include <string>
#include <vector>

#include "enamel/study/comparison.hpp"
#include "enamel/study/paired.hpp"
#include "study/study.hpp"

namespace enamel::app {

/// One plant at one delay.
struct Condition {
  std::string plant, delay;
  Study study;
  std::vector<PointStatistics> points;
  std::vector<WallSummary> walls;
  std::vector<RendererScore> scores;    ///< one for each column
  std::vector<PairedComparison> pairs;  ///< stiffness K_d and largest depth of scenario 1, against referenceOf()

  const std::string& title(std::size_t column) const { return study.labels[column].title; }
};

/// Return the wall trials that --tasks selects. Throws Error: a text that matches no task.
std::vector<std::string> wallTasksOf(const std::vector<std::string>& tasks);

/// Return the text of compare.csv, with one line for each plant, delay and renderer. tasks.csv (next function) has one
/// line for each of their figures as well.
std::string comparisonTable(const std::vector<Condition>& conditions);
std::string tasksTable(const std::vector<Condition>& conditions);

/// Print the figures of the wall trials, one column for each renderer.
void printTasks(const Condition& condition);

}  // namespace enamel::app
