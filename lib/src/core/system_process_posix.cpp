#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <thread>

#include "core/system_process.hpp"

namespace enamel::system {

void preferHugePages(void* memory, std::size_t size) noexcept { (void)madvise(memory, size, MADV_HUGEPAGE); }

bool lockMemory() noexcept {
  // Lock future mappings only if no limit can make later allocations fail.
  rlimit limit{};
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  return mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0;
}

void unlockMemory() noexcept { munlockall(); }

int processors() noexcept {
  cpu_set_t allowed;
  return sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed)
                                                             : static_cast<int>(std::thread::hardware_concurrency());
}

unsigned processId() noexcept { return static_cast<unsigned>(getpid()); }

}  // namespace enamel::system
