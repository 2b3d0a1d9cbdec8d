// What happens to the tool: the forces of the motors, and what goes wrong.
#pragma once

#include <array>

#include "enamel/sim/virtual_loop.hpp"

namespace enamel::viewer {

/// Force of the motors on the tool beyond gravity, as delivered during a tick, N: along the nearest contact's normal
/// (negative: into the wall), across it, and in all. Realtime: yes.
struct Delivered {
  double normal, tangential, total;
};
Delivered deliveredOf(const TickRecord& record) noexcept;

/// What happens to the tool, each for kShown ticks longer than it does.
struct Conditions {
  bool saturated = false;  ///< a motor is at its limit
  bool unstable = false;   ///< torques alternate by more than a quarter of their limits for two eighths of a second, or
                           ///< the guard says so
  bool slipped = false;    ///< it slid for kSlipPath, faster than kSlip, on a wall with friction
  bool edge = false;       ///< of the workspace: at a mechanical stop

  static constexpr int kShown = 400;
  static constexpr double kSlip = 2e-3, kSlipPath = 2e-4;  // m/s, m
};

/// Judges them tick by tick. Realtime: all.
class ConditionWatch {
 public:
  /// Of one tick, at a device with these limits of the torques.
  const Conditions& add(const TickRecord& record, const JointVector& maxTorque) noexcept;
  /// Forgets the blocks of ticks so far.
  void beginBlock() noexcept { block_ = complete_ = Block(); }
  /// From the smallest to the largest normal force of the last complete block, else of the one that is filling, N.
  double forceRange() const noexcept;

 private:
  // Extremes of the force over kBlock ticks; shares of the torques' limits, summed over as many.
  struct Block {
    int ticks = 0;
    double lowForce = 0.0, highForce = 0.0;
    JointVector sum, squares;
  };
  static constexpr int kBlock = 125;

  bool chatters(const TickRecord& record, const JointVector& shares) noexcept;
  bool slips(const TickRecord& record) noexcept;

  Block block_, complete_;
  bool chattered_ = false;         // in the block before
  double slid_ = 0.0;              // m, without a rest
  std::array<int, 4> shownFor_{};  // ticks, of the conditions
  Conditions conditions_;
};

}  // namespace enamel::viewer
