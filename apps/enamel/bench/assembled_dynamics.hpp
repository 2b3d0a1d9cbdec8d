// The TAU's dynamics in the conventional way: a tree of six links and a free platform. Lagrange multipliers close three
// ball joints, and everything is assembled into one KKT system. It shares no code with the closed form in lib/device:
// it works body by body from the joint axes. The tests use it as the reference, and the benchmark as the rival.
#pragma once

#include <array>

#include "enamel/device/tau/parameters.hpp"

namespace enamel::bench {

/// State of the tree: relative joint angles (yaw, lift, elbow) of each chain, the platform's pose, and their rates. The
/// rates must satisfy the loop closures.
struct TreeState {
  std::array<Vec3, 3> angles;  ///< rad
  std::array<Vec3, 3> rates;   ///< rad/s
  Pose pose;
  Vec6 twist;  ///< m/s, rad/s
};

struct TreeAcceleration {
  Vec6 joints;           ///< q'', rad/s^2
  Vec6 twist;            ///< V', m/s^2, rad/s^2
  double kineticEnergy;  ///< J
};

/// Compute the rates of passive and driven joints from a twist, with the differentiated loop closures.
void setRates(const TauParameters& device, TreeState& state);

/// Forward dynamics from the KKT system of 15 coordinates and 9 loop closures, solved by pivoted LU.
TreeAcceleration assembledForwardDynamics(const TauParameters& device, const TreeState& state, const Vec6& torque,
                                          const Vec6& wrench);

}  // namespace enamel::bench
