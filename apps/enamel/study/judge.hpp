// `enamel study --judge`: every law on every plant at every delay, and which one a user would want.
#pragma once

#include "study/options.hpp"

namespace enamel::app {

/// Performs the studies of all plants and delays, each in a folder of its own, and the trials (runWallTrials()); writes
/// judge.html and judge.csv. Throws Error, Exit where a signal ended it.
void runJudge(const StudyOptions& options);

}  // namespace enamel::app
