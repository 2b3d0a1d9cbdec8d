// The options --plant and --tip of the commands.
#pragma once

#include "enamel/sim/plant_maker.hpp"

namespace enamel::app {

/// Help text of --plant.
inline constexpr const char* kPlantHelp =
    "plant in simulation. closed-form: the device's ideal dynamics; multibody: the same device in Simbody, some 200 "
    "times slower; imperfect: with the [imperfections] of the device file, another device within its tolerances in "
    "every run; imperfect-stiff: the same with rigid cables; FILE.fmu: a unit of FMI 3.0";

inline constexpr const char* kTipHelp =
    "point where the tool touches and the hand holds it, from the TCP, X,Y,Z in mm (0,0,0); the wall is at its height";

/// Return a function that makes the named plant, if this program was built with it. Throws Error: as plantMaker().
MakePlant makerOf(const std::string& plant, const DeviceParameters& device, VirtualDeviceSetup& setup);

}  // namespace enamel::app
