// `enamel compare`: many renderers on many plants, at many delays, in many tasks.
#pragma once

#include "study/options.hpp"

namespace enamel::app {

/// The task that is a study of its own (runs.csv); every other one is a wall trial (wallTrialNames()).
inline constexpr const char* kPush = "push";

struct CompareOptions {
  StudyOptions study;  ///< what every plant and delay have in common; without `output`, a table on the terminal
  std::vector<std::string> plants, delays, tasks;  ///< tasks: kPush, and texts that names of wall trials contain
};

/// Perform every task of every plant and delay, kPush in a folder each. Without `output` print a table a plant and
/// delay; with it write compare.html, compare.csv (where kPush is a task) and tasks.csv. Throws Error, Exit where a
/// signal ended it.
void runCompare(CompareOptions options);

}  // namespace enamel::app
