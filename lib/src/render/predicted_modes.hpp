// The modes of the device at the time when the command of this tick acts: position control decides by them.
#pragma once

#include "enamel/render/frame.hpp"
#include "render/push_observer.hpp"

namespace enamel {

using ModeAxes = double[kMaxJoints][kLanes];  ///< column k: mode k in joint coordinates

/// Convert torques or rows of joints to modes. Realtime: yes.
inline Lane toModes(const ModeAxes& axes, int joints, const JointRow& v) noexcept {
  Lane m{};
  for (int j = 0; j < joints; ++j)
    for (int k = 0; k < kLanes; ++k) m[k] += axes[j][k] * v[j];
  return m;
}

/// Convert torques or motions of modes to joints. Realtime: yes.
inline JointRow toJoints(const ModeAxes& axes, int joints, const Lane& m) noexcept {
  JointRow v{};
  for (int j = 0; j < joints; ++j)
    for (int k = 0; k < joints; ++k) v[j] += axes[j][k] * m[k];
  return v;
}

/// All lanes are in mode coordinates.
struct PredictedModes {
  const ModeAxes* axes;
  int count;
  double period;        ///< s
  double handStep;      ///< step of the hand, N
  double tremor;        ///< of the hand, N
  double seconds;       ///< from the sample to that time
  Lane now, estimate;   ///< links: measured, and estimated from all samples
  Lane place, rate;     ///< links at that time
  Lane next, nextRate;  ///< a tick later without a force: place of the link, rate of link and rotor together
  Lane inertia;         ///< of link and rotor together
  Lane readingVariance;
  ControlLaw law;

  Lane toModes(const JointRow& v) const noexcept { return enamel::toModes(*axes, count, v); }
  JointRow toJoints(const Lane& m) const noexcept { return enamel::toJoints(*axes, count, m); }
};

}  // namespace enamel
