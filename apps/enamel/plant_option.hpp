// The options --plant and --tip of the commands.
#pragma once

#include "enamel/sim/plant_maker.hpp"

namespace enamel::app {

/// Help text of --plant.
inline constexpr const char* kPlantHelp =
    "closed-form: the mechanism's own dynamics; multibody: the same device in Simbody, some 200 times slower; real: "
    "with the [imperfections] of its file, for every run another "
    "device within its tolerances; imperfect-stiff: the same, but its cables do not give; FILE.fmu: a unit of FMI 3.0";

inline constexpr const char* kTipHelp =
    "where the tool touches and the hand holds it, from the TCP, X,Y,Z in mm (0,0,0); the wall is level with it";

/// Return a function that makes the named plant, if this program was built with it. Throws Error: as plantMaker().
MakePlant makerOf(const std::string& plant, const DeviceParameters& device, VirtualDeviceSetup& setup);

}  // namespace enamel::app
