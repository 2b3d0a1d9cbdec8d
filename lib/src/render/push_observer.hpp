// What is known of a device and of the hand that pushes it: Kalman filters of the modes, and hypotheses on when the
// push last jumped. The equations: lib/docs/position-control.md.
//
// A mode has the states of mode_table.hpp and ln(mass / model's). Its process noise is a trembling hand, the wandering
// growth of the push, and what the model lacks: a share of the force that accelerates the device or stretches a cable.
// Each tick hypotheses branch off, one for each part of the tick in which the push may have jumped by an unknown size
// in each mode. A jump of size 1 moves the states by g, so a hypothesis has its own states x, and the covariance P + v
// g g^T with v the variance of the size (Willsky and Jones 1976). It lives for two samples, then it is merged into the
// rest by its first two moments. All modes share the hypotheses' weights. A hypothesis teaches nothing of the mass
// (Schmidt's filter). The modes' opinions on the one mass are fused by their information. A reading says nothing within
// the largest of its encoders' steps (Steps::weigh()).
#pragma once

#include <array>

#include "render/mode_table.hpp"

namespace enamel {

using Lane = std::array<double, kLanes>;

template <int kMech>
class PushObserver {
 public:
  static constexpr int kLag = kMech, kPush = kMech + 1, kGrowth = kMech + 2, kScale = kMech + 3, kStates = kMech + 4;
  static constexpr int kPairs = kStates * (kStates + 1) / 2;  // of a symmetric matrix
  static constexpr int kMost = 1 + 2 * kBins;                 // hypotheses
  static constexpr double kScalePrior = 0.3;                  // deviation of ln(mass) at the start
  static constexpr int at(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

  using States = double[kStates][kLanes];

  using Pairs = double[kPairs][kLanes];

  struct Hypothesis {
    States x, g;         // g: what a jump of size 1 adds
    Lane v;              // variance of its size
    double weight, age;  // age in samples
  };
  // Plain numbers.
  struct State {
    Hypothesis part[kMost];  // the first: no jump of late
    Pairs P;
    double count, modes;
    States mean;
    double scale, scaleVariance;  // ln(mass / model's)
    Lane inertia, used;           // of the links' modes by the model; what the numbers in use are for
    Lane usedScale;               // ln(mass / model's) of these
    Lane step, tremor;            // deviations of the hand's force in the modes
    Lane readingVariance, readingPrecision, largestStep;  // precision: 1 / the root of the variance
  };
  /// Rounding of a mode's reading: variance, and the largest step among its encoders'.
  struct Rounding {
    double variance = 0.0, largest = 0.0;
  };
  struct Moments {
    double mean, deviation;
  };
  // The numbers of the modes at the inertia in use, and how they change with ln(inertia).
  struct Model {
    alignas(64) double value[ModeTable<kMech>::kNumbers][kLanes];
    alignas(64) double slope[ModeTable<kMech>::kSlopes][kLanes];
    double lagKept, growthKept, growthSum;  // of a tick
  };

  explicit PushObserver(const ModeData& data);

  /// Describes mode k: its inertia, deviations of a step of the hand and of its tremor, rounding of a reading.
  void describe(State& s, int k, double inertia, double step, double tremor, const Rounding& reading) const noexcept;
  /// Begins at rest at a reading, in as many modes as were described.
  void start(State& s, int modes, const Lane& reading) noexcept;
  /// Takes a reading and a rate that no hypothesis explains; keeps what is known of the mass.
  void believe(State& s, const Lane& reading, const Lane& rate) const noexcept;
  /// The model for the state's inertias and scale; reload(): exactly the one that a saved state was used with.
  void refresh(State& s) noexcept;
  void reload(const State& s) noexcept;
  /// Turns modes i and j into each other.
  void rotate(State& s, int i, int j, double cosine, double sine) const noexcept;

  /// One tick under a command, with the hypotheses that branch off in it; a part of a tick, to first order.
  void predict(State& s, const Lane& command) const noexcept;
  void shift(State& s, double seconds) const noexcept;
  /// The largest innovation of a mode, in deviations, by the hypothesis that expects it most.
  double surprise(const State& s, const Lane& reading) const noexcept;
  void correct(State& s, const Lane& reading) const noexcept;
  /// Ends hypotheses that are old, and sums up: mean, weights, scale.
  void merge(State& s) const noexcept;

  /// States a tick later under a command, at the mean scale.
  void advance(const Lane& command, States& x) const noexcept;
  /// The same, of how states x change with ln(mass), push and all: `d`, then a tick later. Before advance(command, x).
  void advanceSensitivity(const Lane& command, const States& x, States& d) const noexcept;
  /// How mechanical state i changes with ln(mass) by a unit command, a tick later.
  const double (&commandSensitivity(int i) const noexcept)[kLanes] {
    return model_.slope[ModeTable<kMech>::kCommandAt + i];
  }
  /// A linear function of the states a tick later, as one of the states now.
  void pullBack(States& row) const noexcept;
  /// Mean and deviation of a linear function of the states.
  Moments moments(const State& s, const States& row) const noexcept;

  const double (&gain(int i) const noexcept)[kLanes] { return model_.value[ModeTable<kMech>::kGainAt + i]; }

 private:
  // The state that encoders read.
  int readState() const noexcept { return kMech == 4 && data_.drive.encoderOnLink ? 2 : 0; }

  ModeData data_;
  std::shared_ptr<const ModeTable<kMech>> table_;
  Model model_;
};

}  // namespace enamel
