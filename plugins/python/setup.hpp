// What pushes, studies and trials from Python have in common.
#pragma once

#include "enamel/sim/plant_maker.hpp"
#include "renderers.hpp"

namespace enamel::python {

/// The encoders of a run; `rates`: exact, difference, low-pass, or "" for the usual one. Throws Error: another one.
EncoderOptions encodersOf(bool encoders, const std::string& rates, double lowPass);

/// The name of a plant, also given by its old one, with a warning.
std::string plantName(const std::string& plant);

/// The plant of a device, as --plant. Throws Error: as plantMaker().
MakePlant plantOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup);

/// 0: all that there are.
int threadsOf(int threads);

}  // namespace enamel::python
