// A TAU device as a plant for the servo design.
#pragma once

#include "enamel/control/linearise.hpp"
#include "enamel/control/servo_design.hpp"
#include "enamel/device/tau/model.hpp"

namespace enamel {

/// The device about an operating point at rest, in states that a multibody tool might pick.
struct DevicePlant {
  PlantFunction f;   ///< x = [TCP position; rotation vector from the pose's orientation; twist], W; u = torque, N m
  OutputFunction h;  ///< y = [q'; q - q_op], rad/s, rad
  Eigen::VectorXd x0, u0;      ///< operating point: the pose at rest, the torque that balances gravity
  Vec6 angles;                 ///< q_op, rad
  Mat6 jacobian;               ///< V = J q' at the operating point
  double largestForce = 0.0;   ///< that the motors can give at the TCP along +z after gravity, N
  double effectiveMass = 0.0;  ///< felt at the TCP along z, kg
};

/// Wraps a device's forward dynamics at `pose`. The functions keep a copy of the model.
/// Throws DesignError: the pose is out of reach or singular. Realtime: no.
DevicePlant devicePlant(const TauModel& model, const Pose& pose);

/// The paper's whole chain for a device at rest at `pose`: linearise, transform, augment, hold, Riccati. `period` in s.
/// Throws DesignError: as devicePlant(), linearise() and designServo(). Realtime: no.
ServoDesign designServo(const TauModel& model, const Pose& pose, double period, const ServoWeights& weights = {});

}  // namespace enamel
