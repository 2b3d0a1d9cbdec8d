// The servo on a sampled plant, tick by tick, and what its step responses say.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "enamel/control/servo_design.hpp"

namespace enamel {

/// State [q'; q - q_op] one period later, under constant joint torque beyond that of the operating point (N m) and a
/// constant wrench at the TCP (N, N m).
using SampledPlant = std::function<Eigen::VectorXd(const Eigen::VectorXd& y, const Eigen::VectorXd& torque,
                                                   const Eigen::VectorXd& wrench)>;

/// The held linear model of a design: y[j+1] = A_d y[j] + B_d (torque + J^T wrench).
SampledPlant linearPlant(const ServoDesign& design, const Eigen::MatrixXd& jacobian);

/// Steps at tick 0, from rest at the operating point.
struct ServoExperiment {
  int ticks = 0;
  Eigen::VectorXd reference;  ///< r - q_op, rad; it enters through the integrators only (eq. 11)
  Eigen::VectorXd wrench;     ///< at the TCP, N and N m
  int delay = 0;              ///< the torque computed at tick j acts from tick j + delay
  /// rad or m a joint; empty: exact positions and velocities; else positions rounded, velocities differenced
  Eigen::VectorXd encoderStep;
  Eigen::VectorXd maxTorque;  ///< N m or N, of the deviation from the operating point's; empty: no limit
};

struct ServoTrace {
  Eigen::MatrixXd y;       ///< [q'; q - q_op] at the ticks, 2n x (ticks + 1)
  Eigen::MatrixXd torque;  ///< computed at each tick, n x ticks
};

/// Runs u[j] = -K [q'; q - q_op; xi], xi += Ts (r - q) from tick 0. Throws DesignError: wrong sizes. Realtime: no.
ServoTrace simulateServo(const ServoDesign& design, const SampledPlant& plant, const ServoExperiment& experiment);

/// First impact stiffness K_z1 = F / D_z1 for a push of `force` (N), `period` s between the ticks: ImpactMonitor
/// ("A Position-Control Based Approach ...", section V-B). `normal`: z' = normal q'. NaN where the tool does not
/// return. Realtime: no.
double firstImpactStiffness(const ServoTrace& trace, const Eigen::RowVectorXd& normal, double force, double period);

/// Largest over the joints of the torque's standard deviation over the last `ticks`, N m. Realtime: no.
double torqueDeviation(const ServoTrace& trace, int ticks);

/// A requirement of Table II with what was measured, one value a joint or a wrench axis.
struct Requirement {
  std::string name, unit;
  double limit = 0.0;
  std::vector<double> values;

  double worst() const;
  bool met() const { return worst() < limit; }  ///< false where a value is not finite
};

/// Table II: a reference step of 0.01 rad in each joint in turn (overshoot, rise time from 10 to 90 %, settling time to
/// +-2 %), and a step of 10 N or 0.1 N m at the TCP along each axis in turn (deviation of the joints and, through the
/// Jacobian, of the TCP). Simulated for 1 s; times are interpolated between ticks. Realtime: no.
std::vector<Requirement> measureRequirements(const ServoDesign& design, const SampledPlant& plant,
                                             const Eigen::MatrixXd& jacobian);

}  // namespace enamel
