#include "enamel/runtime/duration_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

constexpr double kShortest = 1e-7;  // s
constexpr double kPerOctave = 8.0;

}  // namespace

void DurationHistogram::add(double duration) noexcept {
  const double octaves = duration > kShortest ? std::log2(duration / kShortest) : 0.0;
  const int index = std::min(kClasses - 1, static_cast<int>(std::min(1e3, kPerOctave * octaves)));
  counts_[static_cast<std::size_t>(index)].fetch_add(1, std::memory_order_relaxed);
  if (duration > largest()) largest_.store(duration, std::memory_order_relaxed);
}

std::uint64_t DurationHistogram::count() const noexcept {
  std::uint64_t sum = 0;
  for (const auto& c : counts_) sum += c.load(std::memory_order_relaxed);
  return sum;
}

std::uint64_t DurationHistogram::count(double low, double high) const noexcept {
  std::uint64_t sum = 0;
  for (int i = 0; i < kClasses; ++i)
    if (const double middle = kShortest * std::exp2((i + 0.5) / kPerOctave); middle >= low && middle < high)
      sum += counts_[static_cast<std::size_t>(i)].load(std::memory_order_relaxed);
  return sum;
}

double DurationHistogram::quantile(double p) const noexcept {
  const std::uint64_t all = count();
  if (all == 0) return 0.0;
  const double rank = std::clamp(p, 0.0, 1.0) * static_cast<double>(all);
  std::uint64_t below = 0;
  for (int i = 0; i < kClasses; ++i) {
    below += counts_[static_cast<std::size_t>(i)].load(std::memory_order_relaxed);
    if (static_cast<double>(below) >= rank && below > 0) return kShortest * std::exp2((i + 1) / kPerOctave);
  }
  return largest();
}

}  // namespace enamel
