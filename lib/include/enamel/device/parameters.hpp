// What the device files of all mechanisms share.
#pragma once

#include "enamel/core/types.hpp"
#include "enamel/device/imperfections.hpp"

namespace enamel {

/// The body that carries the tool.
struct PlatformParameters {
  double mass = 0.0;            ///< kg
  Vec3 com = Vec3::Zero();      ///< in P, m
  Mat3 inertia = Mat3::Zero();  ///< tensor about the centre of mass, axes of P, kg m^2
  Vec6 damping = Vec6::Zero();  ///< viscous damping of the TCP's twist, axes of W: 3 x N s/m, 3 x N m s/rad
};

/// Motors and encoders, the same at every driven joint and seen from the joint's side.
struct MotorParameters {
  double maxTorque = 0.0;        ///< N m
  double rotorInertia = 0.0;     ///< reflected, kg m^2
  double encoderCounts = 0.0;    ///< per joint revolution
  double viscousFriction = 0.0;  ///< N m s/rad
};

}  // namespace enamel
