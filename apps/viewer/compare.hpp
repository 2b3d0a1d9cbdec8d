// Two tools under one hand, compared: depth and force of both, press by press. Knows no window.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "signal_history.hpp"

namespace enamel::viewer {

/// One tick of two tools, left and right.
struct PairSample {
  struct Side {
    double depth = 0.0;  ///< below the surface, m; negative outside
    double force = 0.0;  ///< of the motors on the tool along the wall's normal, as delivered, N; negative: it pulls
  };
  std::array<Side, 2> side;
};

/// What is kept of them. A press begins where either tool enters the wall after both were out for kApart ticks; it is
/// kept until the next one begins.
class Comparison {
 public:
  using History = SignalHistory<2>;        ///< of the depths
  static constexpr int kApart = 300;       ///< ticks
  static constexpr int kCurve = 800;       ///< most points of a press's curve
  static constexpr double kLeast = 2e-6;   ///< m: less deep than this is not measured
  static constexpr double kPressed = 1.0;  ///< N: a press of less force has no ratio

  struct Point {
    float depth = 0.0f, force = 0.0f;  ///< m, N
  };

  void add(const PairSample& sample);
  void clear() { *this = Comparison(); }

  /// Depth of one side, m. An outside tool has depth 0.
  const History::Range& depth(std::size_t side, int bin) const { return depths_.range(side, bin); }

  /// Of the press: force over depth, in order of time, thinned evenly; and the largest of both since it began.
  const std::vector<Point>& curve(std::size_t side) const { return curves_[side]; }
  double deepest(std::size_t side) const { return deepest_[side]; }
  double strongest(std::size_t side) const { return strongest_[side]; }

  /// How many times as deep the one tool went as the other. None where either was pressed with less than kPressed, or
  /// both went less deep than kLeast.
  struct Ratio {
    std::size_t deeper;  ///< side
    double times;        ///< at least 1
    bool atLeast;        ///< the other one went less deep than kLeast, which stands for its depth
  };
  std::optional<Ratio> ratio() const;

 private:
  History depths_;
  std::array<std::vector<Point>, 2> curves_;
  std::array<double, 2> deepest_{}, strongest_{};
  int apart_ = kApart, thinning_ = 1, skipped_ = 0;
};

}  // namespace enamel::viewer
