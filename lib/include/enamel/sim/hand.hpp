// Models of a person's hand on the tool: springs and dampers. They follow "A Position-Control Based Approach to Haptic
// Rendering of Stiff Objects", section V. A guide keeps a free device from drifting away.
#pragma once

#include "enamel/core/types.hpp"

namespace enamel {

/// Stiffness and damping with which a hand holds the tool along one direction.
struct Grip {
  double stiffness;  ///< N/m
  double damping;    ///< N s/m
};

inline constexpr Grip kPaperGrip{40.0, 3.6};   ///< the paper's hand (section V)
inline constexpr Grip kGuideGrip{100.0, 3.6};  ///< across the push: 20 to 400 N/m hardly change the measured stiffness

/// An arm along one direction. The muscles' force moves the arm's mass against stiffness and damping. The mass moves
/// the tool through a grip. A person's push then rises within some tens of ms instead of at once, and has a mass behind
/// it.
struct Arm {
  double mass;       ///< kg
  double damping;    ///< N s/m
  double stiffness;  ///< N/m
  Grip grip;
};

/// An arm. Mass, damping and stiffness were measured at the handle of a haptic device, with one person in one trial.
/// Source: F. E. van Beek, W. M. Bergmann Tiest, W. Mugge and A. M. L. Kappers, "Haptic perception of force magnitude
/// and its relation to postural arm dynamics in 3D", 2016, figure 3. The values of the grip are plausible, not
/// measured.
inline constexpr Arm kArm{0.554, 6.45, 135.0, {2000.0, 10.0}};

/// A finger beside the handpiece that rests on a fixed tooth: it holds a point of the tool where it was at the start.
struct FingerRest {
  Vec3 point;  ///< in P, m
  Grip grip;   ///< in every direction
};

/// A finger 15 mm behind the tip. The stiffness of a finger pad grows with its force, and depends on time (Pawluk and
/// Howe, "Dynamic contact of the human fingerpad against a flat surface", 1999). The values are plausible, not
/// measured.
inline const FingerRest kFingerRest{{0.0, 0.0, 0.015}, {1000.0, 2.0}};

/// Motion of an arm, in steps of one tick. It begins at rest.
class MovingArm {
 public:
  explicit MovingArm(const Arm& arm) noexcept : arm_(arm) {}

  /// Return the force of the grip on the tool, N. The tool has moved by `way` (m) along the push, at `speed` (m/s).
  /// Realtime: yes.
  double push(double way, double speed) const noexcept {
    return arm_.grip.stiffness * (way_ - way) + arm_.grip.damping * (speed_ - speed);
  }

  /// Move on by one tick of `period` s under the muscles' force, N. The tool stays where it was at the beginning of the
  /// tick. The method is semi-implicit Euler; the arm's own motion takes about 20 ticks. Realtime: yes.
  void move(double force, double way, double speed, double period) noexcept {
    speed_ += period * (force - arm_.stiffness * way_ - arm_.damping * speed_ - push(way, speed)) / arm_.mass;
    way_ += period * speed_;
  }

 private:
  Arm arm_;
  double way_ = 0.0, speed_ = 0.0;  // m, m/s
};

/// Return the moment by which a hand holds the tool's orientation, N m. It is -0.5 N m/rad times the rotation from
/// `start`, plus -0.014 N m s/rad times `omega`. `omega` is the angular velocity, W, rad/s. Realtime: yes.
Vec3 holdingMoment(const Mat3& rotation, const Mat3& start, const Vec3& omega) noexcept;

/// Return the wrench of a guiding hand, N and N m: kGuideGrip and holdingMoment(). It holds the TCP across the unit
/// vector `normal` (W) and the orientation at the start pose. The tool is free along `normal`. Realtime: yes.
Vec6 guidingWrench(const Pose& pose, const Vec6& twist, const Pose& start, const Vec3& normal) noexcept;

}  // namespace enamel
