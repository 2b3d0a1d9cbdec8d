// A mechanism as a plant for servo design.
#pragma once

#include "enamel/control/linearise.hpp"
#include "enamel/control/servo_design.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// A mechanism of n = 3 or 6 joints about an operating point at rest. Its states are those that a multibody tool would
/// choose.
struct DevicePlant {
  /// x' = f(x, u). x: TCP position, rotation vector from the operating orientation (n = 6), v, w (n = 6); in W, 2n.
  /// u: joint torque, N m or N, n.
  PlantFunction f;
  OutputFunction h;            ///< y = [q'; q - q_op], 2n
  Eigen::VectorXd x0, u0;      ///< operating point: the pose at rest and the torque that balances gravity
  Eigen::VectorXd joints;      ///< q_op, rad or m
  Eigen::MatrixXd jacobian;    ///< 6 x n, V = J q' at the operating point
  double largestForce = 0.0;   ///< largest force of the motors at the TCP along +z, in addition to gravity balance, N
  double effectiveMass = 0.0;  ///< at the TCP along z, kg
};

/// Make a plant from the forward dynamics at `pose`. Its functions share the mechanism. Realtime: no.
/// Throws DesignError for:
/// - a null mechanism;
/// - a pose with an invalid rotation, out of reach or singular;
/// - a number of joints other than 3 and 6.
DevicePlant devicePlant(const std::shared_ptr<const Mechanism>& mechanism, const Pose& pose);

/// Design the servo for a device at rest at `pose`: linearise, transform, augment, hold, solve the Riccati equation, as
/// in the paper. `period` in s. Throws DesignError: as devicePlant(), linearise() and designServo(). Realtime: no.
ServoDesign designServo(const std::shared_ptr<const Mechanism>& mechanism, const Pose& pose, double period,
                        const ServoWeights& weights = {});

}  // namespace enamel
