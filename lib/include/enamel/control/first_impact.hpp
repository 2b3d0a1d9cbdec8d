// The first impact of a push on a wall: the deepest point of the continuous motion up to its first return.
#pragma once

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

}  // namespace enamel
