// The nominal TAU, built into the library. A program that uses it needs no device file.
#pragma once

#include "enamel/device/tau/parameters.hpp"

namespace enamel {

/// Return the text of data/devices/tau-nominal.toml from the time when the library was built. Realtime: no.
const char* nominalDeviceText() noexcept;

/// Return the parameters in that text. Realtime: no.
TauParameters nominalDevice();

}  // namespace enamel
