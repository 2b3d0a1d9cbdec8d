// What begins a push: the options --plant and --tip of push and study, the start on the surface of a scene.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/sim/push.hpp"

namespace enamel::app {

inline constexpr const char* kClosedForm = "closed-form";
inline constexpr const char* kMultibody = "multibody";
inline constexpr const char* kReal = "real";
inline constexpr const char* kRealStiff = "real-stiff";

/// What --plant can be, beside the path of a unit (*.fmu).
std::vector<std::string> plantNames();

/// Whether it is one, for CLI11: "", or what is wrong; whether it is a unit.
std::string checkPlant(const std::string& plant);
bool isUnit(const std::string& plant) noexcept;

/// Its help.
inline constexpr const char* kPlantHelp =
    "closed-form: the mechanism's own dynamics; multibody: the same device in Simbody, some 200 times slower; real: "
    "with the [imperfections] of its file, for every run another "
    "device within its tolerances; real-stiff: the same, but its cables do not give; FILE.fmu: a unit of FMI 3.0";

inline constexpr const char* kTipHelp =
    "where the tool touches and the hand holds it, from the TCP, X,Y,Z in mm (0,0,0); the wall is level with it";

/// Makes the plant of a run by the number of its random stream; any thread.
using MakePlant = std::function<std::unique_ptr<Plant>(std::uint32_t stream)>;

/// Null for the closed form, which needs none. Ticks that come late or not at all belong to a real plant: they are put
/// into the setup. Throws Error: as makeRealDevice() and
/// MultibodyPlant; multibody where Enamel was built without Simbody; a unit that cannot be one (plantsOf(),
/// plugins/fmi/import.hpp), or where Enamel was built without them.
MakePlant makerOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup);

}  // namespace enamel::app
