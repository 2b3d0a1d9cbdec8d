// Quantiles of durations. One thread measures, and another may read at the same time.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace enamel {

/// Count durations in eight classes per octave, from 100 ns to 100 ms; each class is 9 % wide. Shorter and longer
/// durations count in the first and last class. One thread adds; any thread reads.
class DurationHistogram {
 public:
  /// Count a duration, s. Negative durations count as 0. Realtime: yes.
  void add(double duration) noexcept;

  /// Return the upper end of the class that contains the quantile p in [0, 1], s; 0 if empty. Realtime: yes.
  double quantile(double p) const noexcept;

  /// Return the largest duration so far, s. Realtime: yes.
  double largest() const noexcept { return largest_.load(std::memory_order_relaxed); }

  std::uint64_t count() const noexcept;

  /// Return the number of durations from `low` to below `high`, s. It counts the classes whose middle is in that range.
  /// Realtime: yes.
  std::uint64_t count(double low, double high) const noexcept;

 private:
  static constexpr int kClasses = 162;
  std::array<std::atomic<std::uint32_t>, kClasses> counts_{};
  std::atomic<double> largest_{0.0};
};

}  // namespace enamel
