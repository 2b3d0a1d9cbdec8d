// One-axis models and control designs, tabulated over the inertia of a mode.
//
// If all motors have the same inertia J and all cables the same stiffness k, the device splits into independent modes:
// the eigenvectors of the links' inertia M - J 1. A mode is a rotor th and a link q, joined by a cable and driven by a
// motor with lag:
//
//   J th'' = m - k (th - q) - b (th' - q')
//
//   L q'' = k (th - q) + b (th' - q') + p
//
//   m' = 2 pi f (u - m),  p' = g,  g' = -g / 20 ms
//
// u is the command, p the push of the hand on the link, and g the growth of p. A rigid transmission has q, q', m, p and
// g only. The gains minimise the sum over all ticks of the integral of (q / x)^2 + rho (a / F)^2. F is the largest
// force, and a the command that acts in the tick: one of the last delayHigh - delayLow + 1, all equally likely. x is
// the depth of a large step of the hand that no controller can avoid at this delay and encoder step.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "enamel/device/mechanism.hpp"

namespace enamel {

inline constexpr int kLanes = 8;                      ///< modes computed in parallel: whole SIMD registers
inline constexpr int kBins = 2;                       ///< parts of a tick in which the push may jump
inline constexpr int kMostPending = 8;                ///< largest delayHigh - delayLow
inline constexpr int kMostDelays = kMostPending + 2;  ///< delays in question: a range and constant ones

/// Data that all modes of a device share.
struct ModeData {
  double period;            ///< T, s
  int delayLow, delayHigh;  ///< delay of a command, ticks: random in each tick, if they differ
  Drive drive;
  double pushShare;   ///< large step of the hand as a share of the largest force
  double forceCost;   ///< rho
  double modelError;  ///< share of the force that the model misses
};

inline constexpr double kGrowthTime = 0.02;     ///< s, decay time of a push's growth
inline constexpr double kGrowthOfStep = 18.75;  ///< standard deviation of the growth, steps of the hand per second

/// Return the root mean square of the time from a sample to the end of the first tick in which a command acts that
/// knows the sample, s. Realtime: yes.
double reactionTime(const ModeData& data) noexcept;

/// Return half an encoder step over the largest torque of each joint, rad/(N m) or m/N; 0 of a joint without a motor.
/// Realtime: no.
JointVector unseenOf(const JointVector& encoderStep, const JointVector& effort);

/// Return the rate of the motors' lag, 1/s; for motors without lag, that of 1e5 Hz. Realtime: yes.
double lagOf(const Drive& drive) noexcept;

/// Model of a mode of one inertia over one period.
template <int kMech>
struct ModeModel {
  double state[kMech][kMech + 3];                ///< mechanical states from mechanical states, lag, push and growth
  double command[kMech];                         ///< from the command
  double rotor[kMech], link[kMech];              ///< from a unit force on rotor or link, held for the period
  double onset[kBins][kMech];                    ///< mean effect of a unit push that begins anywhere in a bin
  double wander[(kMech + 2) * (kMech + 3) / 2];  ///< covariance (mechanical, push, growth) for a growth of deviation 1
};

/// Gains of a mode of one inertia.
template <int kMech>
struct ModeGains {
  double gain[kMech + 1];        ///< for mechanical states and lag, delayLow ticks after a sample
  double pending[kMostPending];  ///< for the commands that may act instead, newest first
};

/// Places of the numbers of a mode: ModeModel, then ModeGains.
template <int kMech>
struct ModeNumbers {
  static constexpr int kCommandAt = kMech * (kMech + 3), kRotorAt = kCommandAt + kMech, kLinkAt = kRotorAt + kMech,
                       kOnsetAt = kLinkAt + kMech, kWanderAt = kOnsetAt + kBins * kMech,
                       kGainAt = sizeof(ModeModel<kMech>) / sizeof(double), kPendingAt = kGainAt + kMech + 1,
                       kCount = kGainAt + sizeof(ModeGains<kMech>) / sizeof(double);
  static constexpr int kSlopes = kRotorAt;  ///< numbers with derivatives
};

/// Motion of rotor, link and motor of a mode with a constant push: x(t + seconds) = state x(t) + command u + push p.
template <int kMech>
struct ModeMotion {
  double state[kMech + 1][kMech + 1], command[kMech + 1], push[kMech + 1];
};
template <int kMech>
ModeMotion<kMech> modeMotion(const Drive& drive, double inertia, double seconds);

/// ModeModel or ModeGains over ln(inertia), in even steps from 1e-7 to 1e2 kg m^2 or kg. Linear interpolation, accurate
/// to 4e-4.
template <class Entry>
class InertiaTable {
 public:
  static constexpr int kNumbers = sizeof(Entry) / sizeof(double);

  explicit InertiaTable(std::vector<Entry> entries) : entries_(std::move(entries)) {}

  /// Write the numbers at an inertia, and the derivatives of the first `slopes` by its logarithm, into a lane.
  /// Realtime: yes.
  void read(double logInertia, int lane, double (*value)[kLanes], double (*slope)[kLanes] = nullptr,
            int slopes = 0) const noexcept;

 private:
  std::vector<Entry> entries_;
};

/// Return the table of these data. Renderers with the same data share one; the last few are cached. `unseen`: of a
/// joint, as unseenOf(). The models do not depend on the delay. Any thread. Realtime: no.
template <int kMech>
std::shared_ptr<const InertiaTable<ModeModel<kMech>>> modelTableOf(const ModeData& data);
template <int kMech>
std::shared_ptr<const InertiaTable<ModeGains<kMech>>> gainTableOf(const ModeData& data, double unseen);

}  // namespace enamel
