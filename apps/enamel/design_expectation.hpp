// Prints the performance that `enamel design` expects of position control on a device.
#pragma once

#include "enamel/study/expectation.hpp"

namespace enamel::app {

/// Return the changes of the device that would increase the stiffness by more than 5 %.
std::string helpOf(const WallExpectation& expectation);

/// Print one line for each delay. `damping`: the device's own damping along z at home, N s/m. `withSpring`
/// adds the best springs.
void printExpectation(const std::vector<WallExpectation>& expectations, double period, double damping, bool withSpring);

}  // namespace enamel::app
