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

/// Metrics of one push. Depths count positive into the wall; the steady state is 1 s to the end in scenario 1 and 2 s
/// to the end in scenario 2.
struct PushMetrics {
  /// First impact: the deepest point of the continuous motion up to its first return, from the mean depth in the 0.1 s
  /// before the step (ImpactMonitor); scenario 2 has none, and may be `unstable`.
  FirstImpactVerdict verdict = FirstImpactVerdict::noReturn;
  std::optional<double> firstDepth;      ///< D_z1, m
  std::optional<double> firstStiffness;  ///< K_z1 = F_1(t_z1) / D_z1, N/m
  std::optional<double> limitShare;      ///< K_z1 over largestStiffness(), where that was given
  /// K_d, N/m: the push's force over the deepest point within 0.1 s after the step (ImpactMonitor::deepest()). Every
  /// run of scenario 1 has one, also where the tool slips or rings.
  std::optional<double> depthStiffness;
  double steadyDepth = 0.0;       ///< D_zs, signed mean, m
  double steadyCompliance = 0.0;  ///< C_zs = D_zs / F_c, m/N
  double rmsDepth = 0.0;          ///< of the steady state, m
  double depth95 = 0.0;           ///< 95th percentile of |depth| of the steady state, m
  double largestDepth = 0.0;      ///< of the whole run, m
  double chatter = 0.0;           ///< largest over the joints of the torque's standard deviation, last second, N m or N
  double saturatedShare = 0.0;    ///< of all ticks
  double tangentialForce = 0.0;   ///< rms of the rendered force across the normal in the steady state, N
  double work = 0.0;              ///< of the rendered wrench on the tool, J
  double drift = 0.0;             ///< largest displacement across the normal from the start, m
  double bounce = 0.0;            ///< largest gap above the rest from the onset of the push on, m
  std::uint64_t faults = 0;       ///< ticks on which the renderer answered anything but ok
};

/// A metric as tables, files and pictures name it. In files: "symbol [unit]".
struct Metric {
  const char* symbol;   ///< of the field, or its name
  const char* meaning;  ///< "" where the symbol says it
  const char* unit;     ///< SI; "" for a share
  const char* displayUnit;
  double displayScale;  ///< from unit to displayUnit
  std::variant<double PushMetrics::*, std::optional<double> PushMetrics::*> member;
};
using MetricMember = decltype(Metric::member);
inline constexpr std::size_t kMetrics = 15;

/// All of them, in the order of files and tables.
const std::array<Metric, kMetrics>& allMetrics() noexcept;

/// Place of a metric in allMetrics(). Realtime: yes.
std::size_t indexOf(const MetricMember& member) noexcept;

/// "symbol [unit]". Realtime: no.
std::string keyOf(const Metric& metric);

/// Its value; nothing where a run does not have it. Realtime: yes.
std::optional<double> valueOf(const PushMetrics& metrics, const Metric& metric) noexcept;

/// Largest first impact stiffness that a push on a plant can have, N/m: firstImpactLimit() at its start along its
/// normal, with its preload and its largest delay, for a step at the beginning of a tick (one inside a tick can be
/// answered sooner). 0: a push without a step, one that the motors cannot hold, or a start out of reach. Realtime: no.
double largestStiffness(const Mechanism& plant, const PushSetup& setup);

/// Chatter: the largest over the joints of the torque's standard deviation, N m or N; 0 for none. Realtime: no.
double chatterOf(const std::vector<JointVector>& torques);

/// Collects the ticks of one run: give add() to runPush(). Realtime: no.
class MetricsCollector {
 public:
  /// `limit`: largestStiffness() of the push; 0: not known. `maxTorque`: the motors' limits, N m or N; empty: how far
  /// the torque oscillates is then not judged.
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
