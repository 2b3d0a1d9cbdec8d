// A push against a wall: the scenarios of "A Position-Control Based Approach to Haptic Rendering of Stiff
// Objects", section V, on the virtual device, tick by tick.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "enamel/collision/scene_file.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"

namespace enamel {

/// The person who pushes against the wall's normal n. Scenario 1: a step of force at 1 s. Scenario 2: a hand with a
/// spring and a damper along n that moves in from 1 s to 2 s (eq. 14). White noise, one sample held a tick, from 1 s
/// (scenario 1) or 2 s (scenario 2).
struct HandModel {
  int scenario = 1;
  double force = 12.0;  ///< F_c, N
  double noise = 0.5;   ///< standard deviation, N
  /// Pressed with this from the beginning until the push, with the noise, so that a wall that never pulls has the tool
  /// at rest on it, N. Scenario 1.
  double preload = 0.0;
  double instant = 0.0;         ///< of scenario 1's step, as a share of the tick in which it comes, in [0, 1)
  std::optional<Arm> arm;       ///< through which scenario 1 pushes; none: the force is on the tool at once
  Vec3 normal = Vec3::UnitZ();  ///< n, outward, unit length, in W
  Vec3 grip = Vec3::Zero();     ///< where the hand holds the tool and pushes it, in the platform's frame, m
  /// Keeps the grip across n (100 N/m, 3.6 N s/m) and the orientation (0.5 N m/rad, 0.014 N m s/rad) about the start
  /// pose, as a hand does; without it the five free directions drift.
  bool guide = true;
};

/// Everything that determines a push.
struct PushSetup : LoopSetup {
  HandModel hand;
  double duration = 3.0;  ///< s
};

/// Makes the tool a point at `tip` (m, in the platform's frame), where the hand holds it as well, and the scene a wall
/// through it across the push. Throws Error: as Scene::add(). Realtime: no.
void setToolTip(const Vec3& tip, PushSetup& setup);

/// Makes a scene file's obstacles, tool, start and force limit, where it is lower, those of a push, which is against
/// the surface nearest to the start. Throws Error: no surface is within reach. Realtime: no.
void setScene(const SceneFile& file, PushSetup& setup);

/// Brings the start to the surface of the scene that is nearest to it, and makes that the one that is pushed. False
/// where there is none. Realtime: yes (100 queries at most).
bool placeOnSurface(PushSetup& setup) noexcept;

/// A random instant inside its tick for the step of a run, uniform in [0, 1). Realtime: yes.
double randomInstant(std::uint64_t seed, std::uint32_t run) noexcept;

/// The ticks at which a push changes.
struct PushTimes {
  std::uint64_t onset;       ///< the person begins to push (1 s)
  std::uint64_t steady;      ///< noise and steady state begin (scenario 1: 1 s; 2: 2 s, the hand stands still)
  std::uint64_t lastSecond;  ///< the last second begins
  std::uint64_t end;
};
PushTimes timesOf(const PushSetup& setup) noexcept;

/// The person of a push, tick by tick: a load for VirtualLoop::tick(). Plain data.
class SimulatedHand {
 public:
  /// Begins at the setup's start.
  explicit SimulatedHand(const PushSetup& setup) noexcept;

  /// Takes what is held over a tick, from 0 on: force and noise. Where the step of scenario 1 comes inside it, that
  /// before the step, or `stepped`, after it. Realtime: yes.
  void hold(std::uint64_t tick, bool stepped = false) noexcept;
  bool stepsInside(std::uint64_t tick) const noexcept;

  /// Moves the arm, if any, on by a tick that began so. Realtime: yes.
  void moveArm(const Pose& pose, const Vec6& twist) noexcept;

  /// Wrench on the platform at the TCP, N, N m. Realtime: yes.
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

/// Why a run ended.
struct PushResult {
  Status status;                          ///< ok; stopped by the guard; or the status of what the plant could not leave
  std::uint64_t ticks;                    ///< that were run
  GuardReason guard = GuardReason::none;  ///< the fault that stopped it
};

/// Checks a setup. Throws Error: as checkLoop(); a preload outside 0 to 1000 N; an instant outside [0, 1); a scenario
/// other than 1 and 2; an arm in scenario 2, or one whose mass is not positive or whose other numbers are negative; a
/// normal not of unit length to 1e-6; a grip farther than 1 m from the TCP; a force or noise outside 0 to 1000 N; a
/// duration outside 0 to 1 h. Realtime: no.
void checkPush(const PushSetup& setup);

/// Runs a push on a VirtualLoop, `record` once a tick, until its end or until the guard latches a fault. The renderer
/// is deactivated at the end. Throws what checkPush() and VirtualLoop throw. The same setup gives the same bits.
/// Realtime: no (each tick is).
PushResult runPush(const Mechanism& mechanism, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&)>& record);

/// The same on another plant than the closed form, `record` with the loop that it runs on; `model` is what the haptic
/// tick takes the plant for.
PushResult runPush(std::unique_ptr<Plant> plant, const Mechanism& model, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&, const VirtualLoop&)>& record);

/// Position of the hand in scenario 2 along n relative to its start, m, and its velocity, m/s. Realtime: yes.
struct HandMotion {
  double position, velocity;
};
HandMotion handMotion(double force, double time) noexcept;

}  // namespace enamel
