// What `enamel design` and the study's report both say about a servo and its device.
#pragma once

#include <vector>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/impedance_map.hpp"
#include "enamel/control/servo_simulation.hpp"

namespace enamel::app {

/// Table II of a servo on its own linear model.
std::vector<Requirement> requirementsOf(const ServoDesign& design, const DevicePlant& plant);

/// The device as an impedance wall z = 0 feels it.
WallDevice wallDeviceOf(const DevicePlant& plant, double damping, double period);

}  // namespace enamel::app
