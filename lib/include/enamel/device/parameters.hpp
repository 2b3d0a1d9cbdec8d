// The parameters that device files of several mechanisms share.
#pragma once

#include "enamel/core/types.hpp"
#include "enamel/device/imperfections.hpp"

namespace enamel {

/// The body that carries the tool.
struct PlatformParameters {
  double mass = 0.0;            ///< kg
  Vec3 com = Vec3::Zero();      ///< centre of mass in P, m
  Mat3 inertia = Mat3::Zero();  ///< tensor about the centre of mass, axes of P, kg m^2
  Vec6 damping = Vec6::Zero();  ///< viscous damping of the TCP's twist, axes of W: 3 x N s/m, 3 x N m s/rad
};

/// Motors and encoders, the same for all driven joints, as seen from the joint's side.
struct MotorParameters {
  double maxTorque = 0.0;        ///< largest torque, N m
  double rotorInertia = 0.0;     ///< reflected to the joint, kg m^2
  double encoderCounts = 0.0;    ///< counts per revolution of the joint
  double viscousFriction = 0.0;  ///< N m s/rad
};

}  // namespace enamel
