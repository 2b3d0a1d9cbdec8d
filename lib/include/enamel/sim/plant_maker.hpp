// Plants of a device by name, as the option --plant of the commands and `plant` of the Python module have them.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

inline constexpr const char* kClosedForm = "closed-form";
inline constexpr const char* kMultibody = "multibody";
inline constexpr const char* kImperfect = "imperfect";
inline constexpr const char* kImperfectStiff = "imperfect-stiff";

/// List the names of plants. The path of a unit of FMI (*.fmu) names a plant too.
std::vector<std::string> plantNames();

/// Return whether a text is the path of a unit.
bool isUnit(const std::string& plant) noexcept;

/// Return why a text names no plant; empty: it names one.
std::string checkPlant(const std::string& plant);

/// Return the plant that has all that a device's file says: imperfect where it has [imperfections], else the closed form.
/// Realtime: yes.
const char* plantOf(const DeviceParameters& device) noexcept;

/// Return which drives (struct Drive) the motors of a plant have, as the parameter `drive` of the renderer
/// position-control takes it: "device" (imperfect), "rigid" (imperfect-stiff: all but the cables) or "ideal" (all
/// others). Throws Error: an unknown name. Realtime: no.
const char* drivesOf(const std::string& plant);

/// Return the device as a renderer is told of it: with the drives that this plant has. Throws Error: an unknown name.
/// Realtime: no.
DeviceParameters modelFor(const std::string& plant, DeviceParameters device);

/// Makes the plant of a run from the number of its random stream. Any thread.
using MakePlant = std::function<std::unique_ptr<Plant>(std::uint32_t stream)>;

/// Plants from libraries above this one. Empty: the program was built without that library.
struct OtherPlants {
  std::function<MakePlant(const DeviceParameters& device)> multibody;                        ///< multibodyPlants()
  std::function<MakePlant(const std::string& path, const DeviceParameters& device)> unit{};  ///< of FMI
};

/// Return the maker of a plant; null for the closed form, which needs none. Late and lost ticks belong to an imperfect
/// plant: they are written into `setup`. Throws Error: an unknown name; a plant that is not among
/// `others`; what those throw; as makeImperfectDevice(); a device without [imperfections]. Realtime: no.
MakePlant plantMaker(const std::string& plant, const DeviceParameters& device, const OtherPlants& others,
                     VirtualDeviceSetup& setup);

}  // namespace enamel
