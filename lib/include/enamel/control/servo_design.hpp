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

/// A servo u[j] = -(K_c | K_i) [q'; q - q_op; xi] with xi' = r - q, and the models that it was designed on. n joints.
struct ServoDesign {
  double period = 0.0;  ///< Ts, s
  ServoWeights weights;
  StateSpace plant;      ///< continuous, states [q'; q - q_op], 2n (eq. 5)
  StateSpace augmented;  ///< sampled, states [q'; q - q_op; xi], 3n (eq. 10)
  Eigen::MatrixXd P;     ///< 3n x 3n, cost-to-go
  Eigen::MatrixXd K;     ///< n x 3n, [N m s/rad, N m/rad, N m/(rad s)]
};

/// Adds the integrals of the position error to a plant with states [q'; q - q_op] (eq. 7, with r = 0):
/// [x; xi]' = [A 0; (0 -I) 0] [x; xi] + [B; 0] u.
/// Throws DesignError: the plant has not 2n states and n inputs. Realtime: no.
StateSpace augmentWithIntegrals(const StateSpace& plant);

/// Designs the servo: augment, zero-order hold, Riccati.
/// `plant`: states [q'; q - q_op], rad/s and rad, inputs torque beyond that of the operating point, N m; `period` in s.
/// Throws DesignError: as augmentWithIntegrals, zeroOrderHold and solveRiccati; weights negative (torque: not
/// positive). Realtime: no.
ServoDesign designServo(const StateSpace& plant, double period, const ServoWeights& weights);

/// A servo whose commands act `delay` samples after their measurement: u = -K [q'; q - q_op; xi] - K_d [u of the last
/// `delay` samples, the latest first]. K n x 3n, K_d n x (delay n).
struct DelayedServo {
  Eigen::MatrixXd K, commandGain;
};

/// The optimal servo of the same weights for the plant augmented with the commands under way: the gain without delay on
/// the state that they lead to, x(j + d) = A^d x(j) + sum_(i = 1..d) A^(i-1) B u(j - i). Throws DesignError: a delay that
/// is negative or above 100. Realtime: no.
DelayedServo servoForDelay(const ServoDesign& design, int delay);

/// The loop as it runs, not as it was designed: states [q'; q - q_op; xi] of the held plant with the integrators that a
/// tick updates by xi[j+1] = xi[j] + Ts (r[j] - q[j]); input u. Realtime: no.
StateSpace runningLoop(const ServoDesign& design);

}  // namespace enamel
