// Counts the calls of malloc and related functions in a program that is linked with allocation_counter.cpp.
#pragma once

namespace enamel {

/// Return the number of allocations and releases of the calling thread so far.
long allocationCount() noexcept;

}  // namespace enamel
