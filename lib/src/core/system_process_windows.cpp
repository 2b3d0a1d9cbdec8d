#include <windows.h>

#include <bitset>

#include "core/system_process.hpp"

namespace enamel::system {

void preferHugePages(void*, std::size_t) noexcept {}  // needs a privilege that users do not have

// VirtualLock() locks ranges of addresses. No function locks a whole process.
bool lockMemory() noexcept { return false; }
void unlockMemory() noexcept {}

int processors() noexcept {
  DWORD_PTR allowed = 0, all = 0;
  GetProcessAffinityMask(GetCurrentProcess(), &allowed, &all);
  return static_cast<int>(std::bitset<64>(allowed).count());
}

unsigned processId() noexcept { return GetCurrentProcessId(); }

}  // namespace enamel::system
