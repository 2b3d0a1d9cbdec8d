// The delays that the commands of a device may have, and how likely each is. Equations: lib/docs/position-control.md.
#pragma once

#include <vector>

#include "enamel/render/position_control.hpp"
#include "render/mode_table.hpp"

namespace enamel {

/// A constant delay, or a random one: each delay of a range is equally likely in each tick.
struct LoopDelay {
  int low, pending;  ///< ticks; older commands that may act instead of the newest
  double acts;       ///< largest number of ticks in which a command acts: mean plus two standard deviations
  double reaction;   ///< reactionTime(), s
  double least;      ///< smallest probability, so that the delay can be learnt again
};

class DelayEstimator {
 public:
  // Plain numbers.
  struct State {
    double probability[kMostDelays];
  };

  /// Delay 0 is that of the data. The others are constant: those of its range, and up to two ticks less or more.
  explicit DelayEstimator(const ModeData& data);

  const LoopDelay& operator[](int i) const noexcept { return delays_[static_cast<std::size_t>(i)]; }
  /// Return the shortest and the longest delay in question, ticks.
  int shortest() const noexcept { return shortest_; }
  int longest() const noexcept { return longest_; }
  /// Return data for a design of each delay.
  std::vector<ModeData> designs(ModeData data) const;
  State start() const noexcept;
  /// Return whether a saved state can be continued.
  bool accepts(const State& s) const noexcept;
  int count() const noexcept { return static_cast<int>(delays_.size()); }
  /// Logarithms of the likelihood of what a tick showed. Row: delay; column: ticks of the command that acted.
  using Evidence = double[kMostDelays][kMaxLoopDelay + 1];
  /// Update by the evidence of a tick, its logarithms times `weight`. Returns the likeliest delay; `likeliest`: before.
  /// Realtime: yes.
  int learn(State& s, int likeliest, const Evidence& evidence, double weight) const noexcept;

 private:
  int shortest_, longest_;
  std::vector<LoopDelay> delays_;
};

}  // namespace enamel
