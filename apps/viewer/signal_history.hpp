// The last seconds of signals, thinned for curves.
#pragma once

#include <array>
#include <cstddef>

namespace enamel::viewer {

/// Smallest and largest value of each signal in bins of equal length.
template <std::size_t Signals>
class SignalHistory {
 public:
  static constexpr int kBins = 250;  ///< complete bins
  static constexpr int kBinTicks = 12;

  struct Range {
    float low = 0.0f, high = 0.0f;
    bool lowFirst = true;  ///< the lowest value came first
  };

  /// Add the values of one tick. If the first value of a bin is NaN, the bin is NaN.
  void add(const std::array<float, Signals>& values) {
    if (bins_[current_].count == kBinTicks) {
      current_ = (current_ + 1) % bins_.size();
      bins_[current_].count = 0;
    }
    Bin& bin = bins_[current_];
    for (std::size_t i = 0; i < Signals; ++i) {
      Range& range = bin.ranges[i];
      const float value = values[i];
      if (bin.count == 0)
        range = {value, value, true};
      else if (value > range.high)
        range.high = value, range.lowFirst = true;
      else if (value < range.low)
        range.low = value, range.lowFirst = false;
    }
    ++bin.count;
  }

  void clear() { *this = SignalHistory(); }

  /// Return the range of a complete bin, 0 (oldest) to kBins - 1.
  const Range& range(std::size_t signal, int bin) const {
    return bins_[(current_ + 1 + static_cast<std::size_t>(bin)) % bins_.size()].ranges[signal];
  }

 private:
  struct Bin {
    std::array<Range, Signals> ranges;
    int count = kBinTicks;
  };

  std::array<Bin, kBins + 1> bins_{};  // a ring; the current bin is incomplete
  std::size_t current_ = 0;
};

}  // namespace enamel::viewer
