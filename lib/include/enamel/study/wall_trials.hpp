// What people do to a wall besides one push: slow presses, impacts, letting go, sliding, more than the motors can hold.
// Trials on the virtual device, for any renderer.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enamel/render/renderer.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// What the trials run on: the wall z = 0 at the home pose, joint angles rounded to encoder counts, rates differenced
/// over a tick, no guard (controllers run to the end). A hand keeps the TCP softly across the push (guidingWrench())
/// and trembles by white noise along it.
struct WallTrialSetup {
  std::shared_ptr<const Mechanism> plant;
  std::shared_ptr<const Mechanism> model;               ///< what the renderer takes the plant for
  std::function<std::unique_ptr<Renderer>()> renderer;  ///< a new one; may be called from several threads at once
  /// Makes the plant of a run where it is not the closed form of `plant`; likewise.
  std::function<std::unique_ptr<Plant>(std::uint32_t stream)> makePlant = {};
  Delay delay;           ///< ticks
  double period = 1e-3;  ///< s
  double noise = 0.5;    ///< standard deviation of the person's force, N
  int runs = 20;         ///< with other noise, forces and instants
  std::uint64_t seed = 1;
};

/// One figure of a trial: the worst of its runs, or their mean where it says so.
struct WallFigure {
  std::string trial, figure;
  const char* unit;    ///< for people; "" for a share
  double value = 0.0;  ///< in that unit; NaN where no run has it
  int lost = 0;        ///< runs of the trial that ended: 40 mm inside, out of the workspace, or with a status
};

/// Forces for this plant as a share of those that the trials name, which are for the TAU: at most 1, and so that 15 N
/// become 0.3 of what the motors can give along the wall's normal at home. Throws Error: home cannot be reached.
/// Realtime: no.
double forceShare(const Mechanism& plant);

/// The trials by their names, in the order of their results. Realtime: no.
std::vector<std::string> wallTrialNames();

/// Runs all trials whose name contains `filter`:
/// - step: 8 to 15 N after 1 N at a random instant inside a tick. Lowest share of the physical limit
///   (firstImpactLimit()), farthest above the rest after it, chatter (chatterOf(), the last quarter of a second).
/// - ramp: 1 N, then 10 N more in 50 ms. Deepest below the rest.
/// - impact: thrown at 0.05, 0.2 and 0.5 m/s, then held with 1 N. Depth over v t1 + m v^2 / (2 (F_max - 1 N)), t1 the
///   delay and a tick; farthest out after the touch; how far outside v T + 20 um it was pushed before it.
/// - release: 12 N turn to a pull of 1 N at a random instant inside a tick. Speed 1 mm out over that of a wall that
///   lets go t1 after a step at a sample, worst and mean; strongest pull of the wall.
/// - slide: over walls tilted in ten directions at 0.1 m/s under 10 N without friction. Tangential over normal force
///   (means), rms depth.
/// - corner: two walls at a right angle, pressed into with 10 N. Deepest once at rest, chatter.
/// - pulse: 1.5 times what the motors can hold, for 10 ms. Torque over its limit, angle of the commanded force to the
///   normal.
/// - overload: 45 N, falling to 10 N over 20 ms after 1 s. Farthest above the wall.
/// Results do not depend on `threads`. Throws Error: no plant, model or renderer; runs outside 1 to 10 000; as
/// VirtualLoop and forceShare(). Realtime: no.
std::vector<WallFigure> runWallTrials(const WallTrialSetup& setup, const std::string& filter, int threads);

}  // namespace enamel
