// Counts every allocation of the process. Link apps/enamel/allocation_counter.cpp into a separate executable.
#pragma once

#include "../../apps/enamel/allocation_counter.hpp"

namespace enamel::test {

using enamel::allocationCount;

}  // namespace enamel::test
