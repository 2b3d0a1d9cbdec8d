// Results of a servo and its device that `enamel design` and the study's report share.
#pragma once

#include <vector>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/impedance_map.hpp"
#include "enamel/control/servo_simulation.hpp"

namespace enamel::app {

/// Evaluate the requirements of the paper's Table II for a servo on its own linear model.
std::vector<Requirement> requirementsOf(const ServoDesign& design, const DevicePlant& plant);

/// Return the device as seen by an impedance wall z = 0.
WallDevice wallDeviceOf(const DevicePlant& plant, double damping, double period);

}  // namespace enamel::app
