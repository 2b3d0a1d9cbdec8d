// How a run went, for tests and for people who tune.
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

  /// After every picture; `time` is the run's, s.
  void frame(double time);
  void measureMemory(double time);
  /// JSON; nothing where the path is empty. Throws Error: as writeFile().
  void write(const std::string& path, double seconds, Viewer& viewer, const TimingNumbers& timing) const;

 private:
  double started_, firstFrame_ = 0.0, lastMemory_ = -1.0;
  std::uint64_t frames_ = 0;
  std::vector<double> memoryAt_;     // s of the run
  std::vector<long> memory_, heap_;  // once a second, and with each report
};

}  // namespace enamel::viewer
