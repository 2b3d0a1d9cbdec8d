// The latest value from one thread to another, without waiting on either side.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace enamel {

/// One writer, one reader; the reader gets the newest complete value and may miss others. Three copies of T: one that
/// the writer fills, one that the reader reads, one in between that the two exchange by a single atomic operation.
template <typename T>
class TripleBuffer {
 public:
  /// Where the writer puts the next value; holds an old one. Writer's thread. Realtime: yes.
  T& next() noexcept { return slots_[writer_]; }

  /// Makes the value of next() the newest. Writer's thread. Realtime: yes.
  void publish() noexcept {
    const std::uint8_t fresh = static_cast<std::uint8_t>(writer_ | kFresh);
    writer_ = middle_.exchange(fresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Moves to the newest value; false if there is none since the last call. Reader's thread. Realtime: yes.
  bool refresh() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reader_ = middle_.exchange(reader_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// The value of the last refresh(); T{} before the first. Reader's thread. Realtime: yes.
  const T& latest() const noexcept { return slots_[reader_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;

  std::array<T, 3> slots_{};
  std::uint8_t writer_ = 0, reader_ = 1;
  alignas(64) std::atomic<std::uint8_t> middle_{2};
};

}  // namespace enamel
