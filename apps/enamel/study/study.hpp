// A study as the command runs it: the plan with its devices and servos, and the files that come out of it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enamel/control/servo_design.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/study/run_file.hpp"
#include "study/options.hpp"

namespace enamel::app {

/// What a column of the study is. A plugin is never a linked renderer, whatever its name.
enum class ColumnKind { positionControl, hold, impedance, passivity, scheduled, edge, rival, plugin };

/// What tables and pictures say about a column of the plan.
struct ColumnLabel {
  ColumnKind kind = ColumnKind::plugin;
  std::string title;     ///< in words
  double damping = 0.0;  ///< mechanical, of its plant along z at home, N s/m
  std::string servo;     ///< file of its own; empty: as the study has it
};

struct Study {
  StudyOptions options;
  DeviceParameters device, designDevice;
  std::shared_ptr<const Mechanism> mechanism;  ///< of `device`, with the drives of the plant
  std::shared_ptr<const Mechanism> design;     ///< what renderers are designed on
  std::optional<ServoDesign> home;  ///< the servo of hold, also of --gain; where a column is hold or scheduled
  StudyPlan plan;
  std::vector<ColumnLabel> labels;  ///< of the plan's columns
  std::string manifest;             ///< everything that the runs depend on, JSON

  std::string path(const std::string& name) const { return options.output + '/' + name; }
  /// The runs of this process, and their file.
  RunRange range() const { return partOf(plan, options.part, options.parts); }
  std::string runsPath(int part) const;
  /// Index of the column of a linked renderer; columns.size() where the study does not have it.
  std::size_t column(ColumnKind kind) const;
  bool isTau() const { return std::holds_alternative<TauParameters>(device); }
};

/// Loads, designs and checks everything. Throws Error.
Study prepareStudy(const StudyOptions& options);

/// Performs the runs of a study, or of its part, and where all are there, leaves them in runs.csv; false: other parts
/// are not done. Throws Error, Exit where a signal ended it.
bool completeRuns(const Study& study);

/// What section VI claims, on our device: each with its number at the worst query point.
struct Claim {
  std::string text, measured;
  bool holds = false;
};
std::vector<Claim> claimsOf(const Study& study, const std::vector<PointStatistics>& points,
                            const std::vector<WallSummary>& walls);

/// points.csv and summary.json.
std::string pointsTable(const Study& study, const std::vector<PointStatistics>& points);
std::string summaryOf(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims);

/// A query point in mm, as "(-25, 10)".
std::string pointText(const Study& study, std::size_t point);

/// "no delay", "1 tick", "0..3 ticks", of --delay.
std::string delayText(const std::string& delay);

/// How a push ends without a first impact stiffness.
inline constexpr FirstImpactVerdict kWithoutFirst[] = {FirstImpactVerdict::rings, FirstImpactVerdict::slips,
                                                       FirstImpactVerdict::noReturn, FirstImpactVerdict::flies,
                                                       FirstImpactVerdict::unstable};

/// Why runs have no first impact stiffness, as "2 rings, 1 slipped"; empty where all have one.
std::string withoutFirstText(const WallSummary& wall);

/// "2 runs left the workspace, 3 stopped by the guard"; "" where none was lost.
std::string lostText(const WallSummary& wall);

/// Whether any run of a wall was finished. If not, its largest values are unknown, not zero.
bool anyFinished(const Study& study, const WallSummary& wall);

/// The key of a metric as every file has it.
inline std::string keyOf(const MetricMember& member) { return enamel::keyOf(allMetrics()[indexOf(member)]); }

}  // namespace enamel::app
