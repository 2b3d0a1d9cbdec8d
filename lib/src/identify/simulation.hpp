// Simulation of a recorded motion with a model of the device. Private to identify.
#pragma once

#include "enamel/identify/motion.hpp"
#include "identify/device_model.hpp"

namespace enamel::identify {

/// A soft spring and damper in each joint. It keeps the simulated joints near the recorded ones:
///
///   torque = K e + D e',  e = recorded reading - simulated reading, through two low passes of kObserverFilter.
///
/// It is the same for all models of a fit, so that their readings differ only by the models.
struct Observer {
  JointVector stiffness, damping;  ///< N m/rad and N m s/rad, or N/m and N s/m
  int substeps = 5;                ///< integration steps per tick, a multiple of `parts`
  int parts = 1;                   ///< of a tick, with constant inertia and free acceleration; a multiple of `places`
  int places = 1;                  ///< in a tick, where the dynamics of the mechanism are computed
};

inline constexpr double kObserverRate = 3.0, kObserverFilter = 30.0;  // Hz

/// Return the observer for a model: kObserverRate with its inertias at home, and steps for its cables.
Observer observerFor(const DeviceModel& model, double period);

/// Readings that a model predicts under the recorded commands, one row per joint.
struct Simulated {
  Eigen::MatrixXd reading;
  int restarts = 0;  ///< how often the device left its workspace and was put back at the recorded pose
};

/// Simulate ticks `first` to `first` + `count` - 1. It begins at rest at the recorded pose. Throws Error if that pose
/// is out of the model's reach, and ConfigurationError if the model is impossible.
Simulated simulate(const DeviceModel& model, const RecordedMotion& motion, const Observer& observer, Eigen::Index first,
                   Eigen::Index count);

}  // namespace enamel::identify
