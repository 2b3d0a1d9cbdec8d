// Counts the calls of malloc and related functions in a program that is linked with allocation_counter.cpp.
#pragma once

namespace enamel {

/// Return the number of allocations and releases of the whole process so far.
long allocationCount() noexcept;

/// The same for the calling thread: a library of a vendor may allocate in threads of its own.
long threadAllocationCount() noexcept;

}  // namespace enamel
