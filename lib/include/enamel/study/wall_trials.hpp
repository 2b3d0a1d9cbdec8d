// Trials of a wall besides a single push: slow presses, impacts, release, sliding, overload. They run on the virtual
// device with any renderer.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enamel/render/renderer.hpp"
#include "enamel/sim/virtual_loop.hpp"

namespace enamel {

/// Setup of the trials: the wall z = 0 at the home pose. Joint angles are rounded to encoder counts, and rates are
/// their differences over a tick. The guard is off, so controllers run to the end. A hand keeps the TCP softly across
/// the push (guidingWrench()) and trembles by white noise along it.
struct WallTrialSetup {
  std::shared_ptr<const Mechanism> plant;
  std::shared_ptr<const Mechanism> model;  ///< mechanism that the renderer assumes
  /// Make a renderer. Several threads may call it at the same time.
  std::function<std::unique_ptr<Renderer>()> renderer;
  /// Make the plant of a run, if it is not the closed form of `plant`. Several threads may call it at the same time.
  std::function<std::unique_ptr<Plant>(std::uint32_t stream)> makePlant = {};
  DeviceWrapper wrapper = {};  ///< as in LoopSetup
  Delay delay;                 ///< ticks
  double period = 1e-3;        ///< s
  double noise = 0.5;          ///< standard deviation of the person's force, N
  Tap tap = tapOf("enamel");   ///< of the material to which the taps are compared
  int runs = 20;               ///< runs differ in noise, forces and instants
  std::uint64_t seed = 1;
};

/// One figure of a trial: the worst of its runs or, if stated, their mean.
struct WallFigure {
  std::string trial, figure;
  const char* unit;    ///< for display; "" for a share
  double value = 0.0;  ///< in that unit; NaN if no run has it
  /// Runs that ended early: 40 mm inside, out of the workspace, or with an error status.
  int lost = 0;
};

/// Return the factor of the trials' forces for this plant, at most 1. The trials name forces for the TAU. With this
/// factor 15 N become 0.3 of the motors' force along the wall's normal at home. Throws Error if home is out of reach.
/// Realtime: no.
double forceShare(const Mechanism& plant);

/// List the trials by their names, in the order of their results. Realtime: no.
std::vector<std::string> wallTrialNames();

/// Run all trials whose name contains `filter`. t1 is the delay plus one tick.
/// - step: 8 to 15 N after 1 N at a random time within a tick. Figures: lowest share of the physical limit
///   (firstImpactLimit()); largest distance above the rest; chatter (chatterOf(), last quarter of a second).
/// - ramp: 1 N, then 10 N more in 50 ms. Figure: largest depth below the rest.
/// - impact: thrown at 0.05, 0.2 and 0.5 m/s, then held with 1 N. Figures: depth over v t1 + m v^2 / (2 (F_max - 1 N));
///   largest distance outside after the touch. Also the distance outside v T + 20 um to which the tool was pushed
///   before the touch. Also the extended rate-hardness: the largest rate of the motors' force until 30 ms after the
///   touch, over the speed before it, lowest run (Han and Choi, "Extended rate-hardness", 2010). For a spring it is its
///   stiffness.
/// - tap plain: moved to the wall at 0.1 to 0.5 m/s until it touches, then held with 1 N. Figures: means of TapMetrics.
/// - tap transient: the same at a wall that has the tap of the material.
/// - release: 12 N change to a pull of 1 N at a random time within a tick. Figures: strongest pull of the wall; speed 1
///   mm outside, worst and mean. The speed is relative to a wall that releases t1 after a step at a sample.
/// - slide: over walls tilted in ten directions, at 0.1 m/s under 10 N without friction. Figures: tangential over
///   normal force (means); rms depth.
/// - corner: two walls at a right angle, pressed into with 10 N. Figures: largest depth at rest; chatter.
/// - pulse: 1.5 times the force that the motors can hold, for 10 ms. Figures: torque over its limit; angle of the
///   commanded force to the normal.
/// - overload: 45 N, falling to 10 N within 20 ms after 1 s. Figure: largest distance above the wall.
///
/// Results do not depend on `threads`. Throws Error as VirtualLoop and forceShare(), and if plant, model or renderer is
/// null or runs are outside 1 to 10 000. Realtime: no.
std::vector<WallFigure> runWallTrials(const WallTrialSetup& setup, const std::string& filter, int threads);

}  // namespace enamel
