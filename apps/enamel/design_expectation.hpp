// What `enamel design` expects of position control on a device.
#pragma once

#include "enamel/study/expectation.hpp"

namespace enamel::app {

/// Prints a line a delay; `damping`: the device's own along z at home, N s/m.
void printExpectation(const std::vector<WallExpectation>& expectations, double period, double damping);

}  // namespace enamel::app
