// Pass the latest value from one thread to another without waiting.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace enamel {

/// A buffer with one writer and one reader. The reader gets the newest complete value and may miss others. There are
/// three copies of T: one for the writer, one for the reader, and one that both exchange by a single atomic operation.
template <typename T>
class TripleBuffer {
 public:
  /// Return the place for the next value; it contains an old value. Threads: the writer's. Realtime: yes.
  T& next() noexcept { return slots_[writer_]; }

  /// Make the value of next() the newest. Threads: the writer's. Realtime: yes.
  void publish() noexcept {
    const std::uint8_t fresh = static_cast<std::uint8_t>(writer_ | kFresh);
    writer_ = middle_.exchange(fresh, std::memory_order_acq_rel) & kIndex;
  }

  /// Move to the newest value. Return false if nothing was published since the last call. Threads: the reader's.
  /// Realtime: yes.
  bool refresh() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    reader_ = middle_.exchange(reader_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// Return the value of the last refresh(), or T{} before the first. Threads: the reader's. Realtime: yes.
  const T& latest() const noexcept { return slots_[reader_]; }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;

  std::array<T, 3> slots_{};
  std::uint8_t writer_ = 0, reader_ = 1;
  alignas(64) std::atomic<std::uint8_t> middle_{2};
};

}  // namespace enamel
