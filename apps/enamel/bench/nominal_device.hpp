// The shipped nominal device, built in, so that the benchmark needs no file.
#pragma once

#include "enamel/device/parameters.hpp"

namespace enamel::bench {

/// data/devices/tau-nominal.toml as it was when this program was built.
const char* nominalDeviceText();
DeviceParameters nominalDevice();

}  // namespace enamel::bench
