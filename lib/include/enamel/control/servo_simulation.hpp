// Simulation of the servo on a sampled plant, and evaluation of its step responses.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "enamel/control/servo_design.hpp"

namespace enamel {

/// A function that returns the state [q'; q - q_op] one period later, under a constant joint torque and a constant
/// wrench at the TCP (N, N m). The torque is relative to that of the operating point (N m).
using SampledPlant = std::function<Eigen::VectorXd(const Eigen::VectorXd& y, const Eigen::VectorXd& torque,
                                                   const Eigen::VectorXd& wrench)>;

/// Return the held linear model of a design: y[j+1] = A_d y[j] + B_d (torque + J^T wrench). Throws DesignError: wrong
/// sizes.
SampledPlant linearPlant(const ServoDesign& design, const Eigen::MatrixXd& jacobian);

/// Steps of reference and wrench at tick 0, from rest at the operating point.
struct ServoExperiment {
  int ticks = 0;
  Eigen::VectorXd reference;  ///< r - q_op, rad; enters only through the integrators (eq. 11)
  Eigen::VectorXd wrench;     ///< at the TCP, N and N m
  int delay = 0;              ///< the torque computed at tick j acts from tick j + delay
  /// rad or m per joint. Empty: exact positions and velocities. Otherwise positions are rounded and velocities
  /// differenced.
  Eigen::VectorXd encoderStep;
  Eigen::VectorXd maxTorque;  ///< largest deviation from the operating point's torque, N m or N; empty: no limit
};

struct ServoTrace {
  Eigen::MatrixXd y;       ///< [q'; q - q_op] at the ticks, 2n x (ticks + 1)
  Eigen::MatrixXd torque;  ///< computed at each tick, n x ticks
};

/// Simulate u[j] = -K [q'; q - q_op; xi], xi += Ts (r - q) from tick 0. Throws DesignError: wrong sizes, or more than
/// 1e7 ticks. Realtime: no.
ServoTrace simulateServo(const ServoDesign& design, const SampledPlant& plant, const ServoExperiment& experiment);

/// Return the first impact stiffness K_z1 = F / D_z1 for a push of `force` (N), from ImpactMonitor ("A Position-Control
/// Based Approach ...", section V-B). NaN if the tool does not return. Realtime: no.
/// - `normal`: z' = normal q'.
/// - `period` of the ticks, s.
///
/// Throws DesignError: wrong sizes; a period that is not positive or gives more than 1e7 ticks a second.
double firstImpactStiffness(const ServoTrace& trace, const Eigen::RowVectorXd& normal, double force, double period);

/// Return the largest standard deviation of a joint torque over the last `ticks`, N m. Throws DesignError: an empty
/// trace or `ticks` below 1. Realtime: no.
double torqueDeviation(const ServoTrace& trace, int ticks);

/// A requirement of Table II and the measured values, one for each joint or wrench axis.
struct Requirement {
  std::string name, unit;
  double limit = 0.0;
  std::vector<double> values;

  double worst() const;
  bool met() const { return worst() < limit; }  ///< false if a value is not finite
};

/// Measure the requirements of Table II in a simulation of 1 s, with times interpolated between ticks. Realtime: no.
/// - A reference step of 0.01 rad in each joint in turn: overshoot, rise time from 10 to 90 %, settling time to +-2 %.
/// - A step of 10 N or 0.1 N m at the TCP along each axis in turn: deviation of the joints, and of the TCP through the
///   Jacobian.
///
/// Throws DesignError: wrong sizes; a period that is not positive or gives more than 1e7 ticks.
std::vector<Requirement> measureRequirements(const ServoDesign& design, const SampledPlant& plant,
                                             const Eigen::MatrixXd& jacobian);

}  // namespace enamel
