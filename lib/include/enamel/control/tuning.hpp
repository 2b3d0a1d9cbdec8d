// Tuning of the servo for the largest stiffness (research question 2 of "A Position-Control Based Approach ...").
#pragma once

#include <optional>

#include "enamel/control/servo_simulation.hpp"

namespace enamel {

/// Input of the tuning: the plant of the design, and the hardware.
struct TuneProblem {
  StateSpace plant;             ///< states [q'; q - q_op]
  Eigen::MatrixXd jacobian;     ///< 6 x n
  double period = 0.0;          ///< s
  Eigen::VectorXd encoderStep;  ///< rad or m per joint
  Eigen::VectorXd maxTorque;    ///< N m or N per joint
  double push = 12.0;           ///< along -z, for the stiffness and the chatter, N
};

/// Requirements on a tuned servo, all with a delay of `delay` samples in the loop.
struct TuneRequirements {
  int delay = 0;            ///< samples
  double diskMargin = 0.3;  ///< smallest allowed
  double chatter = 0.1;     ///< largest torqueDeviation() under the push, N m; encoders rounded, velocities differenced
  bool stepResponse = false;  ///< also require the step-reference rows of Table II (without delay)
};

/// A design and its performance, all with the delay in the loop.
struct TunedServo {
  ServoDesign design;
  double stiffness = 0.0;  ///< K_z1 for a step of the push, exact measurements, N/m
  double diskMargin = 0.0;
  double chatter = 0.0;     ///< N m
  int toleratedDelay = -1;  ///< samples
};

/// Evaluate the servo with the given weights and `delay` samples of delay. The result is empty if the servo cannot be
/// designed, is unstable with the delay, or never stops the push. Throws DesignError: wrong sizes of the plant; Error:
/// a period outside 1e-5 to 0.1 s. Realtime: no.
std::optional<TunedServo> evaluateServo(const TuneProblem& problem, int delay, const ServoWeights& weights);

/// Search the weights (torque = 1) for the stiffest servo that meets the requirements. The search is a logarithmic
/// grid, then a compass search (Hooke and Jeeves 1961) from the best point. The result is empty if no point of the grid
/// meets them. Throws DesignError: wrong sizes of the plant; Error: as evaluateServo(). Realtime: no (about 10 s).
std::optional<TunedServo> tuneServo(const TuneProblem& problem, const TuneRequirements& requirements);

/// Return the largest possible first impact stiffness of a controller without a force sensor, N/m:
///
///   K_z1 <= 2 m (F_max - F) / (F_max - F_0) / t1^2,   t1 = (delay + 1) Ts.
///
/// The push rises from `preload` F_0 to `force` F at a sample. The earliest response comes t1 later, with at most
/// the force F_max along the normal. `mass` m is the effective mass, kg. The result is 0 if F or F_0 >= F_max, if the
/// delay is negative, or if the period is not positive. Realtime: yes.
double firstImpactLimit(double mass, double period, int delay, double force, double largestForce,
                        double preload = 0.0) noexcept;

}  // namespace enamel
