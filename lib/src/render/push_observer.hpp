// Observer of the device and of the hand that pushes it: Kalman filters of the modes, and hypotheses on when the push
// jumped. The equations: lib/docs/position-control.md.
//
// A mode has the states of mode_table.hpp and ln(mass / model's mass). The process noise has three parts: a trembling
// hand, random growth of the push, and the model error. The model error is a share of the force that accelerates the
// device or stretches a cable. Each tick, hypotheses branch off, one for each part of the tick. Each assumes that the
// push jumped in this part, by an unknown size in each mode. A jump of size 1 moves the states by g. So a hypothesis
// has states x of its own and the covariance P + v g g^T, with the variance v of the size (Willsky and Jones 1976).
// After two samples it is merged into the rest by its first two moments. All modes share the weights of the hypotheses.
// Hypotheses of jumps do not update the mass (Schmidt's filter). Behind cables, ln(stiffness / file's) is estimated
// too, from the derivative of the states by it (Friedland 1969). The modes' estimates of the one mass are fused by
// their information. A reading gives no information within the largest of its encoder steps (Steps::weigh()).
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "render/mode_table.hpp"

namespace enamel {

using Lane = std::array<double, kLanes>;

/// Law of the controller: each mode's torque is stiffness (target - wouldBe). wouldBe is the place to which the hand
/// would move the mode; `lead` are the seconds of speed in it.
struct ControlLaw {
  Lane stiffness, lead, wouldBe;
};

template <int kMech>
class PushObserver {
 public:
  static constexpr int kLag = kMech, kPush = kMech + 1, kGrowth = kMech + 2, kScale = kMech + 3, kStates = kMech + 4;
  static constexpr int kPairs = kStates * (kStates + 1) / 2;  // of a symmetric matrix
  static constexpr int kMost = 1 + 2 * kBins;                 // hypotheses
  static constexpr double kScalePrior = 0.3;                  // standard deviation of ln(mass) at the start
  static constexpr double kCablePrior = 0.3;                  // of ln(stiffness of the cables)
  static constexpr int at(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i; }

  using Numbers = ModeNumbers<kMech>;
  using States = double[kStates][kLanes];

  using Pairs = double[kPairs][kLanes];

  struct Hypothesis {
    States x, g;  // g: effect of a jump of size 1
    Lane v;       // variance of the jump's size
  };
  // Plain numbers.
  struct State {
    Hypothesis part[kMost];  // the first: no recent jump
    Pairs P;
    States mean;
    Lane weight, age;    // of the hypotheses; age in samples
    Lane inertia, used;  // of the links' modes in the model; inertia of the numbers in use
    Lane usedScale;      // ln(mass / model's) of the numbers in use
    Lane step, tremor;   // standard deviations of the hand's force in the modes
    Lane readingVariance, largestStep, joint;
    double count, modes, design;
    double scale, scaleVariance;  // ln(mass / model's)
    // Cables: derivative of the mean by ln(stiffness / file's), that number, and its value in use.
    States byCable;
    // For each delay in question: change of the mean if its commands had acted. The number of these delays.
    States byDelay[kMostDelays];
    double delays;
    double cable, cableVariance, usedCable;
  };
  /// Rounding of a mode's reading: its variance, the largest encoder step in it, and the joint with that step.
  struct Rounding {
    double variance = 0.0, largest = 0.0;
    int joint = 0;
  };
  struct Moments {
    double mean, deviation;
  };
  // Numbers of the modes at the inertia and the stiffness in use, and their derivatives by ln(inertia).
  struct Model {
    alignas(64) double value[Numbers::kCount][kLanes];
    alignas(64) double slope[Numbers::kSlopes][kLanes];
    alignas(64) double byCable[kMech == 4 ? Numbers::kSlopes : 1][kLanes];  // by ln(stiffness)
    double lagKept, growthKept, growthSum;                                  // over a tick
    double stiffness;                                                       // of the cables, N m/rad or N/m
  };

  /// Designs that differ in the delay only. `unseen`: of each joint, as gainTableOf().
  PushObserver(const std::vector<ModeData>& designs, const JointVector& unseen);

  /// Describe mode k: inertia, deviations of a step of the hand and of its tremor, rounding of a reading.
  void describe(State& s, int k, double inertia, double step, double tremor, const Rounding& reading) const noexcept;
  /// Start at rest at a reading, in as many modes as were described.
  void start(State& s, int modes, const Lane& reading) noexcept;
  /// Accept a reading and a rate that no hypothesis explains. Keeps the estimate of the mass.
  void believe(State& s, const Lane& reading, const Lane& rate) const noexcept;
  /// Use another design, for another delay, and the states with its commands. Forgets mass and stiffness: they were
  /// learnt with the commands of a wrong delay.
  void use(State& s, int design) const noexcept;
  /// Update the model to the state's inertias and scale. reload(): restore the exact model of a saved state.
  void refresh(State& s) noexcept;
  void reload(const State& s) noexcept;
  /// Return whether a saved state of so many modes can be continued.
  bool accepts(const State& s, int modes) const noexcept;
  /// Rotate modes i and j into each other.
  void rotate(State& s, int i, int j, double cosine, double sine) const noexcept;

  /// Predict one tick under a command, with the hypotheses that branch off. variance: of the command, if it is not
  /// known which one acts. shift(): a part of a tick, second order.
  void predict(State& s, const Lane& command, const Lane& variance = {}) const noexcept;
  void shift(State& s, double seconds) const noexcept;
  /// Return the largest innovation of a mode, in deviations, by the hypothesis that fits best.
  double surprise(const State& s, const Lane& reading) const noexcept;
  /// Difference of a reading from its prediction by all hypotheses, and the variance of this difference.
  void innovation(const State& s, const Lane& reading, Lane& difference, Lane& variance) const noexcept;
  /// Return the change of the predicted reading per unit of the last command.
  const double (&commandEffect() const noexcept)[kLanes] { return model_.value[Numbers::kCommandAt + readState()]; }
  void correct(State& s, const Lane& reading) const noexcept;
  /// End old hypotheses and update mean, weights and scale.
  void merge(State& s) const noexcept;

  /// Advance states by a tick under a command, at the mean scale.
  void advance(const Lane& command, States& x) const noexcept;
  /// Advance `d`, the derivative of states x by ln(mass), by a tick; the push scales too. Call it before advance().
  void advanceSensitivity(const Lane& command, const States& x, States& d) const noexcept;
  /// Return the derivative of mechanical state i, a tick later, by ln(mass), per unit command.
  const double (&commandSensitivity(int i) const noexcept)[kLanes] { return model_.slope[Numbers::kCommandAt + i]; }
  /// Return the law at the states x, delayLow ticks after the last sample. `pending`: older commands that may act then,
  /// as many as in the design, newest first.
  void law(const State& s, const States& x, const Lane* pending, ControlLaw& law) const noexcept;
  /// Convert a linear function of the states a tick later to one of the present states.
  void pullBack(States& row) const noexcept;
  /// Return mean and standard deviation of a linear function of the states.
  Moments moments(const State& s, const States& row) const noexcept;

  /// Return the state that encoders read.
  int readState() const noexcept { return kMech == 4 && data_.drive.encoderOnLink ? 2 : 0; }
  const ModeData& data(const State& s) const noexcept { return designs_[static_cast<std::size_t>(s.design)]; }

 private:
  static constexpr int kCables = kMech == 4 ? 11 : 1;  // stiffnesses with a table: factors of up to e^+-0.5
  static constexpr double kCableStep = 0.1;            // between their logarithms
  const double (&gain(int i) const noexcept)[kLanes] { return model_.value[Numbers::kGainAt + i]; }

  const InertiaTable<ModeGains<kMech>>& gainsOf(const State& s, int k) const noexcept {
    return *gains_[static_cast<std::size_t>(s.design)][static_cast<std::size_t>(s.joint[k])];
  }
  void read(const State& s, int k) noexcept;
  void stiffen(const State& s) noexcept { model_.stiffness = data_.drive.stiffness * std::exp(s.usedCable); }
  void forget(State& s) const noexcept;

  std::vector<ModeData> designs_;
  ModeData data_;  // of the first
  // Of each design and joint; all for the file's stiffness, because another one hardly changes the gains.
  std::vector<std::array<std::shared_ptr<const InertiaTable<ModeGains<kMech>>>, kMaxJoints>> gains_;
  std::array<std::shared_ptr<const InertiaTable<ModeModel<kMech>>>, kCables> models_;  // of stiffnesses
  Model model_;
};

}  // namespace enamel
