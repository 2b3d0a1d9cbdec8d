// How stiff can the servo be made (research question 2 of "A Position-Control Based Approach ...").
#pragma once

#include <optional>

#include "enamel/control/servo_simulation.hpp"

namespace enamel {

/// What the servo is tuned for: the plant of the design and the hardware around it.
struct TuneProblem {
  StateSpace plant;             ///< states [q'; q - q_op]
  Eigen::MatrixXd jacobian;     ///< 6 x n
  double period = 0.0;          ///< s
  Eigen::VectorXd encoderStep;  ///< a joint, rad or m
  Eigen::VectorXd maxTorque;    ///< a joint, N m or N
  double push = 12.0;           ///< along -z, that the stiffness and the chatter are for, N
};

/// What a tuned servo must keep to, all with `delay` samples of delay acting in the loop.
struct TuneRequirements {
  int delay = 0;            ///< samples
  double diskMargin = 0.3;  ///< at least
  double chatter = 0.1;     ///< at most, N m: torqueDeviation under the push, encoders rounded, velocities differenced
  bool stepResponse = false;  ///< also the step-reference rows of Table II (without delay)
};

/// A design and what it reaches, all with the delay acting.
struct TunedServo {
  ServoDesign design;
  double stiffness = 0.0;  ///< K_z1 for a step of the push, N/m, exact measurements
  double diskMargin = 0.0;
  double chatter = 0.0;     ///< N m
  int toleratedDelay = -1;  ///< samples
};

/// Evaluate the servo with the given weights and `delay` samples of delay. Empty where it cannot be designed, is
/// unstable with the delay or never stops the push. Throws Error: a period outside 1e-5 to 0.1 s. Realtime: no.
std::optional<TunedServo> evaluateServo(const TuneProblem& problem, int delay, const ServoWeights& weights);

/// Searches the weights (torque = 1) for the stiffest servo that keeps to the requirements: a logarithmic grid, then a
/// compass search (Hooke and Jeeves 1961) from the best point. Empty where no point of the grid keeps to them.
/// Throws DesignError: the plant has wrong sizes; Error as evaluateServo(). Realtime: no (about 10 s).
std::optional<TunedServo> tuneServo(const TuneProblem& problem, const TuneRequirements& requirements);

/// Largest first impact stiffness that any controller without a force sensor can have, N/m: a push that rises from
/// `preload` F_0 to `force` F on a sample is answered t1 = (delay + 1) Ts later at the soonest, with at most the force
/// F_max along the normal: K_z1 <= 2 m (F_max - F) / (F_max - F_0) / t1^2. `mass` is effective, kg; 0 where F or F_0 >=
/// F_max. Realtime: yes.
double firstImpactLimit(double mass, double period, int delay, double force, double largestForce,
                        double preload = 0.0) noexcept;

}  // namespace enamel
