// The person's hand: a spring and a damper between the tool and a point that the mouse moves.
#pragma once

#include "enamel/sim/hand.hpp"

namespace enamel::viewer {

/// A firmer grip than in the paper.
inline constexpr Grip kFirmGrip{400.0, 12.0};

/// Largest force of the hand, N; at this force its target follows the tool.
inline constexpr double kLargestHandForce = 15.0;

/// Half the edge of the cube at whose faces the mechanical stops begin, m.
inline constexpr double kStop = 0.028;

/// The moving hand. Its point follows `target` like a critically damped spring of kHandRate. Along x and y it is at
/// least as firm as kGuideGrip. It keeps the tool's axes parallel to those of W (holdingMoment()).
struct Hand {
  Grip grip = kFirmGrip;
  Vec3 target = Vec3::Zero();    ///< m
  Vec3 position = Vec3::Zero();  ///< m
  Vec3 velocity = Vec3::Zero();  ///< m/s
};

/// Return the stiffness along x, y, z; the next function returns the damping. Realtime: yes.
Vec3 stiffnessOf(const Grip& grip) noexcept;
Vec3 dampingOf(const Grip& grip) noexcept;

/// Largest distance of the hand's target behind a mechanical stop, m: it does not wind up where the tool cannot follow.
inline constexpr double kBeyondStop = 0.005;

/// Limit the target to the reach of the tool's point: where the springs give kLargestHandForce, and kBeyondStop behind
/// a stop that the tool touches. Realtime: yes.
void keepWithinReach(Hand& hand, const Vec3& tool) noexcept;

/// Move the hand towards its target for `dt` s. Realtime: yes.
void moveHand(Hand& hand, double dt) noexcept;

/// Wrench on the platform at the TCP: of the hand, of a constant force, and of the mechanical stops. The hand's point
/// moves from time `since` on. The stops have 3 kN/m and 20 N s/m outside the cube of kStop. A load for
/// VirtualLoop::tick(). Realtime: yes.
class HandWrench {
 public:
  HandWrench(const Hand& hand, double since, const Vec3& held) noexcept;
  Vec6 operator()(double time, const Pose& pose, const Vec6& twist) const noexcept;

 private:
  Vec3 stiffness_, damping_, position_, velocity_, held_;
  double since_;
};

}  // namespace enamel::viewer
