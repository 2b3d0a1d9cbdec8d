// runs.csv: one line per run, in the order of the runs, each written when its run ends. If a process is killed, the
// file has complete lines and at most one truncated line. Another process can continue from there.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "enamel/study/monte_carlo.hpp"

namespace enamel {

/// Return the first line of the file, without its line end: names of the columns with their units. Realtime: no.
std::string runHeader();

/// Return a run as a line, without its line end. Numbers are exact. A metric that a run does not have is empty.
/// Realtime: no.
std::string runLine(const StudyPlan& plan, const StudyResult& result);

/// A range of the runs of a study.
struct RunRange {
  std::size_t first = 0, count = 0;
};

/// Return part `number`, from 1, of `parts` parts. Their sizes differ by at most one run. Throws Error if the number is
/// outside 1 to `parts`. Realtime: no.
RunRange partOf(const StudyPlan& plan, int number, int parts);

class RunFile {
 public:
  /// Open the file for writing. With `resume`, keep its runs, which must be those of the plan, and remove a truncated
  /// last line. Otherwise start an empty file. The plan must outlive this object. Throws Error in these cases:
  ///
  /// - a file of kLargestRunFile bytes cannot hold all runs;
  /// - the file cannot be opened, written or locked (another process writes it);
  /// - a line is not the plan's, or not as runLine() writes it.
  ///
  /// Realtime: no.
  RunFile(const StudyPlan& plan, std::string path, bool resume, const RunRange& range);
  RunFile(const StudyPlan& plan, std::string path, bool resume)
      : RunFile(plan, std::move(path), resume, {0, plan.size()}) {}

  /// Return the number of runs in the file: the first ones of its range.
  std::size_t finished() const noexcept { return finished_; }

  /// Write the next run and pass it to the operating system. Throws Error if it cannot be written (disk full?).
  /// Realtime: no.
  void append(const StudyResult& result);

 private:
  void write(const std::string& line);

  const StudyPlan& plan_;
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::size_t finished_ = 0;
};

/// Largest size of a file of runs, bytes.
inline constexpr std::size_t kLargestRunFile = std::size_t{2} << 30;

/// Read the complete lines of a file of runs; ignore a truncated last line. Throws Error if the file cannot be read, or
/// a line is not the plan's or not as runLine() writes it. Realtime: no.
std::vector<StudyResult> readRuns(const StudyPlan& plan, const std::string& path, const RunRange& range);
inline std::vector<StudyResult> readRuns(const StudyPlan& plan, const std::string& path) {
  return readRuns(plan, path, {0, plan.size()});
}

}  // namespace enamel
