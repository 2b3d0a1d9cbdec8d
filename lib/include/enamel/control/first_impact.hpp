// The first impact of a push on a wall: the deepest point of the continuous motion before the tool first returns.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/core/types.hpp"

namespace enamel {

/// Finds the first return of a tool from its gaps along the wall's normal at each tick after the onset of a push.
/// Between two ticks the gap is the cubic with the values and rates at both ends (Hermite). If torques are constant
/// over a tick, the error of the cubic is of fourth order in the period.
class FirstImpact {
 public:
  /// `rest`: the gap before the push, m. Depths count from it.
  explicit FirstImpact(double rest = 0.0) noexcept : rest_(rest) {}

  /// Add the motion from one tick (gap in m, rate in m/s) to the next, `period` s later. Return true in the interval in
  /// which the gap turns from shrinking to growing below its rest for the first time. Realtime: yes.
  bool add(double gap, double rate, double nextGap, double nextRate, double period) noexcept;

  /// Return whether the gap has turned, and the depth below the rest at the turn, m.
  bool returned() const noexcept { return returned_; }
  double depth() const noexcept { return depth_; }

 private:
  double rest_;
  double depth_ = 0.0;
  bool returned_ = false;
};

/// Verdict on a push: it has a first impact stiffness, or the reason why not.
enum class FirstImpactVerdict : std::uint8_t {
  measured,  ///< D_z1 and K_z1 are available
  noStep,    ///< the force does not rise at once
  noReturn,  ///< the tool never turns back
  /// From 0.5 s after the onset, the depth's standard deviation is above D_z1 / 4. The push must last 0.75 s or more.
  rings,
  slips,  ///< until its return the tool moves farther across the normal than along it
  /// The guard stopped the tool, or one of these holds from 0.5 s after the onset of a push of at least 0.75 s:
  /// - the push rings, and the depth's deviation in the last eighth of a second is over ten times that in the first;
  /// - more than half of the ticks are saturated;
  /// - a torque's standard deviation in the last eighth of a second is above a quarter of its motor's limit.
  unstable,
  flies,  ///< before the step the tool was off the wall by more than D_z1 / 10
};

inline constexpr int kVerdicts = 7;

/// Return the name of a verdict in plain words. Realtime: yes.
const char* toString(FirstImpactVerdict verdict) noexcept;

/// One tick of a push. `gap` and `rate` are those before the tick's torque acts.
struct ImpactTick {
  double gap = 0.0;         ///< along the wall's normal, m
  double rate = 0.0;        ///< rate of the gap, m/s
  double force = 0.0;       ///< push of the person into the wall, held until the next tick, N
  double drift = 0.0;       ///< largest displacement across the normal so far, m
  bool saturated = false;   ///< a motor limit reduced the torque
  JointVector torque = {};  ///< acts until the next tick, as fractions of the motors' limits; empty: unknown
};

/// Judges one step of force against a wall, tick by tick. Plain data.
/// - D_z1 is the depth of the first impact below the mean gap before the step (with the tick of the onset).
/// - F_1 is the force above its mean before the step.
/// - K_z1 = F_1(t_z1) / D_z1.
///
/// t_z1 is the time of the deepest turn. Turns count until the tool has come back by a tenth of its depth, or 0.5 s
/// have passed. A halt on the way in is not a return, and neither is a turn less deep than the deepest point at rest.
class ImpactMonitor {
 public:
  /// Recommended time of rest before the step, s.
  static constexpr double kRestWindow = 0.1;
  /// Time after the onset that deepest() covers, s.
  static constexpr double kDepthWindow = 0.1;

  /// `period`: period of the ticks, s.
  explicit ImpactMonitor(double period) noexcept : period_(period) {}

  /// Add a tick of the rest before the step. Realtime: yes.
  void rest(const ImpactTick& tick) noexcept;

  /// Add a tick of the push. The force rises at the first one. Realtime: yes.
  void push(const ImpactTick& tick) noexcept;

  /// Return the verdict on the ticks so far, never noStep. Realtime: yes.
  FirstImpactVerdict verdict() const noexcept;

  /// Return true if the torques alone mean `unstable`; also valid for a push without a step. Realtime: yes.
  bool unstable() const noexcept;

  /// Return D_z1 (m), F_1 (N) and K_z1 (N/m), valid if the verdict is `measured`; the force before the step, N.
  /// Realtime: yes.
  double depth() const noexcept { return depth_; }
  double force() const noexcept { return force_; }
  double stiffness() const noexcept { return force_ / depth_; }
  double preload() const noexcept { return restTicks_ > 0 ? restForce_ / restTicks_ : 0.0; }

  /// Return the deepest point of the continuous motion within kDepthWindow after the onset, from the rest, m. It is
  /// valid for every push, also if the verdict is not `measured`. Realtime: yes.
  double deepest() const noexcept { return deepest_; }

  /// Return the largest gap above the rest at a tick of the push, m; 0 if the tool never rose above it. Realtime: yes.
  double bounce() const noexcept { return bounce_; }

 private:
  // Sums of depth and torques over an eighth of a second.
  struct Block {
    std::uint64_t ticks = 0;
    double sum = 0.0, squares = 0.0;
    std::array<double, kMaxJoints> torque{}, torqueSquares{};

    void add(const ImpactTick& tick) noexcept;
    double deviation() const noexcept;  // of the depth, m
    double chatter() const noexcept;    // largest standard deviation of a torque
  };

  bool ringing() const noexcept;

  double period_;
  double restDepth_ = 0.0, restForce_ = 0.0;  // sums over the ticks
  int restTicks_ = 0;
  double lowestAtRest_ = 1e9;         // gap, m
  double rest_ = 0.0, unrest_ = 0.0;  // gap at rest, and the largest depth below it before the step, m
  ImpactTick last_;
  double depth_ = 0.0, force_ = 0.0;  // at the deepest turn so far; 0: no turn
  double deepest_ = 0.0, bounce_ = 0.0;
  bool slipped_ = false, over_ = false;
  std::uint64_t ticks_ = 0;                   // ticks of the push
  double lateSum_ = 0.0, lateSquares_ = 0.0;  // sums of the depth from 0.5 s after the onset
  Block firstBlock_, lastBlock_, block_;      // same time; block_ is the present one
  std::uint64_t lateTicks_ = 0, lateSaturated_ = 0;
};

}  // namespace enamel
