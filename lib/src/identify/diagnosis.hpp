// Faults that the residual of a fit shows. Private to identify.
#pragma once

#include <string>
#include <vector>

#include "identify/fit.hpp"

namespace enamel::identify {

/// Return faults in words: motors that give less torque than the largest commands demand. `delay` is that of the
/// commands, ticks.
std::vector<std::string> diagnose(Fit& fit, int delay);

}  // namespace enamel::identify
