// Metrics of a run ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section V.B, and more).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "enamel/control/first_impact.hpp"
#include "enamel/sim/push.hpp"

namespace enamel {

/// Metrics of one push. Depths are positive into the wall. The steady state lasts from 1 s (scenario 1) or 2 s
/// (scenario 2) to the end.
struct PushMetrics {
  /// Result of the first impact. The first impact is the deepest point of the continuous motion before its first
  /// return. It is measured from the mean depth in the 0.1 s before the step (ImpactMonitor). Scenario 2 has no first
  /// impact and may be `unstable`.
  FirstImpactVerdict verdict = FirstImpactVerdict::noReturn;
  std::optional<double> firstDepth;      ///< D_z1, m
  std::optional<double> firstStiffness;  ///< K_z1 = F_1(t_z1) / D_z1, N/m
  std::optional<double> limitShare;      ///< K_z1 over largestStiffness(), if known
  /// K_d, N/m: the push's force over the largest depth within 0.1 s after the step (ImpactMonitor::deepest()). Each run
  /// of scenario 1 has it, even if the tool slips or rings.
  std::optional<double> depthStiffness;
  double steadyDepth = 0.0;       ///< D_zs, signed mean, m
  double steadyCompliance = 0.0;  ///< C_zs = D_zs / F_c, m/N
  double rmsDepth = 0.0;          ///< of the steady state, m
  double depth95 = 0.0;           ///< 95th percentile of |depth| of the steady state, m
  double largestDepth = 0.0;      ///< of the whole run, m
  /// Standard deviation of the torque in the last second, largest of the joints, N m or N.
  double chatter = 0.0;
  double saturatedShare = 0.0;   ///< share of all ticks
  double tangentialForce = 0.0;  ///< rms rendered force across the normal in the steady state, N
  double work = 0.0;             ///< of the rendered wrench on the tool, J
  double drift = 0.0;            ///< largest displacement across the normal from the start, m
  double bounce = 0.0;           ///< largest gap above the rest after the onset of the push, m
  std::uint64_t faults = 0;      ///< number of ticks without status ok of the renderer
};

/// Name and unit of a metric in tables, files and pictures. In files: "symbol [unit]".
struct Metric {
  const char* symbol;   ///< of the field, or its name
  const char* meaning;  ///< "" if the symbol is enough
  const char* unit;     ///< SI; "" for a share
  const char* displayUnit;
  double displayScale;  ///< factor from unit to displayUnit
  std::variant<double PushMetrics::*, std::optional<double> PushMetrics::*> member;
};
using MetricMember = decltype(Metric::member);
inline constexpr std::size_t kMetrics = 15;

/// List all metrics, in the order of files and tables.
const std::array<Metric, kMetrics>& allMetrics() noexcept;

/// Return the index of a metric in allMetrics(). Realtime: yes.
std::size_t indexOf(const MetricMember& member) noexcept;

/// Return "symbol [unit]". Realtime: no.
std::string keyOf(const Metric& metric);

/// Return the value of a metric; empty if the run does not have it. Realtime: yes.
std::optional<double> valueOf(const PushMetrics& metrics, const Metric& metric) noexcept;

/// Return the largest possible first impact stiffness of a push on a plant, N/m. This is firstImpactLimit() at its
/// start along its normal, with its preload and largest delay. It assumes a step at the beginning of a tick; a later
/// step can be answered sooner. The result is 0 if the push has no step, the motors cannot hold it, or the start is out
/// of reach. Realtime: no.
double largestStiffness(const Mechanism& plant, const PushSetup& setup);

/// Return the chatter: the standard deviation of the torque, largest of the joints, N m or N. It is 0 without torques.
/// Realtime: no.
double chatterOf(const std::vector<JointVector>& torques);

/// Collect the ticks of one run; pass add() to runPush(). Realtime: no.
class MetricsCollector {
 public:
  /// `limit` is largestStiffness() of the push; 0: unknown. `maxTorque` has the motors' limits, N m or N. If it is
  /// empty, oscillation of the torque is not judged.
  explicit MetricsCollector(const PushSetup& setup, double limit = 0.0, JointVector maxTorque = {});
  void add(const TickRecord& tick);
  PushMetrics metrics() const;

 private:
  PushSetup setup_;
  double limit_;  // N/m
  JointVector maxTorque_;
  bool stopped_ = false;
  PushTimes times_;
  std::vector<double> depths_;        // of the steady state
  std::vector<JointVector> torques_;  // of the last second
  PushMetrics running_;
  ImpactMonitor impact_;
  double tangentialSquares_ = 0.0;
  std::uint64_t ticks_ = 0, saturated_ = 0;
};

}  // namespace enamel
