// Report about a run, for tests and for tuning.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "enamel/runtime/periodic_thread.hpp"
#include "viewer.hpp"

namespace enamel::viewer {

TimingNumbers numbersOf(const PeriodicTiming& timing, double framesPerSecond);

class Report {
 public:
  explicit Report(double started) : started_(started) {}

  std::uint64_t frames() const { return frames_; }

  /// Add a picture; `time`: of the run, s.
  void frame(double time);
  void measureMemory(double time);
  /// Write JSON; an empty path writes nothing. Throws Error: as writeFile().
  void write(const std::string& path, double seconds, Viewer& viewer, const TimingNumbers& timing) const;

 private:
  double started_, firstFrame_ = 0.0, lastMemory_ = -1.0;
  std::uint64_t frames_ = 0;
  std::vector<double> memoryAt_;     // s of the run
  std::vector<long> memory_, heap_;  // once per second, and with each report
};

}  // namespace enamel::viewer
