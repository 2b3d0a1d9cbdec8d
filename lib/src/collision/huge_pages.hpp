// Memory for arrays with random access. Pages of 2 MB, if the system grants them, reduce TLB misses.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdlib>
#include <limits>
#include <new>

namespace enamel {

/// Allocator for std::vector. Small arrays come from the heap.
template <typename T>
struct HugePages {
  using value_type = T;
  static constexpr std::size_t kPage = std::size_t{1} << 21;

  HugePages() = default;
  template <typename Other>
  HugePages(const HugePages<Other>&) noexcept {}

  T* allocate(std::size_t count) {
    if (count > std::numeric_limits<std::size_t>::max() / 2 / sizeof(T)) throw std::bad_array_new_length();
    const std::size_t alignment = count * sizeof(T) < kPage ? (alignof(T) < 64 ? 64 : alignof(T)) : kPage;
    const std::size_t size = (count * sizeof(T) + alignment - 1) / alignment * alignment;
    void* memory = std::aligned_alloc(alignment, size);
    if (memory == nullptr) throw std::bad_alloc();
    if (alignment == kPage) (void)madvise(memory, size, MADV_HUGEPAGE);  // a hint; without it only slower
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t) noexcept { std::free(memory); }

  friend bool operator==(const HugePages&, const HugePages&) noexcept { return true; }
  friend bool operator!=(const HugePages&, const HugePages&) noexcept { return false; }
};

}  // namespace enamel
