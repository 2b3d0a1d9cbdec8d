// Hashes that identify devices, scenes and designs in a study's manifest.
#pragma once

#include <string>
#include <vector>

#include "enamel/control/device_plant.hpp"
#include "enamel/render/hold.hpp"

namespace enamel::app {

/// Return the 64-bit FNV-1a hash as 16 hexadecimal digits (Fowler, Noll, Vo 1991).
std::string hashOf(const std::string& text);
std::string hashOf(const std::vector<double>& values);
std::string hashOf(const std::vector<ServoGain>& gains);

}  // namespace enamel::app
