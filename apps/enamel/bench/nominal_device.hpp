// The shipped nominal device, built in, so that the benchmark needs no file.
#pragma once

#include "enamel/device/tau/parameters.hpp"

namespace enamel::bench {

/// data/devices/tau-nominal.toml as it was when this program was built.
const char* nominalDeviceText();
TauParameters nominalDevice();

}  // namespace enamel::bench
