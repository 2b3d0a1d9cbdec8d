// Metrics of a run ("A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section V.B, and more).
#pragma once

#include <optional>
#include <vector>

#include "enamel/sim/push.hpp"

namespace enamel {

/// Metrics of one push. Depths count positive into the wall; the steady state is 1 s to the end in scenario 1 and 2 s
/// to the end in scenario 2.
struct PushMetrics {
  /// First impact: depth at the first tick after the onset where the tool is inside and its velocity along the normal
  /// turns from negative to >= 0; nothing without such a tick, and in scenario 2.
  std::optional<double> firstDepth;      ///< D_z1, m
  std::optional<double> firstStiffness;  ///< K_z1 = F_1(t_z1) / D_z1, N/m
  double steadyDepth = 0.0;              ///< D_zs, signed mean, m
  double steadyCompliance = 0.0;         ///< C_zs = D_zs / F_c, m/N
  double rmsDepth = 0.0;                 ///< of the steady state, m
  double depth95 = 0.0;                  ///< 95th percentile of |depth| of the steady state, m
  double largestDepth = 0.0;             ///< of the whole run, m
  double chatter = 0.0;          ///< largest over the joints of the torque's standard deviation, last second, N m
  double saturatedShare = 0.0;   ///< of all ticks
  double tangentialForce = 0.0;  ///< rms of the rendered force across the normal in the steady state, N
  double work = 0.0;             ///< of the rendered wrench on the tool, J
  double drift = 0.0;            ///< largest displacement across the normal from the start, m
  std::uint64_t faults = 0;      ///< ticks on which the renderer answered anything but ok
};

/// Collects the ticks of one run: give add() to runPush(). Realtime: no.
class MetricsCollector {
 public:
  explicit MetricsCollector(const PushSetup& setup);
  void add(const TickRecord& tick);
  PushMetrics metrics() const;

 private:
  PushSetup setup_;
  std::uint64_t onset_, steady_, lastSecond_;
  std::vector<double> depths_;  // of the steady state
  std::vector<Vec6> torques_;   // of the last second
  PushMetrics running_;
  double lastVelocity_ = 0.0, tangentialSquares_ = 0.0;
  std::uint64_t ticks_ = 0, saturated_ = 0;
};

}  // namespace enamel
