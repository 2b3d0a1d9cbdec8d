// One-axis models and designs of position control, tabulated over the inertia of a mode.
//
// Where all motors have the same inertia J and all cables the same stiffness k, the eigenvectors of the links' inertia
// M - J 1 turn a device into independent modes: a rotor th and a link q joined by a cable, driven by a motor with lag,
//   J th'' = m - k (th - q) - b (th' - q'),  L q'' = k (th - q) + b (th' - q') + p,  m' = 2 pi f (u - m),
//   p' = g,  g' = -g / 20 ms,
// with the command u, and the hand's push p on the link, which grows by g. Rigid transmissions: q, q', m, p and g only.
// The gains minimise, over all ticks, the integral of (q / x)^2 + rho (u / F)^2: x is the depth of a large step of the
// hand that no controller avoids at this delay, F the largest force.
#pragma once

#include <memory>
#include <vector>

#include "enamel/device/mechanism.hpp"

namespace enamel {

inline constexpr int kLanes = 8;  ///< modes side by side: whole SIMD registers
inline constexpr int kBins = 2;   ///< parts of a tick in which a push may have jumped

/// What all modes of a device share.
struct ModeData {
  double period;  ///< T, s
  int delay;      ///< of a command, ticks
  Drive drive;
  double pushShare;   ///< a large step of the hand, as a share of the largest force
  double forceCost;   ///< rho
  double modelError;  ///< share of the force that the model does not have
  double chance;      ///< variance of the ticks in which a command acts, 1 in the mean
};

inline constexpr double kGrowthTime = 0.02;     ///< in which a push's growth fades, s
inline constexpr double kGrowthOfStep = 18.75;  ///< deviation of the growth, in steps of the hand a second

/// Rate of the motors' lag, 1/s; 1e5 Hz where there is none. Realtime: yes.
double lagOf(const Drive& drive) noexcept;

/// The numbers of a mode of one inertia, over one period.
template <int kMech>
struct ModeModel {
  double state[kMech][kMech + 3];                ///< mechanical states from mechanical states, lag, push and growth
  double command[kMech];                         ///< from the command
  double rotor[kMech], link[kMech];              ///< from a unit force on rotor or link, held
  double onset[kBins][kMech];                    ///< mean, by a unit push that begins anywhere in a bin
  double wander[(kMech + 2) * (kMech + 3) / 2];  ///< by a growth of unit deviation: mechanical states, push, growth
  double gain[kMech + 1];                        ///< of mechanical states and lag
};

/// ModeModel by ln(inertia), in even steps from 1e-7 to 1e2 kg m^2 or kg; linear between two entries, to 4e-4.
template <int kMech>
class ModeTable {
 public:
  static constexpr int kNumbers = sizeof(ModeModel<kMech>) / sizeof(double);
  static constexpr int kCommandAt = kMech * (kMech + 3), kRotorAt = kCommandAt + kMech, kLinkAt = kRotorAt + kMech,
                       kOnsetAt = kLinkAt + kMech, kWanderAt = kOnsetAt + kBins * kMech,
                       kGainAt = kWanderAt + (kMech + 2) * (kMech + 3) / 2;
  static constexpr int kSlopes = kRotorAt;  ///< numbers whose derivatives are asked for

  explicit ModeTable(const ModeData& data);

  /// Writes the numbers at an inertia, and their derivatives by its logarithm, into a lane. Realtime: yes.
  void read(double logInertia, int lane, double (*value)[kLanes], double (*slope)[kLanes]) const noexcept;

 private:
  std::vector<ModeModel<kMech>> entries_;
};

/// The table of these data. Renderers of the same data share one: the last few are kept. From any thread. Realtime: no.
template <int kMech>
std::shared_ptr<const ModeTable<kMech>> modeTableOf(const ModeData& data);

}  // namespace enamel
