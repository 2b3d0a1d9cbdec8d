// The shipped nominal TAU, built into the library: a program that uses it needs no file.
#pragma once

#include "enamel/device/tau/parameters.hpp"

namespace enamel {

/// Return the text of data/devices/tau-nominal.toml as it was when the library was built. Realtime: no.
const char* nominalDeviceText() noexcept;

/// Return the parameters that this text states. Realtime: no.
TauParameters nominalDevice();

}  // namespace enamel
