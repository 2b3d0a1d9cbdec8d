#include "render/loop_delay.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

constexpr double kRepeats = 2.0;  // deviations of the number of ticks in which a command acts
constexpr double kPrior = 1e-3;   // of a delay that was not stated
constexpr double kLeast = 1e-6;   // smallest probability, so that a delay can be learnt again
constexpr double kFar = 50.0;     // evidence against a delay in one tick, at most

}  // namespace

DelayEstimator::DelayEstimator(const ModeData& data)
    : shortest_(std::max(0, data.delayLow - 1)), longest_(std::min(kMaxLoopDelay, data.delayHigh + 1)) {
  const auto add = [&](int low, int high) {
    ModeData d = data;
    d.delayLow = low;
    d.delayHigh = high;
    const int n = high - low;
    delays_.push_back({low, n, std::min(n + 1.0, 1.0 + kRepeats * std::sqrt(n / (n + 1.0))), reactionTime(d)});
  };
  const int low = data.delayLow, high = data.delayHigh;
  add(low, high);
  for (int d = shortest_; d <= longest_; ++d)
    if (low < high || d != low) add(d, d);
}

std::vector<ModeData> DelayEstimator::designs(ModeData data) const {
  std::vector<ModeData> all;
  for (const LoopDelay& delay : delays_) {
    data.delayLow = delay.low;
    data.delayHigh = delay.low + delay.pending;
    all.push_back(data);
  }
  return all;
}

DelayEstimator::State DelayEstimator::start() const noexcept {
  State s{};
  for (std::size_t i = 0; i < delays_.size(); ++i) s.probability[i] = i == 0 ? 1.0 : kPrior;
  return s;
}

bool DelayEstimator::accepts(const State& s) const noexcept {
  return std::all_of(s.probability, s.probability + delays_.size(), [](double p) { return p >= kLeast && p <= 1.0; });
}

int DelayEstimator::learn(State& s, int likeliest, const double (&evidence)[kMaxLoopDelay + 1]) const noexcept {
  const double most = *std::max_element(evidence + shortest_, evidence + longest_ + 1);
  double total = 0.0, probability[kMost];
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    const LoopDelay& delay = delays_[i];
    double mean = 0.0;
    for (int d = delay.low; d <= delay.low + delay.pending; ++d)
      mean += std::exp(std::max(evidence[d] - most, -kFar)) / (delay.pending + 1);
    total += probability[i] = s.probability[i] * mean;
  }
  if (!(total > 0.0)) return likeliest;
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    s.probability[i] = std::max(probability[i] / total, kLeast);
    if (s.probability[i] > s.probability[likeliest]) likeliest = static_cast<int>(i);
  }
  return likeliest;
}

}  // namespace enamel
