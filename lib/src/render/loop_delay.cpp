#include "render/loop_delay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace enamel {
namespace {

constexpr double kRepeats = 2.0;  // deviations of the number of ticks in which a command acts
constexpr double kPrior = 1e-3;   // of a delay that was not stated
constexpr double kLeast = 1e-6;   // smallest probability, so that a delay can be learnt again
constexpr double kFar = 50.0;     // evidence against a delay in one tick, at most

}  // namespace

DelayEstimator::DelayEstimator(const ModeData& data) {
  const auto add = [&](int low, int high, double prior) {
    ModeData d = data;
    d.delayLow = low;
    d.delayHigh = high;
    const int n = high - low;
    delays_.push_back({low, n, std::min(n + 1.0, 1.0 + kRepeats * std::sqrt(n / (n + 1.0))), reactionTime(d), prior});
  };
  const int low = data.delayLow, high = data.delayHigh;
  add(low, high, 1.0);
  for (int d = std::max(0, low - 1); d <= std::min(kMaxLoopDelay, high + 1); ++d)
    if (low < high || d != low) add(d, d, kPrior);
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
  for (std::size_t i = 0; i < delays_.size(); ++i) s.probability[i] = delays_[i].prior;
  return s;
}

bool DelayEstimator::accepts(const State& s) const noexcept {
  bool isSound = false;
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    if (!(s.probability[i] >= kLeast && s.probability[i] <= 1.0)) return false;
    isSound = isSound || s.likeliest == static_cast<double>(i);
  }
  return isSound;
}

void DelayEstimator::learn(State& s, const double (&evidence)[kMaxLoopDelay + 1]) const noexcept {
  double most = -std::numeric_limits<double>::infinity(), total = 0.0, probability[kMost];
  for (const LoopDelay& delay : delays_)
    for (int d = delay.low; d <= delay.low + delay.pending; ++d) most = std::max(most, evidence[d]);
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    const LoopDelay& delay = delays_[i];
    double mean = 0.0;
    for (int d = delay.low; d <= delay.low + delay.pending; ++d)
      mean += std::exp(std::max(evidence[d] - most, -kFar)) / (delay.pending + 1);
    total += probability[i] = s.probability[i] * mean;
  }
  if (!(total > 0.0)) return;
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    s.probability[i] = std::max(probability[i] / total, kLeast);
    if (s.probability[i] > s.probability[static_cast<std::size_t>(s.likeliest)]) s.likeliest = static_cast<double>(i);
  }
}

}  // namespace enamel
