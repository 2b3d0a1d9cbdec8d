// The TAU's dynamics the conventional way: a tree of six links and a free platform, three ball joints closed by
// Lagrange multipliers, everything assembled into one KKT system. Independent of the closed form in lib/device
// (body by body, from joint axes), so it serves the tests as a reference and the benchmark as the thing to beat.
#pragma once

#include <array>

#include "enamel/device/tau/parameters.hpp"

namespace enamel::bench {

/// State of the tree: relative joint angles (yaw, lift, elbow) a chain, the platform's pose, and their rates. The
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

/// Rates of the passive and driven joints that go with a twist, from the differentiated loop closures.
void setRates(const TauParameters& device, TreeState& state);

/// Forward dynamics from the KKT system of 15 coordinates and 9 loop closures, solved by pivoted LU.
TreeAcceleration assembledForwardDynamics(const TauParameters& device, const TreeState& state, const Vec6& torque,
                                          const Vec6& wrench);

}  // namespace enamel::bench
