// Counts every allocation of the process: link apps/enamel/allocation_counter.cpp into an executable of its own.
#pragma once

#include "../../apps/enamel/allocation_counter.hpp"

namespace enamel::test {

using enamel::allocationCount;

}  // namespace enamel::test
