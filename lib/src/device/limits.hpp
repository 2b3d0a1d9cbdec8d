// Limits of mechanisms whose joints all have the same motor.
#pragma once

#include <cmath>

#include "enamel/device/imperfections.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/device/parameters.hpp"

namespace enamel {

/// Return the drive of a real motor. Friction and cogging count with a third of their amplitude: their standard
/// deviation if they change sign every few ticks.
inline Drive driveOf(double rotorInertia, const Imperfections& real) {
  Drive drive;
  drive.bandwidth = real.currentBandwidth;
  drive.stiffness = real.cableStiffness;
  drive.damping = real.cableStiffness > 0.0 ? real.cableDamping : 0.0;
  drive.rotorInertia = real.cableStiffness > 0.0 ? rotorInertia : 0.0;
  drive.disturbance = (real.coulombFriction + real.cogging) / 3.0;
  return drive;
}

/// Return the limits of `joints` joints with the same motor and encoder.
inline JointLimits limitsOf(const MotorParameters& motor, const Imperfections& real, int joints) {
  return {JointVector::Constant(joints, motor.maxTorque),
          JointVector::Constant(joints, 2.0 * M_PI / motor.encoderCounts), driveOf(motor.rotorInertia, real)};
}

}  // namespace enamel
