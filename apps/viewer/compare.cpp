#include "compare.hpp"

#include <algorithm>

namespace enamel::viewer {

void Comparison::add(const PairSample& sample) {
  const std::array<double, 2> depths{std::max(0.0, sample.side[0].depth), std::max(0.0, sample.side[1].depth)};
  const bool inside = depths[0] > 0.0 || depths[1] > 0.0;
  depths_.add({static_cast<float>(depths[0]), static_cast<float>(depths[1])});

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

}  // namespace enamel::viewer
