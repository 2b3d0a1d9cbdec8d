// runs.csv: one line a run, in the order of the runs, written as they come. A process that is killed leaves a prefix of
// the whole file and at most one torn line, and another one can go on from there.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "enamel/study/monte_carlo.hpp"

namespace enamel {

/// The first line of the file, without its end: names of the columns with their units.
std::string runHeader();

/// A run as a line, without its end. Numbers are exact; a metric that a run does not have is empty.
std::string runLine(const StudyPlan& plan, const StudyResult& result);

/// Some of the runs of a study, one after the other.
struct RunRange {
  std::size_t first = 0, count = 0;
};

/// Part `number`, from 1, of `parts` that are as large as one another but for one run.
/// Throws Error: a number outside 1 to `parts`. Realtime: no.
RunRange partOf(const StudyPlan& plan, int number, int parts);

class RunFile {
 public:
  /// Opens the file to write. With `resume` it keeps the runs that are there, which must be those of the plan, and cuts
  /// a torn last line off; without, it starts an empty file.
  /// Throws Error: more runs than a file of kLargestRunFile holds; the file cannot be opened, written or locked
  /// (another process writes it); a line that is not the plan's or not as runLine() writes it. The plan must outlive
  /// this object. Realtime: no.
  RunFile(const StudyPlan& plan, std::string path, bool resume, const RunRange& range);
  RunFile(const StudyPlan& plan, std::string path, bool resume)
      : RunFile(plan, std::move(path), resume, {0, plan.size()}) {}

  /// Number of runs in the file: the first ones of its range.
  std::size_t finished() const noexcept { return finished_; }

  /// Writes the next run and hands it to the operating system. Throws Error: it cannot (is the disk full?).
  void append(const StudyResult& result);

 private:
  void write(const std::string& line);

  const StudyPlan& plan_;
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::size_t finished_ = 0;
};

/// Most bytes of a file of runs.
inline constexpr std::size_t kLargestRunFile = std::size_t{2} << 30;

/// Reads the whole lines of a file of runs, a torn last line left out. Throws Error: the file cannot be read; a line
/// that is not the plan's, or not as runLine() writes it. Realtime: no.
std::vector<StudyResult> readRuns(const StudyPlan& plan, const std::string& path, const RunRange& range);
inline std::vector<StudyResult> readRuns(const StudyPlan& plan, const std::string& path) {
  return readRuns(plan, path, {0, plan.size()});
}

}  // namespace enamel
