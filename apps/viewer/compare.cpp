#include "compare.hpp"

#include <algorithm>

namespace enamel::viewer {

void Comparison::add(const PairSample& sample) {
  if (bins_[current_].count == kBinTicks) {
    current_ = (current_ + 1) % bins_.size();
    bins_[current_].count = 0;
  }
  Bin& bin = bins_[current_];
  bool inside = false;
  for (std::size_t i = 0; i < 2; ++i) {
    const double depth = std::max(0.0, sample.side[i].depth);
    inside = inside || depth > 0.0;
    Range& range = bin.depth[i];
    const auto value = static_cast<float>(depth);
    range = bin.count == 0 ? Range{value, value} : Range{std::min(range.low, value), std::max(range.high, value)};
  }
  ++bin.count;

  if (inside && apart_ >= kApart) {
    for (auto& curve : curves_) curve.clear();
    deepest_ = strongest_ = {};
    thinning_ = 1;
    skipped_ = 0;
  }
  if (!inside && apart_ >= kApart) return;
  apart_ = inside ? 0 : apart_ + 1;
  for (std::size_t i = 0; i < 2; ++i) {
    deepest_[i] = std::max(deepest_[i], sample.side[i].depth);
    strongest_[i] = std::max(strongest_[i], sample.side[i].force);
  }
  if (++skipped_ < thinning_) return;
  skipped_ = 0;
  for (std::size_t i = 0; i < 2; ++i)
    curves_[i].push_back({static_cast<float>(sample.side[i].depth), static_cast<float>(sample.side[i].force)});
  if (curves_[0].size() < kCurve) return;
  thinning_ *= 2;
  for (auto& curve : curves_) {
    for (std::size_t i = 0; 2 * i < curve.size(); ++i) curve[i] = curve[2 * i];
    curve.resize((curve.size() + 1) / 2);
  }
}

Comparison::Range Comparison::depth(std::size_t side, int bin) const {
  return bins_[(current_ + 1 + static_cast<std::size_t>(bin)) % bins_.size()].depth[side];
}

std::optional<Comparison::Ratio> Comparison::ratio() const {
  const std::size_t deeper = deepest_[1] >= deepest_[0] ? 1 : 0, other = 1 - deeper;
  if (std::min(strongest_[0], strongest_[1]) < kPressed || deepest_[deeper] < kLeast) return std::nullopt;
  return Ratio{deeper, deepest_[deeper] / std::max(kLeast, deepest_[other]), deepest_[other] < kLeast};
}

}  // namespace enamel::viewer
