// A unit as a plant: any tool's device, exported for co-simulation by FMI 3.0.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/plant.hpp"

namespace enamel::fmi {

/// What makes plants from the unit (*.fmu) at `path`, for the device that it is: one instance a run. Variables by name,
/// Float64, SI, as arrays or as scalars name[1], name[2] ...:
/// - inputs torque (n, one a joint), force (3, on the TCP, W); optional moment (3)
/// - outputs position (3, TCP in W), velocity (3); for devices that turn also orientation (4: unit quaternion
///   w, x, y, z) and angular_velocity (3); optional q and rates (n): what the encoders see
/// - optional parameters start_position (3) and start_orientation (4); a unit without them begins where it begins
/// The load is held over a step. Throws Error with the file and the reason: no archive; no or a broken
/// modelDescription.xml; another version than 3; no co-simulation; no binary for this machine, or one that cannot be
/// loaded; a variable that is missing, of the wrong type, size, causality or unit. What makes a plant throws Error
/// where the unit cannot be instantiated; why a step failed is told on stderr. Any
/// thread. Realtime: no.
std::function<std::unique_ptr<Plant>(std::uint32_t stream)> plantsOf(const std::string& path,
                                                                     const DeviceParameters& device);

}  // namespace enamel::fmi
