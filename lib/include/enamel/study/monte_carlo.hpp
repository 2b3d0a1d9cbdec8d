// Monte Carlo study of a wall ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section V). It
// has runs, their statistics at each query point, and summaries of the whole wall.
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

/// A renderer of the study, its plant, and the mechanism that it assumes.
struct StudyColumn {
  std::string name;
  std::shared_ptr<const Mechanism> plant;
  /// Make the renderer for a query point. Called from any thread.
  std::function<std::unique_ptr<Renderer>(std::size_t point)> make;
  /// Make the plant of a run, if it is not the closed form of `plant`. Called from any thread.
  std::function<std::unique_ptr<Plant>(std::uint32_t stream)> makePlant = {};
  /// Period of its ticks, s, if shorter than the study's; 0: the study's. The study's period must be a whole multiple
  /// of it. A delay has the same duration, and the hand's noise the same density.
  double period = 0.0;
  std::shared_ptr<const Mechanism> model = {};  ///< mechanism that the renderer assumes; null: `plant`
};

/// All data of a study. Runs are numbered scenario by scenario, column by column, point by point.
struct StudyPlan {
  std::vector<int> scenarios = {1, 2};
  std::vector<StudyColumn> columns;
  int grid = 11;                                  ///< query points along x and along y
  double halfWidth = 0.025;                       ///< of the grid, m
  Vec3 middle = Vec3::Zero();                     ///< of the grid, m
  int runs = 20;                                  ///< per query point
  double lowestForce = 8.0, highestForce = 15.0;  ///< of F_c, uniform in between, N
  /// Setup of every run. Each run sets its own start, scenario, force, instant and number.
  PushSetup setup;
  /// True: the step is at randomInstant() of its tick. False: at setup.hand.instant.
  bool insideTick = false;

  std::size_t points() const { return static_cast<std::size_t>(grid) * static_cast<std::size_t>(grid); }
  std::size_t size() const;  ///< number of runs
};

inline constexpr int kMaxGrid = 101, kMaxRuns = 10000;

/// Check a plan before any run. Throws Error as checkPush() for each scenario, and in these cases:
///
/// - grid outside 1 to kMaxGrid, or runs outside 1 to kMaxRuns;
/// - no scenarios or columns;
/// - a query point that a plant cannot reach.
///
/// Realtime: no.
void checkStudy(const StudyPlan& plan);

/// Return a query point by its number, m. x varies fastest; x and y begin at their negative ends. z is that of the
/// grid's middle. Realtime: yes.
Vec3 queryPoint(const StudyPlan& plan, std::size_t point) noexcept;

/// One run of a study. All columns use the same random numbers. F_c, noise, delays and instants depend only on the
/// seed, the scenario, the point and the run's number at the point.
struct StudyRun {
  int scenario = 1;
  std::size_t column = 0, point = 0;
  int run = 0;
  double force = 0.0;        ///< F_c, N
  std::uint32_t stream = 0;  ///< random stream
};

/// Return a run by its number. Throws Error if the plan does not have that number. Realtime: no.
StudyRun runAt(const StudyPlan& plan, std::size_t index);

/// Result of a run. `status` is ok, or the reason why the run ended early; the metrics are then missing. If the guard
/// stopped the run (stopped), the metrics contain only the verdict.
struct StudyResult {
  StudyRun run;
  Status status = Status::ok;
  PushMetrics metrics;
};

/// Return the push of a run. Throws Error if the plan does not have its column or point. Realtime: no.
PushSetup setupOf(const StudyPlan& plan, const StudyRun& run);

/// Perform a run. `record`, if given, receives every tick. Throws Error as runPush(), and if the plan does not have its
/// column or point. Realtime: no. Threads: any.
StudyResult performRun(const StudyPlan& plan, const StudyRun& run,
                       const std::function<void(const TickRecord&)>& record = {});

/// Mean and standard deviation (n - 1) of values; NaN if there are too few values.
struct Spread {
  int count = 0;
  double mean = std::numeric_limits<double>::quiet_NaN(), deviation = mean;
};
Spread spreadOf(const std::vector<double>& values);

/// Numbers of runs per verdict of the first impact. Failed runs are not counted.
using VerdictCounts = std::array<int, kVerdicts>;

/// Statistics of the runs of one scenario and column at one query point.
struct PointStatistics {
  int scenario = 1;
  std::size_t column = 0, point = 0;
  /// Failed: the plant left its workspace, or the guard stopped the renderer. The figures below exclude these runs.
  int runs = 0, failed = 0;
  int stopped = 0;                       ///< failed runs that the guard stopped
  VerdictCounts verdicts{};              ///< of the first impact
  std::array<Spread, kMetrics> metrics;  ///< of each of allMetrics(), for the runs that have it
  /// K_zs = 1 / |mean C_zs|, N/m. Empty if unresolved: |mean C_zs| is below two standard errors, fewer than two runs,
  /// or a run is unstable.
  std::optional<double> steadyStiffness;
  Spread forceOverRms;        ///< F_c / rms depth, N/m
  Spread forceOver95;         ///< F_c / 95th percentile of the depth, N/m
  double largestDepth = 0.0;  ///< of all runs, m
  double drift = 0.0;         ///< largest drift, m
  std::uint64_t faults = 0;

  const Spread& of(const MetricMember& member) const noexcept { return metrics[indexOf(member)]; }
};

/// Return whether a run is lost: it left the workspace, the guard stopped it, or it is unstable. Realtime: yes.
bool isLost(const StudyResult& run) noexcept;

/// Return the statistics of the runs of one point. Realtime: no.
PointStatistics statisticsOf(const std::vector<StudyResult>& runs);

/// Return the statistics of all points, scenario by scenario, column by column. `results` must be complete and in the
/// order of their numbers. Realtime: no.
std::vector<PointStatistics> pointStatistics(const StudyPlan& plan, const std::vector<StudyResult>& results);

/// A value and its query point.
struct Extreme {
  double value = 0.0;
  std::size_t point = 0;
};

/// Summary of the wall for one scenario and column. "Lowest" is the lowest of the points' means.
struct WallSummary {
  int scenario = 1;
  std::size_t column = 0;
  std::optional<Extreme> lowestFirst, highestFirst;            ///< K_z1, N/m
  std::optional<Extreme> lowestDepthStiffness;                 ///< K_d, N/m
  Spread depthStiffness;                                       ///< K_d over the points
  std::optional<Extreme> lowestShare;                          ///< K_z1 over the physical limit
  std::optional<Extreme> lowestSteady, highestSteady;          ///< K_zs of the resolved points, N/m
  std::optional<Extreme> lowestCompliance, highestCompliance;  ///< |mean C_zs|, m/N
  Spread steady;                                               ///< K_zs over the resolved points
  int unresolved = 0;                                          ///< points without K_zs
  double lowestOverRms = 0.0, lowestOver95 = 0.0;              ///< F_c / rms depth and F_c / 95th percentile, N/m
  double largestDepth = 0.0, drift = 0.0;                      ///< m
  double chatter = 0.0, saturatedShare = 0.0, tangentialForce = 0.0;  ///< largest of the points' means
  double bounce = 0.0;                                                ///< largest of the points' means, m
  int failed = 0, stopped = 0;                                        ///< lost runs; those stopped by the guard
  VerdictCounts verdicts{};                                           ///< first impacts of the other runs
  std::uint64_t faults = 0;

  /// Return the number of runs with a step of force but without a first impact stiffness. stable() returns whether no
  /// run was lost or unstable.
  int withoutFirst() const noexcept;
  bool stable() const noexcept {
    return failed == 0 && verdicts[static_cast<std::size_t>(FirstImpactVerdict::unstable)] == 0;
  }
};

/// Return summaries, scenario by scenario, column by column. Realtime: no.
std::vector<WallSummary> summarise(const StudyPlan& plan, const std::vector<PointStatistics>& points);

}  // namespace enamel
