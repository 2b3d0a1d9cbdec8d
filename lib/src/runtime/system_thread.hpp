// Clock, sleep and priority of the calling thread: system_thread_posix.cpp, system_thread_windows.cpp.
#pragma once

#include <cstdint>

namespace enamel::system {

std::int64_t clockNow() noexcept;                 // ns; never set back
void sleepUntil(std::int64_t deadline) noexcept;  // of clockNow(), as accurately as the system can
bool requestRealtime(int priority) noexcept;      // of POSIX, 1 to 99; returns whether the system granted it
void nameThread(const char* name) noexcept;       // for debuggers, at most 15 characters
void makeWriteErrorsOrdinary() noexcept;          // a broken pipe does not end the process

}  // namespace enamel::system
