#include "allocation_counter.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>

// glibc's internal functions: safe to call before dlsym() works.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {
std::atomic<long> allocations{0};
thread_local long ofThisThread = 0;

void note() noexcept {
  ++allocations;
  ++ofThisThread;
}
}  // namespace

extern "C" {
void* malloc(std::size_t size) {
  note();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  note();
  return __libc_calloc(count, size);
}
void* realloc(void* old, std::size_t size) {
  note();
  return __libc_realloc(old, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  note();
  *result = __libc_memalign(alignment, size);
  return *result == nullptr ? ENOMEM : 0;
}
void free(void* pointer) {
  if (pointer != nullptr) note();
  __libc_free(pointer);
}
}

namespace enamel {
long allocationCount() noexcept { return allocations; }
long threadAllocationCount() noexcept { return ofThisThread; }
}  // namespace enamel
