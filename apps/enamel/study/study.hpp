// A study as the command runs it: the plan with its devices and servos, and the resulting files.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enamel/control/servo_design.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/study/run_file.hpp"
#include "study/options.hpp"
#include "study/plot.hpp"

namespace enamel::app {

/// Kind of a study's column. A plugin never counts as a linked renderer, even if it has the same name.
enum class ColumnKind { positionControl, hold, impedance, passivity, scheduled, edge, bestSpring, rival, plugin };

/// Texts for a column of the plan in tables and pictures.
struct ColumnLabel {
  ColumnKind kind = ColumnKind::plugin;
  std::string title;     ///< for people
  double damping = 0.0;  ///< mechanical, of its plant along z at home, N s/m
  std::string servo;     ///< own servo file; empty: the study's servo
  Style style = {};      ///< in plots
};

struct Study {
  StudyOptions options;
  DeviceParameters device, designDevice;
  std::shared_ptr<const Mechanism> mechanism;  ///< of `device`, with the drives of the plant
  std::shared_ptr<const Mechanism> design;     ///< model for which the renderers are designed
  std::optional<ServoDesign> home;  ///< servo of hold, possibly from --gain; set if a column is hold or scheduled
  StudyPlan plan;
  std::vector<ColumnLabel> labels;  ///< of the plan's columns
  std::string manifest;             ///< JSON with everything that determines the runs

  std::string path(const std::string& name) const { return options.output + '/' + name; }
  /// Return the range of runs of this process.
  RunRange range() const { return partOf(plan, options.part, options.parts); }
  std::string runsPath(int part) const;
  /// Return the index of the column of a linked renderer; columns.size() if the study does not have it.
  std::size_t column(ColumnKind kind) const;
  bool isTau() const { return std::holds_alternative<TauParameters>(device); }
};

/// Load, design and check everything. Throws Error.
Study prepareStudy(const StudyOptions& options);

/// Name of the file with the arguments of the command, in the study's folder.
inline constexpr const char* kCommandFile = "command.json";

/// Throw Error unless study.json in the folder describes this study.
void requireSame(const Study& study);

/// Perform the runs of a study or of its part. If all parts are complete, write runs.csv; otherwise return false.
/// Throws Error, and Exit after a signal.
bool completeRuns(const Study& study);

/// A claim of the paper's section VI on this device. It holds, or does not hold, only if its interval excludes the
/// opposite.
struct Claim {
  std::string text, measured;
  std::string verdict;  ///< "holds", "does not hold" or "not decided"
};
std::vector<Claim> claimsOf(const Study& study, const std::vector<StudyResult>& runs,
                            const std::vector<WallSummary>& walls);

/// Return the text of points.csv; summary.json is the next function.
std::string pointsTable(const Study& study, const std::vector<PointStatistics>& points);
std::string summaryOf(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims);

/// Format a query point in mm: "(-25, 10)".
std::string pointText(const Study& study, std::size_t point);

/// Return the CRC-32 of a text as eight hexadecimal digits, as common tools show it.
std::string checksumOf(const std::string& text);

/// Return the title of a plant; HTML.
std::string plantTitle(const std::string& plant);

/// Format a --delay: "no delay", "1 tick", "0..3 ticks".
std::string delayText(const std::string& delay);

/// Verdicts of pushes without a first-impact stiffness.
inline constexpr FirstImpactVerdict kWithoutFirst[] = {FirstImpactVerdict::rings, FirstImpactVerdict::slips,
                                                       FirstImpactVerdict::noReturn, FirstImpactVerdict::flies,
                                                       FirstImpactVerdict::unstable};

/// Return why runs have no first-impact stiffness: "2 rings, 1 slipped"; empty if all runs have one.
std::string withoutFirstText(const WallSummary& wall);

/// Return "2 runs left the workspace, 3 stopped by the guard"; empty if no run was lost.
std::string lostText(const WallSummary& wall);

/// Return whether any run of a wall was finished. If not, its largest values are unknown, not zero.
bool anyFinished(const Study& study, const WallSummary& wall);

/// Return the key of a metric, the same in every file.
inline std::string keyOf(const MetricMember& member) { return enamel::keyOf(allMetrics()[indexOf(member)]); }

}  // namespace enamel::app
