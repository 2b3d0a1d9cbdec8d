// Quantiles of durations that one thread measures and another one reads while it does.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace enamel {

/// Counts durations in eight classes an octave from 100 ns to 100 ms (each 9 % wide); shorter and longer ones fall into
/// the first and last class. One thread adds, any thread reads.
class DurationHistogram {
 public:
  /// Counts a duration, s; negative ones count as 0. Realtime: yes.
  void add(double duration) noexcept;

  /// Upper end of the class that holds the quantile p in [0, 1], s; 0 while empty. Realtime: yes.
  double quantile(double p) const noexcept;

  /// Largest duration so far, s. Realtime: yes.
  double largest() const noexcept { return largest_.load(std::memory_order_relaxed); }

  std::uint64_t count() const noexcept;

  /// Those of durations from `low` to below `high`, s, by whole classes: those whose middle is there. Realtime: yes.
  std::uint64_t count(double low, double high) const noexcept;

 private:
  static constexpr int kClasses = 162;
  std::array<std::atomic<std::uint32_t>, kClasses> counts_{};
  std::atomic<double> largest_{0.0};
};

}  // namespace enamel
