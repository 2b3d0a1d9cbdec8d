// What `enamel push` says about a push: every tick as CSV, the metrics as a table or as JSON.
#pragma once

#include <string>
#include <vector>

#include "enamel/core/file.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::app {

/// What a renderer that came to the end made of the push.
struct PushOutcome {
  std::string renderer;
  bool ofPaper;  ///< the linked hold or impedance, whose figures the paper has; not a plugin of the same name
  PushMetrics metrics;
};

/// A column a renderer, a row a metric.
std::string tableOf(const std::vector<PushOutcome>& outcomes, int scenario);

/// Metrics under the keys that files have (keyOf()), by renderer; what a run does not have is null.
std::string jsonOf(const std::vector<PushOutcome>& outcomes);

/// A CSV file with a line a tick: FileWriter. Throws Error.
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
