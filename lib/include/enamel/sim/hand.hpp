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

inline constexpr Grip kPaperGrip{40.0, 3.6};   ///< of the paper's hand (section V)
inline constexpr Grip kGuideGrip{100.0, 3.6};  ///< across the push: 20 to 400 N/m hardly change the stiffness measured

/// An arm along one direction: the muscles' force moves its mass against stiffness and damping, and the mass moves the
/// tool through a grip. A person's push then comes within some tens of ms instead of at once, with a mass behind it.
struct Arm {
  double mass;       ///< kg
  double damping;    ///< N s/m
  double stiffness;  ///< N/m
  Grip grip;
};

/// Mass, damping and stiffness: measured at the handle of a haptic device (F. E. van Beek, W. M. Bergmann Tiest,
/// W. Mugge and A. M. L. Kappers, "Haptic perception of force magnitude and its relation to postural arm dynamics in
/// 3D", 2016, figure 3: one person, one trial). The grip is plausible.
inline constexpr Arm kArm{0.554, 6.45, 135.0, {2000.0, 10.0}};

/// An arm in motion, in steps of a tick; begins at rest.
class MovingArm {
 public:
  explicit MovingArm(const Arm& arm) noexcept : arm_(arm) {}

  /// Force of the grip on a tool that has moved by `way` (m) along the push, at `speed` (m/s). Realtime: yes.
  double push(double way, double speed) const noexcept {
    return arm_.grip.stiffness * (way_ - way) + arm_.grip.damping * (speed_ - speed);
  }

  /// Moves on by a tick of `period` s under the muscles' force, N, with the tool where it was at its beginning
  /// (semi-implicit Euler: the arm's own motion takes some 20 ticks). Realtime: yes.
  void move(double force, double way, double speed, double period) noexcept {
    speed_ += period * (force - arm_.stiffness * way_ - arm_.damping * speed_ - push(way, speed)) / arm_.mass;
    way_ += period * speed_;
  }

 private:
  Arm arm_;
  double way_ = 0.0, speed_ = 0.0;  // m, m/s
};

/// Moment by which a hand holds the tool's orientation, N m: -0.5 N m/rad of the turn from `start` and -0.014 N m s/rad
/// of the angular velocity `omega` (W, rad/s). Realtime: yes.
Vec3 holdingMoment(const Mat3& rotation, const Mat3& start, const Vec3& omega) noexcept;

/// Wrench of a hand that keeps the TCP across the unit vector `normal` (W) and its orientation about the start pose,
/// and leaves it free along it: kGuideGrip and holdingMoment(), N and N m. Realtime: yes.
Vec6 guidingWrench(const Pose& pose, const Vec6& twist, const Pose& start, const Vec3& normal) noexcept;

}  // namespace enamel
