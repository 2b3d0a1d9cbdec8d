// A lock-free queue of fixed capacity from one thread to another.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

namespace enamel {

/// First-in first-out queue for one producer and one consumer (Lamport 1983). The capacity must be a power of two.
/// Values are copied.
template <typename T, std::size_t capacity>
class SpscRing {
  static_assert(capacity >= 2 && (capacity & (capacity - 1)) == 0, "the capacity must be a power of two");

 public:
  /// Append a value; if the ring is full, drop the value and return false. Producer's thread. Realtime: yes.
  bool push(const T& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == capacity) return false;
    slots_[tail % capacity] = value;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Take the oldest value; return false if the ring is empty. Consumer's thread. Realtime: yes.
  bool pop(T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    value = slots_[head % capacity];
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

 private:
  alignas(64) std::atomic<std::size_t> head_{0};  // next slot to pop
  alignas(64) std::atomic<std::size_t> tail_{0};  // next slot to push
  std::array<T, capacity> slots_{};
};

}  // namespace enamel
