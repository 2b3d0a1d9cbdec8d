// What a person's hand does to the tool: springs and dampers of "A Position-Control Based Approach to Haptic Rendering
// of Stiff Objects", section V, and what keeps a free device from drifting away.
#pragma once

#include "enamel/core/types.hpp"

namespace enamel {

/// How firmly a hand holds the tool along one direction.
struct Grip {
  double stiffness;  ///< N/m
  double damping;    ///< N s/m
};

inline constexpr Grip kPaperGrip{40.0, 3.6};  ///< of the paper's hand (section V)
inline constexpr Grip kGuide{100.0, 3.6};     ///< across the push: 20 to 400 N/m hardly change the stiffness measured

/// Moment by which a hand holds the tool's orientation, N m: -0.5 N m/rad of the turn from `start` and -0.014 N m s/rad
/// of the angular velocity `omega` (W, rad/s). Realtime: yes.
Vec3 holdingMoment(const Mat3& rotation, const Mat3& start, const Vec3& omega) noexcept;

/// Wrench of a hand that keeps the TCP across the unit vector `normal` (W) and its orientation about the start pose,
/// and leaves it free along it: kGuide and holdingMoment(), N and N m. Realtime: yes.
Vec6 guidingWrench(const Pose& pose, const Vec6& twist, const Pose& start, const Vec3& normal) noexcept;

}  // namespace enamel
