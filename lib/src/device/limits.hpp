// What the mechanisms whose joints have the same motors share.
#pragma once

#include <cmath>

#include "enamel/device/imperfections.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/device/parameters.hpp"

namespace enamel {

/// Drive of a motor with what a real one has. Friction and cogging are known to a third of their amplitude: their
/// deviation where they change sign every few ticks.
inline Drive driveOf(const MotorParameters& motor, const Imperfections& real) {
  Drive drive;
  drive.bandwidth = real.currentBandwidth;
  drive.stiffness = real.cableStiffness;
  drive.damping = real.cableStiffness > 0.0 ? real.cableDamping : 0.0;
  drive.rotorInertia = real.cableStiffness > 0.0 ? motor.rotorInertia : 0.0;
  drive.disturbance = (real.coulombFriction + real.cogging) / 3.0;
  return drive;
}

/// Limits of `joints` joints with the same motor and encoder.
inline JointLimits limitsOf(const MotorParameters& motor, const Imperfections& real, int joints) {
  return {JointVector::Constant(joints, motor.maxTorque),
          JointVector::Constant(joints, 2.0 * M_PI / motor.encoderCounts), driveOf(motor, real)};
}

}  // namespace enamel
