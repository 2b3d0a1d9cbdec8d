// A mechanism as a plant for the servo design.
#pragma once

#include "enamel/control/linearise.hpp"
#include "enamel/control/servo_design.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// A mechanism of n = 3 or 6 joints about an operating point at rest, in states that a multibody tool might pick.
struct DevicePlant {
  /// x = [TCP position; rotation vector from the pose's orientation (n = 6); their motion: v, w (n = 6)], W, 2n;
  /// u = torque, N m or N, n
  PlantFunction f;
  OutputFunction h;            ///< y = [q'; q - q_op], 2n
  Eigen::VectorXd x0, u0;      ///< operating point: the pose at rest, the torque that balances gravity
  Eigen::VectorXd joints;      ///< q_op, rad or m
  Eigen::MatrixXd jacobian;    ///< 6 x n, V = J q' at the operating point
  double largestForce = 0.0;   ///< that the motors can give at the TCP along +z after gravity, N
  double effectiveMass = 0.0;  ///< felt at the TCP along z, kg
};

/// Wraps the forward dynamics at `pose`. The functions share the mechanism.
/// Throws DesignError: no mechanism; the pose is no rotation, out of reach or singular; a number of joints other than 3 and 6. Realtime: no.
DevicePlant devicePlant(const std::shared_ptr<const Mechanism>& mechanism, const Pose& pose);

/// The paper's whole chain for a device at rest at `pose`: linearise, transform, augment, hold, Riccati. `period` in s.
/// Throws DesignError: as devicePlant(), linearise() and designServo(). Realtime: no.
ServoDesign designServo(const std::shared_ptr<const Mechanism>& mechanism, const Pose& pose, double period,
                        const ServoWeights& weights = {});

}  // namespace enamel
