// The plants and delays of a comparison, and their numbers as files and on the terminal.
#pragma once

#include <string>
#include <vector>

#include "enamel/study/comparison.hpp"
#include "study/study.hpp"

namespace enamel::app {

/// One plant at one delay.
struct Condition {
  std::string plant, delay;
  Study study;
  std::vector<PointStatistics> points;
  std::vector<WallSummary> walls;
  std::vector<RendererScore> scores;  ///< by column

  const std::string& title(std::size_t column) const { return study.labels[column].title; }
};

/// The wall trials that --tasks names. Throws Error: a text that no task has.
std::vector<std::string> wallTasksOf(const std::vector<std::string>& tasks);

/// compare.csv: a line a plant, delay and renderer; tasks.csv: a line each of their figures too.
std::string comparisonTable(const std::vector<Condition>& conditions);
std::string tasksTable(const std::vector<Condition>& conditions);

/// The figures of the wall trials on the terminal, a column a renderer.
void printTasks(const Condition& condition);

}  // namespace enamel::app
