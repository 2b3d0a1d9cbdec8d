// Monte Carlo over a wall ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section V): which
// runs, their statistics at every query point, and what holds over the whole wall.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enamel/study/metrics.hpp"

namespace enamel {

/// A renderer of the study, with the mechanism that it runs on and takes its plant for.
struct StudyColumn {
  std::string name;
  std::shared_ptr<const Mechanism> plant;
  /// Makes the renderer for a query point; called from any thread.
  std::function<std::unique_ptr<Renderer>(std::size_t point)> make;
  /// Makes the plant of a run where it is not the closed form of `plant`; called from any thread.
  std::function<std::unique_ptr<Plant>(std::uint32_t stream)> makePlant = {};
  /// Its ticks where they are shorter than the study's, s: a whole number of them is one of the study's. A delay stays
  /// as long, and the hand's noise as dense. 0: the study's.
  double period = 0.0;
  std::shared_ptr<const Mechanism> model = {};  ///< what the renderer takes the plant for; null: `plant`
};

/// Everything that determines a study. Runs are numbered scenario by scenario, column by column, point by point.
struct StudyPlan {
  std::vector<int> scenarios = {1, 2};
  std::vector<StudyColumn> columns;
  int grid = 11;                                  ///< query points along x, and along y
  double halfWidth = 0.025;                       ///< of the grid, m
  Vec3 middle = Vec3::Zero();                     ///< of the grid, m
  int runs = 20;                                  ///< a query point
  double lowestForce = 8.0, highestForce = 15.0;  ///< of F_c, uniform between, N
  PushSetup setup;          ///< of every run; start, scenario, force, instant and run number are its own
  bool insideTick = false;  ///< the step comes at randomInstant() of its tick; false: at setup.hand.instant

  std::size_t points() const { return static_cast<std::size_t>(grid) * static_cast<std::size_t>(grid); }
  std::size_t size() const;  ///< number of runs
};

inline constexpr int kMaxGrid = 101, kMaxRuns = 10000;

/// Checks a plan before any run. Throws Error: grid outside 1 to kMaxGrid; runs outside 1 to kMaxRuns; no scenario, no
/// column; as checkPush() for every scenario; a query point that a plant cannot reach. Realtime: no.
void checkStudy(const StudyPlan& plan);

/// Query point by its number, x running fastest, both from the negative end, at the height of the grid's middle, m.
/// Realtime: yes.
Vec3 queryPoint(const StudyPlan& plan, std::size_t point) noexcept;

/// One run of a study. The columns share their random numbers: F_c, noise, delays and instants depend on the seed, the
/// scenario, the point and the number of the run at the point alone.
struct StudyRun {
  int scenario = 1;
  std::size_t column = 0, point = 0;
  int run = 0;
  double force = 0.0;        ///< F_c, N
  std::uint32_t stream = 0;  ///< of the random numbers
};

/// Run by its number. Throws Error: the plan has no run of that number. Realtime: no.
StudyRun runAt(const StudyPlan& plan, std::size_t index);

/// What came out of a run. `status` is ok, or why it could not go on: then there are no metrics, but where the guard
/// has stopped it (stopped) the verdict.
struct StudyResult {
  StudyRun run;
  Status status = Status::ok;
  PushMetrics metrics;
};

/// The push of a run. Throws Error: a column or point that the plan does not have.
PushSetup setupOf(const StudyPlan& plan, const StudyRun& run);

/// Performs a run; `record`, if any, sees every tick. Throws Error: as runPush(); a column or
/// point that the plan does not have. Realtime: no; any thread.
StudyResult performRun(const StudyPlan& plan, const StudyRun& run,
                       const std::function<void(const TickRecord&)>& record = {});

/// Mean and standard deviation (n - 1) of what was measured; NaN where there are not enough values.
struct Spread {
  int count = 0;
  double mean = std::numeric_limits<double>::quiet_NaN(), deviation = mean;
};
Spread spreadOf(const std::vector<double>& values);

/// Numbers of runs by how their first impact ended; a run that failed is in none.
using VerdictCounts = std::array<int, kVerdicts>;

/// The runs of one scenario and column at one query point.
struct PointStatistics {
  int scenario = 1;
  std::size_t column = 0, point = 0;
  int runs = 0, failed = 0;               ///< failed: not in the figures below; the plant left its workspace, or
  int stopped = 0;                        ///< of these: the guard stopped the renderer
  VerdictCounts verdicts{};               ///< of the first impact
  std::array<Spread, kMetrics> metrics;   ///< of each of allMetrics(), over the runs that have it
  std::optional<double> steadyStiffness;  ///< K_zs = 1 / |mean C_zs|, N/m; nothing where unresolved: |mean C_zs| below
                                          ///< two standard errors, fewer than two runs, or one that is unstable
  Spread forceOverRms;                    ///< F_c / rms depth, N/m
  Spread forceOver95;                     ///< F_c / 95th percentile of the depth, N/m
  double largestDepth = 0.0;              ///< of all runs, m
  double drift = 0.0;                     ///< largest, m
  std::uint64_t faults = 0;

  const Spread& of(const MetricMember& member) const noexcept { return metrics[indexOf(member)]; }
};

/// Return whether a run is lost: it left the workspace, the guard stopped it, or it is unstable. Realtime: yes.
bool isLost(const StudyResult& run) noexcept;

/// Statistics of the runs of one point. Realtime: no.
PointStatistics statisticsOf(const std::vector<StudyResult>& runs);

/// Statistics of all points, scenario by scenario, column by column; `results` in the order of their numbers, complete.
std::vector<PointStatistics> pointStatistics(const StudyPlan& plan, const std::vector<StudyResult>& results);

/// A value and the query point that has it.
struct Extreme {
  double value = 0.0;
  std::size_t point = 0;
};

/// What holds over the wall for one scenario and column. "Lowest" is the lowest of the points' means.
struct WallSummary {
  int scenario = 1;
  std::size_t column = 0;
  std::optional<Extreme> lowestFirst, highestFirst;                   ///< K_z1, N/m
  std::optional<Extreme> lowestDepthStiffness;                        ///< K_d, N/m
  Spread depthStiffness;                                              ///< K_d over the points
  std::optional<Extreme> lowestShare;                                 ///< K_z1 over what physics allows
  std::optional<Extreme> lowestSteady, highestSteady;                 ///< K_zs, N/m, of the points that are resolved
  std::optional<Extreme> lowestCompliance, highestCompliance;         ///< |mean C_zs|, m/N
  Spread steady;                                                      ///< K_zs over the resolved points
  int unresolved = 0;                                                 ///< points without K_zs
  double lowestOverRms = 0.0, lowestOver95 = 0.0;                     ///< F_c / rms and F_c / 95th percentile, N/m
  double largestDepth = 0.0, drift = 0.0;                             ///< m
  double chatter = 0.0, saturatedShare = 0.0, tangentialForce = 0.0;  ///< largest of the points' means
  double bounce = 0.0;                                                ///< likewise, m
  int failed = 0, stopped = 0;                                        ///< runs that were lost; those by the guard
  VerdictCounts verdicts{};                                           ///< of the others' first impacts
  std::uint64_t faults = 0;

  /// Runs with a step of force and without a first impact stiffness; whether none was lost or unstable.
  int withoutFirst() const noexcept;
  bool stable() const noexcept {
    return failed == 0 && verdicts[static_cast<std::size_t>(FirstImpactVerdict::unstable)] == 0;
  }
};

/// Summaries, scenario by scenario, column by column. Realtime: no.
std::vector<WallSummary> summarise(const StudyPlan& plan, const std::vector<PointStatistics>& points);

}  // namespace enamel
