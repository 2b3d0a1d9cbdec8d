// One tick of a separate guard.
#pragma once

#include "enamel/render/guard.hpp"

namespace enamel::test {

/// Command for the motors.
struct GuardedCommand {
  JointVector effort;  ///< N m or N
  GuardReason reason = GuardReason::none;
};

/// `surface`: velocity of a touched obstacle, W, m/s.
inline GuardedCommand guardStep(Guard& guard, const Measurement& measurement, const Kinematics& kinematics,
                                const JointVector& requested, Status status, const Vec3& surface = Vec3::Zero()) {
  TickFrame frame;
  frame.kinematics = kinematics;
  frame.output.torque = requested;
  frame.contacts.count = 1;
  frame.contacts.contacts[0].obstacleVelocity = surface;
  guard.step(measurement, status, frame);
  return {frame.command, frame.reason};
}

}  // namespace enamel::test
