// Counts the calls of malloc and its relatives in a program that is linked with allocation_counter.cpp.
#pragma once

namespace enamel {

/// Allocations and releases of the whole process so far.
long allocationCount() noexcept;

}  // namespace enamel
