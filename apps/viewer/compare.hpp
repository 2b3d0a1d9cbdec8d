// Compares two tools under one hand: depth and force of both, press by press. Independent of any window.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "signal_history.hpp"

namespace enamel::viewer {

/// One tick of both tools, left and right.
struct PairSample {
  struct Side {
    double depth = 0.0;  ///< below the surface, m; negative outside
    double force = 0.0;  ///< delivered force of the motors on the tool along the wall's normal, N; negative: it pulls
  };
  std::array<Side, 2> side;
};

/// Recorded depths and presses. A press begins when either tool enters the wall after both were outside for kApart
/// ticks. It is kept until the next one begins.
class Comparison {
 public:
  using History = SignalHistory<2>;   ///< depths
  static constexpr int kApart = 300;  ///< ticks
  static constexpr int kCurve = 800;  ///< largest number of points of a press's curve

  struct Point {
    float depth = 0.0f, force = 0.0f;  ///< m, N
  };

  void add(const PairSample& sample);
  void clear() { *this = Comparison(); }

  /// Return the depth of one side, m. A tool outside has depth 0.
  const History::Range& depth(std::size_t side, int bin) const { return depths_.range(side, bin); }

  /// Return force over depth of the press, in order of time and thinned evenly; then the largest values since it began.
  const std::vector<Point>& curve(std::size_t side) const { return curves_[side]; }
  double deepest(std::size_t side) const { return deepest_[side]; }
  double strongest(std::size_t side) const { return strongest_[side]; }

 private:
  History depths_;
  std::array<std::vector<Point>, 2> curves_;
  std::array<double, 2> deepest_{}, strongest_{};
  int apart_ = kApart, thinning_ = 1, skipped_ = 0;
};

}  // namespace enamel::viewer
