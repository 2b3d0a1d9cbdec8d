// Output of `enamel push`: every tick as CSV, the metrics as a table or as JSON.
#pragma once

#include <string>
#include <vector>

#include "enamel/core/file.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::app {

/// Result of a renderer that completed the push.
struct PushOutcome {
  std::string renderer;
  bool ofPaper;  ///< linked hold or impedance: the paper has their values; not a plugin of that name
  PushMetrics metrics;
};

/// Return a table with one column for each renderer and one row for each metric.
std::string tableOf(const std::vector<PushOutcome>& outcomes, int scenario);

/// Return the metrics by renderer, under the keys used in files (keyOf()). Missing values are null.
std::string jsonOf(const std::vector<PushOutcome>& outcomes);

/// A CSV file with one line for each tick; uses FileWriter. Throws Error.
class TickFile {
 public:
  TickFile(const std::string& path, const Mechanism& device);
  void write(const TickRecord& tick);
  void close() { file_.close(); }

 private:
  void append(const double* values, Eigen::Index count);

  std::string line_;
  FileWriter file_;
};

}  // namespace enamel::app
