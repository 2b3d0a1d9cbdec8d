// A push against a wall on the virtual device, tick by tick: the scenarios of "A Position-Control Based Approach to
// Haptic Rendering of Stiff Objects", section V.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "enamel/collision/scene_file.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"

namespace enamel {

/// A person who pushes against the wall's normal n.
///
/// - Scenario 1: a step of force at 1 s.
/// - Scenario 2: a hand with a spring and a damper along n that moves in from 1 s to 2 s (eq. 14).
///
/// White noise begins at 1 s (scenario 1) or 2 s (scenario 2). Each sample lasts one tick.
struct HandModel {
  int scenario = 1;
  double force = 12.0;  ///< F_c, N
  double noise = 0.5;   ///< standard deviation, N
  /// Force before the push, N, with the noise. It holds the tool at rest on a wall that never pulls. Scenario 1 only.
  double preload = 0.0;
  double instant = 0.0;  ///< time of scenario 1's step within its tick, as a share of the tick, in [0, 1)
  /// Arm through which scenario 1 pushes. Empty: the force acts on the tool at once.
  std::optional<Arm> arm;
  std::optional<FingerRest> rest;  ///< empty: no finger rests on a tooth
  Vec3 normal = Vec3::UnitZ();     ///< n, outward, unit length, in W
  Vec3 grip = Vec3::Zero();        ///< point where the hand holds and pushes the tool, in P, m
  /// Guide the tool as a hand does. Hold the grip across n (100 N/m, 3.6 N s/m), and the orientation at the start pose
  /// (0.5 N m/rad, 0.014 N m s/rad). Without it the five free directions drift.
  bool guide = true;
};

/// All data of a push.
struct PushSetup : LoopSetup {
  HandModel hand;
  double duration = 3.0;  ///< s
};

/// Make the tool a point at `tip` (m, in P), which the hand also holds. Make the scene a wall through that point,
/// across the push. Throws Error as Scene::add(). Realtime: no.
void setToolTip(const Vec3& tip, PushSetup& setup);

/// Use obstacles, tool and start of a scene file, and its force limit if it is lower. Push against the surface nearest
/// to the start. Throws Error if no surface is within reach. Realtime: no.
void setScene(const SceneFile& file, PushSetup& setup);

/// Move the start to the nearest surface of the scene, and push against that surface. Returns false if the scene has no
/// surface near the start. Realtime: yes (100 queries at most).
bool placeOnSurface(PushSetup& setup) noexcept;

/// Return a random time within a tick for the step of a run, as a share of the tick, uniform in [0, 1). Realtime: yes.
double randomInstant(std::uint64_t seed, std::uint32_t run) noexcept;

/// Ticks at which the phases of a push begin.
struct PushTimes {
  std::uint64_t onset;  ///< the person begins to push (1 s)
  /// Noise and steady state begin: at 1 s in scenario 1; at 2 s, when the hand stops, in scenario 2.
  std::uint64_t steady;
  std::uint64_t lastSecond;  ///< the last second begins
  std::uint64_t end;
};
PushTimes timesOf(const PushSetup& setup) noexcept;

/// The person of a push, tick by tick: a load for VirtualLoop::tick(). Plain data.
class SimulatedHand {
 public:
  /// Begin at the setup's start.
  explicit SimulatedHand(const PushSetup& setup) noexcept;

  /// Set the force and noise held during a tick, counted from 0. If the step of scenario 1 occurs within this tick, set
  /// the force before the step or, with `stepped`, the force after it. Realtime: yes.
  void hold(std::uint64_t tick, bool stepped = false) noexcept;
  bool stepsInside(std::uint64_t tick) const noexcept;

  /// Move the arm, if any, on by one tick. `pose` and `twist` are those at its beginning. Realtime: yes.
  void moveArm(const Pose& pose, const Vec6& twist) noexcept;

  /// Return the wrench on the platform at the TCP, N, N m. Realtime: yes.
  Vec6 operator()(double time, const Pose& pose, const Vec6& twist) const noexcept;

 private:
  Pose gripOf(const Pose& pose) const noexcept;
  Vec6 gripOf(const Pose& pose, const Vec6& twist) const noexcept;
  double force(double time, const Pose& pose, const Vec6& twist) const noexcept;  // against the normal, at the grip
  double way(const Pose& pose) const noexcept;
  double speed(const Vec6& twist) const noexcept;

  HandModel hand_;
  Pose start_;  // of the grip
  PushTimes times_;
  RandomStream random_;
  double period_;      // s
  double held_ = 0.0;  // N
  std::optional<MovingArm> arm_;
};

/// Result of a run.
struct PushResult {
  Status status;                          ///< ok; stopped by the guard; or the plant's status
  std::uint64_t ticks;                    ///< number of completed ticks
  GuardReason guard = GuardReason::none;  ///< the fault that stopped it
};

/// Check a setup. Throws Error as checkLoop(), and in these cases:
///
/// - the scenario is not 1 or 2;
/// - a force or noise is outside 0 to 1000 N, or a preload is outside 0 to 1000 N;
/// - the instant is outside [0, 1), or the duration outside 0 to 1 h;
/// - the normal does not have unit length within 1e-6;
/// - the grip is farther than 1 m from the TCP;
/// - the point of a finger rest is farther than 1 m from the TCP, or a number of it is negative;
/// - an arm is given in scenario 2, its mass is not positive, or another number of it is negative.
///
/// Realtime: no.
void checkPush(const PushSetup& setup);

/// Run a push on a VirtualLoop until its end, or until the guard latches a fault. Call `record` once per tick.
/// Deactivate the renderer at the end. The same setup gives the same bits. Throws Error as checkPush() and VirtualLoop.
/// Realtime: no (each tick is).
PushResult runPush(const Mechanism& mechanism, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&)>& record);

/// Do the same on another plant. `record` also receives the loop. `model` is the mechanism that the haptic tick
/// assumes.
PushResult runPush(std::unique_ptr<Plant> plant, const Mechanism& model, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&, const VirtualLoop&)>& record);

/// Return position (m, relative to the start) and velocity (m/s) of the hand of scenario 2 along n. Realtime: yes.
struct HandMotion {
  double position, velocity;
};
HandMotion handMotion(double force, double time) noexcept;

}  // namespace enamel
