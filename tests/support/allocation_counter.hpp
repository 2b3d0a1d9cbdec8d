// Counts every allocation of the process by interposing malloc, calloc, realloc, their aligned forms and (because
// the C++ operators end there) operator new. Link allocation_counter.cpp into an executable of its own.
#pragma once

namespace enamel::test {

/// Number of allocations and releases since the process began.
long allocationCount() noexcept;

}  // namespace enamel::test
