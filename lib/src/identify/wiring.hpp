// Coarse comparison of commands and motion: motors that are swapped or reversed, and the scale. Private to identify.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "enamel/identify/motion.hpp"
#include "identify/device_model.hpp"

namespace enamel::identify {

/// Result of a regression of the torque that the motion needs on the commands, below kCoarse Hz.
struct Wiring {
  double scale = 1.0;                 ///< torque by the device file, per commanded torque
  std::vector<std::string> problems;  ///< in words
};

/// Compare all assignments of motors to joints, with both signs.
Wiring checkWiring(const DeviceModel& model, const std::vector<RecordedMotion>& motions);

/// Return the torque for a motion by the mechanism's own dynamics, N m or N. Empty if the joints are out of reach.
/// `kinematics` is the start of the search and the result.
std::optional<JointVector> inverseDynamics(const Mechanism& mechanism, const JointVector& q, const JointVector& rates,
                                           const JointVector& accelerations, Kinematics& kinematics);

}  // namespace enamel::identify
