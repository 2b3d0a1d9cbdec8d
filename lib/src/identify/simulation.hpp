// Simulation of a recorded motion with a model of the device. Private to identify.
#pragma once

#include "enamel/identify/motion.hpp"
#include "identify/device_model.hpp"
#include "identify/path_dynamics.hpp"

namespace enamel::identify {

/// A soft spring and damper. It keeps the simulated joints near the recorded ones:
///
///   torque = M (w^2 e + 2 w e'),  w = 2 pi kObserverRate,
///
/// where e is the recorded reading minus the simulated one, through two low passes of kObserverFilter. M is the
/// device's inertia at home, with all couplings of joints. So all motions have the frequency w and forget a wrong start
/// equally fast, and noise of an encoder moves only its joint. M is the same for all models of a fit, so that their
/// readings differ only by the models.
struct Observer {
  JointMatrix inertia;  ///< M, kg m^2 or kg
  int substeps = 5;     ///< integration steps per tick, a multiple of `parts`
  int parts = 1;        ///< of a tick, with constant inertia and free acceleration
  int interval = 4;     ///< between knots of the path's dynamics, ticks
};

inline constexpr double kObserverRate = 3.0, kObserverFilter = 30.0;  // Hz

/// Return the observer for a model, with steps for its cables.
Observer observerFor(const DeviceModel& model, double period);

/// A direction in which a model changes: the difference of two models near it, per unit of a parameter.
struct ModelChange {
  DeviceModel before, after;
  double width = 1.0;                  ///< of the parameter, from before to after
  const PathDynamics* path = nullptr;  ///< derivative of the path's dynamics; null: zero
};

inline constexpr int kLanes = 16;  ///< most changes in one simulation

/// Readings that a model predicts under the recorded commands, one row per joint.
struct Simulated {
  Eigen::MatrixXd reading;
  Eigen::MatrixXd joints;               ///< coordinates of the mechanism: without offsets and the stretch of cables
  std::vector<Eigen::MatrixXd> slopes;  ///< derivative of `reading` with respect to each change
  int restarts = 0;  ///< how often the device left its workspace and was put back at the recorded pose
};

/// Simulate ticks `first` to `first` + `count` - 1. It begins at rest at the recorded pose. `path` begins
/// at the same tick. Slopes are those of the linearised equations: they have the errors of the
/// simulation's steps, and omit the transient of the beginning. Throws ConfigurationError if the model is impossible.
Simulated simulate(const DeviceModel& model, const PathDynamics& path, const RecordedMotion& motion,
                   const Observer& observer, Eigen::Index first, Eigen::Index count,
                   const std::vector<ModelChange>& changes = {});

}  // namespace enamel::identify
