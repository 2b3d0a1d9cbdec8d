#include "compare/compare.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

#include "compare/page.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/study/parallel.hpp"
#include "program/outputs.hpp"
#include "study/pairs.hpp"

namespace enamel::app {
namespace {

bool hasPushes(const CompareOptions& options) {
  return std::count(options.tasks.begin(), options.tasks.end(), kPush) > 0;
}

// Prepare a study with its columns for one plant and one delay.
Condition conditionOf(const CompareOptions& options, const std::string& plant, const std::string& delay) {
  StudyOptions one = options.study;
  one.plant = plant;
  one.delay = delay;
  if (!hasPushes(options)) one.grid = 1;  // trials need only home within reach
  std::string name = plant + '-' + delay;
  std::replace(name.begin(), name.end(), ':', '-');
  one.output += '/' + name;
  Condition condition{plant, delay, prepareStudy(one), {}, {}, {}, {}};
  condition.scores = scoresOf(condition.study.plan, {});
  return condition;
}

std::vector<Condition> conditionsOf(const CompareOptions& options) {
  std::vector<Condition> conditions;
  for (const std::string& plant : options.plants)
    for (const std::string& delay : options.delays) conditions.push_back(conditionOf(options, plant, delay));
  return conditions;
}

// Return false if other parts of the runs are missing.
bool completePushes(const std::vector<Condition>& conditions) {
  bool complete = true;
  for (const Condition& c : conditions) {
    fmt::print(stderr, "{}, delay {}:\n", c.plant, c.delay);
    complete = completeRuns(c.study) && complete;
  }
  return complete;
}

void readPushes(Condition& c) {
  const std::vector<StudyResult> runs = readRuns(c.study.plan, c.study.path("runs.csv"));
  c.points = pointStatistics(c.study.plan, runs);
  c.walls = summarise(c.study.plan, c.points);
  c.scores = scoresOf(c.study.plan, runs);
  c.pairs = comparePairs(c.study.plan, runs, referenceOf(c.study),
                         {{1, &PushMetrics::depthStiffness, true, true}, {1, &PushMetrics::largestDepth, true, false}});
  writeFile(c.study.path("points.csv"), pointsTable(c.study, c.points));
  writeFile(c.study.path("summary.json"), summaryOf(c.study, c.walls, {}));
}

// Convert HTML to plain text.
std::string plain(std::string text) {
  constexpr std::pair<const char*, const char*> kEntities[] = {
      {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&amp;", "&"}};  // last: it must make no new entities
  for (const auto& [entity, character] : kEntities)
    for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
      text.replace(at, std::strlen(entity), character);
  return printable(text);
}

void writeResults(const CompareOptions& options, const std::vector<Condition>& conditions) {
  const std::string& folder = options.study.output;
  std::filesystem::create_directories(std::filesystem::u8path(folder));
  if (hasPushes(options)) writeFile(folder + "/compare.csv", comparisonTable(conditions));
  writeFile(folder + "/tasks.csv", tasksTable(conditions));
  writeFile(folder + "/compare.html", pageOf(options, conditions));
  if (hasPushes(options))
    for (const std::string& plant : options.plants) fmt::print("{}\n", plain(sentenceOf(onPlant(conditions, plant))));
  fmt::print("page: {}/compare.html\n", folder);
}

}  // namespace

void runCompare(CompareOptions options) {
  StudyOptions& study = options.study;
  if (study.threads == 0) study.threads = availableThreads();
  if (hasPushes(options) && study.output.empty())
    throw Error("the task push writes its runs into a folder: give --output");
  const bool continues = hasPushes(options) && (study.resume || study.parts > 1);
  if (!study.output.empty() && !continues)
    for (const char* name : {"compare.csv", "tasks.csv", "compare.html"})
      requireFree(study.output + '/' + name, study.overwrite);
  const std::vector<std::string> wallTasks = wallTasksOf(options.tasks);
  std::vector<Condition> conditions = conditionsOf(options);
  if (hasPushes(options) && !completePushes(conditions)) {
    fmt::print("part {} of {} is done; the last part to finish writes the page\n", study.part, study.parts);
    return;
  }
  for (Condition& c : conditions) {
    if (hasPushes(options)) readPushes(c);
    addWallTrials(c.study.plan, wallTasks, study.threads, c.scores);
    if (hasPushes(options)) rankRenderers(c.scores);
    if (!study.output.empty()) continue;
    if (&c != &conditions.front()) fmt::print("\n");
    printTasks(c);
  }
  std::vector<PairedComparison*> pairs;
  for (Condition& c : conditions)
    for (PairedComparison& pair : c.pairs) pairs.push_back(&pair);
  judgeWalls(pairs);
  if (!study.output.empty()) writeResults(options, conditions);
}

}  // namespace enamel::app
