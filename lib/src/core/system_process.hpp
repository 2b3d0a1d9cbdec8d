// Memory and processors of this process: system_process_posix.cpp, system_process_windows.cpp.
#pragma once

#include <cstddef>

namespace enamel::system {

// Request pages of 2 MB. A hint; without it only slower.
void preferHugePages(void* memory, std::size_t size) noexcept;

// Keep the process in memory. Return whether the system does so.
bool lockMemory() noexcept;
void unlockMemory() noexcept;

int processors() noexcept;  // that this process may use
unsigned processId() noexcept;

}  // namespace enamel::system
