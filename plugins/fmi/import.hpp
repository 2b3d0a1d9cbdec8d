// Uses a unit as a plant: a device from any tool that exports FMI 3.0 for co-simulation.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/plant.hpp"

namespace enamel::fmi {

/// Return a function that makes plants from the unit (*.fmu) at `path` for a device: one instance per run. The unit's
/// variables are found by name. They are Float64, SI, arrays or scalars name[1], name[2] ...:
/// - inputs torque (n, one per joint), force (3, on the TCP, W); optional moment (3)
/// - outputs position (3, TCP in W), velocity (3); optional q and rates (n): readings of the encoders
/// - for devices that turn also outputs orientation (4: unit quaternion w, x, y, z) and angular_velocity (3)
/// - optional parameters start_position (3) and start_orientation (4); without them the unit starts at its own pose
/// The load is constant over a step. Throws Error with the file and the reason:
/// - the file is not an archive;
/// - modelDescription.xml is missing or broken;
/// - the version is not 3, or co-simulation is missing;
/// - the binary for this machine is missing, or cannot be loaded;
/// - a variable is missing or has a wrong type, size, causality or unit.
/// The returned function throws Error if the unit cannot be instantiated. A failed step prints its reason on stderr.
/// Any thread. Realtime: no.
std::function<std::unique_ptr<Plant>(std::uint32_t stream)> plantsOf(const std::string& path,
                                                                     const DeviceParameters& device);

}  // namespace enamel::fmi
