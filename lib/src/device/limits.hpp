// What the mechanisms whose joints have the same motors share.
#pragma once

#include <cmath>

#include "enamel/device/mechanism.hpp"
#include "enamel/device/parameters.hpp"

namespace enamel {

/// Limits of `joints` joints with the same motor and encoder.
inline JointLimits limitsOf(const MotorParameters& motor, int joints) {
  return {JointVector::Constant(joints, motor.maxTorque),
          JointVector::Constant(joints, 2.0 * M_PI / motor.encoderCounts)};
}

}  // namespace enamel
