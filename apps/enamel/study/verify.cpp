#include <fmt/core.h>

#include <algorithm>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/run_file.hpp"
#include "study/study.hpp"

namespace enamel::app {

void verifyStudy(StudyOptions options) {
  constexpr std::size_t kSample = 20;
  options.threads = availableThreads();
  const Study study = prepareStudy(options);
  requireSame(study);
  const StudyPlan& plan = study.plan;
  const std::string path = study.path("runs.csv");
  const std::vector<StudyResult> runs = readRuns(plan, path);
  if (runs.size() < plan.size())
    throw Error(fmt::format("{}: has {} of {} runs; --resume performs the others", path, runs.size(), plan.size()));
  const std::size_t count = std::min(kSample, plan.size());
  std::vector<std::size_t> sample;  // evenly over all scenarios, renderers and points
  for (std::size_t i = 0; i < count; ++i) sample.push_back((2 * i + 1) * plan.size() / (2 * count));
  std::vector<std::string> again(count);
  parallelFor(count, options.threads,
              [&](std::size_t i) { again[i] = runLine(plan, performRun(plan, runAt(plan, sample[i]))); });
  for (std::size_t i = 0; i < count; ++i)
    if (const std::string before = runLine(plan, runs[sample[i]]); before != again[i])
      throw Error(fmt::format("{}: run {} differs when repeated:\n{}\n{}", path, sample[i] + 1, before, again[i]));
  if (readFile(study.path("points.csv")) != pointsTable(study, pointStatistics(plan, runs)))
    throw Error(study.path("points.csv") + ": does not follow from runs.csv");
  fmt::print("verified: {} of {} runs are repeated to the last bit, and points.csv follows from runs.csv\n", count,
             plan.size());
}

}  // namespace enamel::app
