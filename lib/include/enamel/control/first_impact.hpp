// The first impact of a push on a wall: the deepest point of the continuous motion up to its first return.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/core/types.hpp"

namespace enamel {

/// Watches the gap along the wall's normal from one tick to the next, from the onset of a push on. Between ticks the
/// gap is the cubic that its values and rates at both ends determine (Hermite): under torques that are held over a tick
/// its error is of fourth order in the period.
class FirstImpact {
 public:
  /// `rest`: the gap before the push, from which depths count, m.
  explicit FirstImpact(double rest = 0.0) noexcept : rest_(rest) {}

  /// The motion from one tick (gap in m, rate in m/s) to the next, `period` s later. True in the interval in which the
  /// gap, below its rest, turns from shrinking to growing for the first time. Realtime: yes.
  bool add(double gap, double rate, double nextGap, double nextRate, double period) noexcept;

  /// Whether it has turned, and how deep it then was below the rest, m.
  bool returned() const noexcept { return returned_; }
  double depth() const noexcept { return depth_; }

 private:
  double rest_;
  double depth_ = 0.0;
  bool returned_ = false;
};

/// Whether a push has a first impact stiffness, or why not.
enum class FirstImpactVerdict : std::uint8_t {
  measured,  ///< D_z1 and K_z1 are there
  noStep,    ///< the force does not rise at once
  noReturn,  ///< the tool never turned back
  rings,     ///< from 0.5 s after the onset on, the depth's standard deviation is above D_z1 / 4 (judged where the push
             ///< goes on for 0.75 s or more)
  slips,     ///< until its return the tool moved farther across the normal than along it
  unstable,  ///< it rings and grows tenfold, or more than half of those ticks are saturated, or a torque's standard
             ///< deviation in an eighth of a second is above a quarter of its motor's limit, or the guard stopped it
  flies,     ///< before the step the tool was off the wall by more than D_z1 / 10: the push began with a flight
};

inline constexpr int kVerdicts = 7;

/// Name of a verdict in plain words. Realtime: yes.
const char* toString(FirstImpactVerdict verdict) noexcept;

/// What a push looks like at a tick; gap and rate are those before the tick's torque acts.
struct ImpactTick {
  double gap = 0.0;         ///< along the wall's normal, m
  double rate = 0.0;        ///< of the gap, m/s
  double force = 0.0;       ///< of the person into the wall, held until the next tick, N
  double drift = 0.0;       ///< largest displacement across the normal so far, m
  bool saturated = false;   ///< a motor's limit cut the torque
  JointVector torque = {};  ///< that acts until the next tick, shares of the motors' limits; empty: not known
};

/// Judges one step of force against a wall, tick by tick: D_z1 counts from the mean gap at rest before the step (the
/// tick of the onset included), F_1 from the mean force then, K_z1 = F_1(t_z1) / D_z1. A tool that halts on its way in
/// has not returned, nor has one that turns less deep than it was at rest: t_z1 is the deepest turn before it has come
/// back by a tenth of its depth, or 0.5 s have passed. Plain data.
class ImpactMonitor {
 public:
  /// How long the rest should be watched before the step, s.
  static constexpr double kRestWindow = 0.1;
  /// How long after the step deepest() looks, s.
  static constexpr double kDepthWindow = 0.1;

  /// `period` of the ticks, s.
  explicit ImpactMonitor(double period) noexcept : period_(period) {}

  /// A tick of the rest before the step. Realtime: yes.
  void rest(const ImpactTick& tick) noexcept;

  /// A tick of the push; at the first one the force rises. Realtime: yes.
  void push(const ImpactTick& tick) noexcept;

  /// On the ticks so far: never noStep. Realtime: yes.
  FirstImpactVerdict verdict() const noexcept;

  /// Whether the torques alone say `unstable`; also for a push without a step. Realtime: yes.
  bool unstable() const noexcept;

  /// D_z1 (m), F_1 (N) and K_z1 (N/m) where the verdict is `measured`; force before the step, N. Realtime: yes.
  double depth() const noexcept { return depth_; }
  double force() const noexcept { return force_; }
  double stiffness() const noexcept { return force_ / depth_; }
  double preload() const noexcept { return restTicks_ > 0 ? restForce_ / restTicks_ : 0.0; }

  /// The deepest point of the continuous motion within kDepthWindow after the onset, from the rest, m. Every push has
  /// one, also where the verdict is not `measured`. Realtime: yes.
  double deepest() const noexcept { return deepest_; }

  /// Largest gap above the rest at a tick of the push, m; 0 where the tool never rose above it. Realtime: yes.
  double bounce() const noexcept { return bounce_; }

 private:
  // An eighth of a second: depth and torques.
  struct Block {
    std::uint64_t ticks = 0;
    double sum = 0.0, squares = 0.0;
    std::array<double, kMaxJoints> torque{}, torqueSquares{};

    void add(const ImpactTick& tick) noexcept;
    double deviation() const noexcept;  // of the depth, m
    double chatter() const noexcept;    // largest of a torque's deviations
  };

  bool ringing() const noexcept;

  double period_;
  double restDepth_ = 0.0, restForce_ = 0.0;  // sums
  int restTicks_ = 0;
  double lowestAtRest_ = 1e9;         // gap, m
  double rest_ = 0.0, unrest_ = 0.0;  // gap at rest and how far below it the rest went, m
  ImpactTick last_;
  double depth_ = 0.0, force_ = 0.0;  // at the deepest turn so far; 0: none
  double deepest_ = 0.0, bounce_ = 0.0;
  bool slipped_ = false, over_ = false;
  std::uint64_t ticks_ = 0;                   // of the push
  double lateSum_ = 0.0, lateSquares_ = 0.0;  // of the depth, from 0.5 s after the onset on
  Block firstBlock_, lastBlock_, block_;      // of the same time; the one under way
  std::uint64_t lateTicks_ = 0, lateSaturated_ = 0;
};

}  // namespace enamel
