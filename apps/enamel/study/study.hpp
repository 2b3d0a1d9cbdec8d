// A study as the command runs it: the plan with its devices and servos, and the files that come out of it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enamel/study/monte_carlo.hpp"
#include "renderers.hpp"

namespace enamel::app {

using Json = nlohmann::ordered_json;

/// The servo designed at every query point instead of once at home (gain scheduling).
inline constexpr const char* kScheduled = "position-control-scheduled";

struct StudyOptions {
  std::string device, designDevice, output, delay = "none";
  std::vector<std::string> set;  ///< parameters of plugins
  std::vector<int> scenarios = {1, 2};
  std::vector<std::string> renderers = {kPositionControl, kImpedance, kScheduled};
  int runs = 20, grid = 11, threads = 0;
  std::uint64_t seed = 1;
  bool encoders = false, resume = false, convergence = false;
  bool release = false;  ///< the hold ends when the wall would pull; the paper's never does
};

struct Study {
  StudyOptions options;
  TauParameters device, designDevice;
  TauModel designModel;  ///< what the renderers know
  ImpedanceOptions impedance{6000.0, 0.0, 4.0};
  ServoDesign home;  ///< the servo of position-control
  StudyPlan plan;
  Json manifest;  ///< everything that the runs depend on

  std::string path(const std::string& name) const { return options.output + '/' + name; }
  /// Index of a column; columns.size() where the study does not have it.
  std::size_t column(const std::string& name) const;
};

/// Loads, designs and checks everything. Throws Error.
Study prepareStudy(const StudyOptions& options);

/// Writes a whole file, or throws Error that says why not.
void writeFile(const std::string& path, const std::string& text);

/// What section VI claims, on our device: each with its number at the worst query point.
struct Claim {
  std::string text, measured;
  bool holds = false;
};
std::vector<Claim> claimsOf(const Study& study, const std::vector<PointStatistics>& points,
                            const std::vector<WallSummary>& walls);

/// points.csv and summary.json.
std::string pointsTable(const Study& study, const std::vector<PointStatistics>& points);
Json summaryOf(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims);

/// A query point in mm, as "(-25, 10)".
std::string pointText(const Study& study, std::size_t point);

}  // namespace enamel::app
