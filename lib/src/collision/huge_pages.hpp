// Memory for arrays with random access. Pages of 2 MB, if the system grants them, reduce TLB misses.
#pragma once

#include <cstddef>
#include <limits>
#include <new>

#include "core/system_process.hpp"

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
    const std::size_t alignment = alignmentOf(count);
    const std::size_t size = (count * sizeof(T) + alignment - 1) / alignment * alignment;
    void* memory = ::operator new(size, std::align_val_t(alignment));
    if (alignment == kPage) system::preferHugePages(memory, size);
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) noexcept {
    ::operator delete(memory, std::align_val_t(alignmentOf(count)));
  }
  static constexpr std::size_t alignmentOf(std::size_t count) noexcept {
    return count * sizeof(T) < kPage ? (alignof(T) < 64 ? 64 : alignof(T)) : kPage;
  }

  friend bool operator==(const HugePages&, const HugePages&) noexcept { return true; }
  friend bool operator!=(const HugePages&, const HugePages&) noexcept { return false; }
};

}  // namespace enamel
