// State of the tool: forces of the motors, and problems.
#pragma once

#include <array>

#include "enamel/sim/virtual_loop.hpp"

namespace enamel::viewer {

/// Force of the motors on the tool in addition to gravity, as delivered during a tick, N. Components: along the nearest
/// contact's normal (negative: into the wall), tangential, and total. Realtime: yes.
struct Delivered {
  double normal, tangential, total;
};
Delivered deliveredOf(const Vec3& force, const Contact& nearest) noexcept;
inline Delivered deliveredOf(const TickRecord& record) noexcept {
  return deliveredOf(record.rendered.head<3>(), record.nearest);
}

/// Values of the read-outs.
struct Readout {
  double depth = 0.0;         ///< of the tool in the nearest wall, m; negative: its distance
  Vec3 force = Vec3::Zero();  ///< of the motors on the tool in addition to gravity, N
  double hand = 0.0;          ///< force of the hand into the wall, N
};
Readout readoutOf(const TickRecord& record) noexcept;

/// Smooths read-outs for the eye: a low-pass filter of first order. A stop by the guard shows at once. Realtime: all.
class ReadoutFilter {
 public:
  static constexpr double kSmoothing = 0.1;  ///< time constant, s
  const Readout& add(const TickRecord& record) noexcept;

 private:
  Readout smooth_;
  double time_ = 0.0;  // s, of the last tick
};

/// State of the tool. Each condition remains set for kShown ticks after its end.
struct Conditions {
  bool saturated = false;  ///< a motor is at its limit
  bool unstable = false;   ///< torques alternate by more than a quarter of their limits in two blocks (0.25 s), or the
                           ///< guard reports it
  bool slipped = false;    ///< it slid by kSlipPath, faster than kSlip, on a wall with friction
  bool edge = false;       ///< at the edge of the workspace: a mechanical stop

  static constexpr int kShown = 400;
  static constexpr double kSlip = 2e-3, kSlipPath = 2e-4;  // m/s, m
};

/// Determines the conditions tick by tick. Realtime: all.
class ConditionWatch {
 public:
  /// Add one tick of a device with these torque limits.
  const Conditions& add(const TickRecord& record, const JointVector& maxTorque) noexcept;
  /// Discard all blocks of ticks so far.
  void beginBlock() noexcept { block_ = complete_ = Block(); }
  /// Return the range of the normal force in the last complete block, or else in the current one, N.
  double forceRange() const noexcept;

 private:
  // Extremes of the force over kBlock ticks; sums of the torques relative to their limits.
  struct Block {
    int ticks = 0;
    double lowForce = 0.0, highForce = 0.0;
    JointVector sum, squares;
  };
  static constexpr int kBlock = 125;

  bool chatters(const TickRecord& record, const JointVector& shares) noexcept;
  bool slips(const TickRecord& record) noexcept;

  Block block_, complete_;
  bool chattered_ = false;         // in the previous block
  double slid_ = 0.0;              // m, without a rest
  std::array<int, 4> shownFor_{};  // remaining ticks of each condition
  Conditions conditions_;
};

}  // namespace enamel::viewer
