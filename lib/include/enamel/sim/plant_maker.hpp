// Plants of a device by name. The option --plant of the commands and `plant` of the Python module use these names.
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

/// List the names of plants. The path of an FMI unit (*.fmu) names a plant too.
std::vector<std::string> plantNames();

/// Return whether a text is the path of an FMI unit.
bool isUnit(const std::string& plant) noexcept;

/// Return why a text is not the name of a plant. Empty: it is one.
std::string checkPlant(const std::string& plant);

/// Return the plant with all data of a device's file: imperfect if it has [imperfections], else the closed form.
/// Realtime: yes.
const char* plantOf(const DeviceParameters& device) noexcept;

/// Return the drives (struct Drive) of a plant's motors. The result is a value for the parameter `drive` of the
/// renderer position-control: "device" (imperfect), "rigid" (imperfect-stiff: all but the cables) or "ideal" (all
/// others). Throws Error if the name is unknown. Realtime: no.
const char* drivesOf(const std::string& plant);

/// Return the device as a renderer should know it: with the drives of this plant. Throws Error if the name is unknown.
/// Realtime: no.
DeviceParameters modelFor(const std::string& plant, DeviceParameters device);

/// A function that makes the plant of a run from the number of its random stream. Any thread may call it.
using MakePlant = std::function<std::unique_ptr<Plant>(std::uint32_t stream)>;

/// Plants from libraries above this one. Empty: the program was built without that library.
struct OtherPlants {
  std::function<MakePlant(const DeviceParameters& device)> multibody;                        ///< multibodyPlants()
  std::function<MakePlant(const std::string& path, const DeviceParameters& device)> unit{};  ///< FMI unit
};

/// Return the maker of a plant. Null for the closed form, which needs none. An imperfect plant has late and lost ticks;
/// the function writes them into `setup`. Throws Error if the name is unknown, the plant is not among `others`, or the
/// device has no [imperfections]. Also throws what `others` and makeImperfectDevice() throw. Realtime: no.
MakePlant plantMaker(const std::string& plant, const DeviceParameters& device, const OtherPlants& others,
                     VirtualDeviceSetup& setup);

}  // namespace enamel
