// Design of the position servo of "A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section IV.
#pragma once

#include "enamel/control/state_space.hpp"

namespace enamel {

/// Diagonal weights of the quadratic cost, eq. 12: Q = diag(velocity I, position I, integral I), R = torque I.
struct ServoWeights {
  double velocity = 1.0;
  double position = 1e3;
  double integral = 1e7;
  double torque = 1.0;
};

/// A servo u[j] = -(K_c | K_i) [q'; q - q_op; xi] with xi' = r - q for n joints, and the models that it is based on.
struct ServoDesign {
  double period = 0.0;  ///< Ts, s
  ServoWeights weights;
  StateSpace plant;      ///< continuous, 2n states [q'; q - q_op] (eq. 5)
  StateSpace augmented;  ///< sampled, 3n states [q'; q - q_op; xi] (eq. 10)
  Eigen::MatrixXd P;     ///< cost-to-go, 3n x 3n
  Eigen::MatrixXd K;     ///< gain, n x 3n, [N m s/rad, N m/rad, N m/(rad s)]
};

/// Add the integrals of the position error to a plant with states [q'; q - q_op] (eq. 7, with r = 0):
/// [x; xi]' = [A 0; (0 -I) 0] [x; xi] + [B; 0] u.
/// Throws DesignError if the plant does not have n inputs and 2n states. Realtime: no.
StateSpace augmentWithIntegrals(const StateSpace& plant);

/// Design the servo: augment the plant, apply a zero-order hold, solve the Riccati equation. Realtime: no.
/// - `plant`: states [q'; q - q_op], rad/s and rad; inputs are torques relative to the operating point, N m.
/// - `period` in s.
///
/// Throws DesignError: as augmentWithIntegrals, zeroOrderHold and solveRiccati; a weight that is negative or not
/// finite; a torque weight of zero.
ServoDesign designServo(const StateSpace& plant, double period, const ServoWeights& weights);

/// A servo for commands that act `delay` samples after their measurement:
/// u = -K [q'; q - q_op; xi] - K_d [the last `delay` commands u, the newest first]. K is n x 3n, K_d is n x (delay n).
struct DelayedServo {
  Eigen::MatrixXd K, commandGain;
};

/// Return the optimal servo of the same weights for the plant augmented with the pending commands. It is the gain
/// without delay, applied to the state that the pending commands will produce:
/// x(j + d) = A^d x(j) + sum_(i = 1..d) A^(i-1) B u(j - i).
/// Throws DesignError: a delay that is negative or above 100. Realtime: no.
DelayedServo servoForDelay(const ServoDesign& design, int delay);

/// Return the loop as it runs, which differs from the design in the integrators. A tick updates them by
/// xi[j+1] = xi[j] + Ts (r[j] - q[j]). The states are [q'; q - q_op; xi] of the held plant, the input is u.
/// Throws DesignError: sizes that do not match. Realtime: no.
StateSpace runningLoop(const ServoDesign& design);

}  // namespace enamel
