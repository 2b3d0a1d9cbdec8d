// Shared by pushes, studies and trials from Python.
#pragma once

#include "enamel/sim/plant_maker.hpp"
#include "renderers.hpp"

namespace enamel::python {

/// Return the encoders of a run; `rates`: exact, difference, low-pass, or "" for the default. Throws Error: another
/// text.
EncoderOptions encodersOf(bool encoders, const std::string& rates, double lowPass);

/// Return the name of a plant. An old name gives a warning.
std::string plantName(const std::string& plant);

/// Return the maker of a plant, as --plant. Throws Error: as plantMaker().
MakePlant plantOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup);

/// Return the number of threads; 0: all available ones.
int threadsOf(int threads);

}  // namespace enamel::python
