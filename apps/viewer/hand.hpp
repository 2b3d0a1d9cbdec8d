// The person's hand: a spring and a damper between a point that the mouse moves and the tool.
#pragma once

#include "enamel/sim/hand.hpp"

namespace enamel::viewer {

/// A firmer grip than the paper's.
inline constexpr Grip kFirmGrip{400.0, 12.0};

/// Largest force that the hand builds up, N: beyond it, the hand follows the tool.
inline constexpr double kLargestHandForce = 15.0;

/// Half the side of the cube at whose faces the device's mechanical stops begin, m.
inline constexpr double kStop = 0.028;

/// The hand in motion. Its point follows `target` like a critically damped spring of kHandRate; along x and y it is at
/// least as firm as kGuideGrip, and it holds the tool's axes at those of W (holdingMoment()).
struct Hand {
  Grip grip = kFirmGrip;
  Vec3 target = Vec3::Zero();    ///< m
  Vec3 position = Vec3::Zero();  ///< m
  Vec3 velocity = Vec3::Zero();  ///< m/s
};

/// Stiffness and damping along x, y, z. Realtime: yes.
Vec3 stiffnessOf(const Grip& grip) noexcept;
Vec3 dampingOf(const Grip& grip) noexcept;

/// How far beyond a mechanical stop the hand's target goes, m: it does not wind up where the tool cannot follow.
inline constexpr double kBeyondStop = 0.005;

/// Brings the target within reach of the tool's point: where the springs give kLargestHandForce, and across a stop at
/// which the tool is, kBeyondStop. Realtime: yes.
void keepWithinReach(Hand& hand, const Vec3& tool) noexcept;

/// Moves the hand towards its target for `dt` s. Realtime: yes.
void moveHand(Hand& hand, double dt) noexcept;

/// Wrench on the platform at the TCP: of the hand (its point moving on from time `since`), of a held force, and of the
/// mechanical stops (3 kN/m, 20 N s/m outside the cube of kStop). A load for VirtualLoop::tick(). Realtime: yes.
class HandWrench {
 public:
  HandWrench(const Hand& hand, double since, const Vec3& held) noexcept;
  Vec6 operator()(double time, const Pose& pose, const Vec6& twist) const noexcept;

 private:
  Vec3 stiffness_, damping_, position_, velocity_, held_;
  double since_;
};

}  // namespace enamel::viewer
