// The nominal device as a problem for the tuning tests.
#pragma once

#include "enamel/control/device_plant.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "support/devices.hpp"

namespace enamel::test {

TuneProblem nominalProblem();

}  // namespace enamel::test
