// `enamel compare`: compares renderers on several plants, at several delays, in several tasks.
#pragma once

#include "study/options.hpp"

namespace enamel::app {

/// The task that is a study of its own (runs.csv). Every other task is a wall trial (wallTrialNames()).
inline constexpr const char* kPush = "push";

struct CompareOptions {
  StudyOptions study;  ///< settings common to all plants and delays; without `output`, print a table
  std::vector<std::string> plants, delays, tasks;  ///< tasks: kPush, and parts of the names of wall trials
};

/// Perform every task for every plant and delay; each study of kPush has its own folder. Without `output`, print one
/// table for each plant and delay. With it, write compare.html, compare.csv (if kPush is a task) and tasks.csv. Throws
/// Error, and Exit after a signal.
void runCompare(CompareOptions options);

}  // namespace enamel::app
