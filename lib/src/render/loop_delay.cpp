#include "render/loop_delay.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

constexpr int kAway = 2;          // ticks: farthest delay in question outside the stated range
constexpr double kRepeats = 2.0;  // deviations of the number of ticks in which a command acts
constexpr double kFar = 50.0;     // evidence against a delay in one tick, at most
constexpr double kLeast = 1e-6;   // smallest probability of a delay that is a tick away from the stated one

}  // namespace

DelayEstimator::DelayEstimator(const ModeData& data)
    : shortest_(std::max(0, data.delayLow - kAway)), longest_(std::min(kMaxLoopDelay, data.delayHigh + kAway)) {
  const auto add = [&](int low, int high) {
    ModeData d = data;
    d.delayLow = low;
    d.delayHigh = high;
    const int n = high - low, away = std::max({1, data.delayLow - low, low - data.delayHigh});
    delays_.push_back({low, n, std::min(n + 1.0, 1.0 + kRepeats * std::sqrt(n / (n + 1.0))), reactionTime(d),
                       std::pow(kLeast, away)});
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
  for (std::size_t i = 0; i < delays_.size(); ++i) s.probability[i] = i == 0 ? 1.0 : std::sqrt(delays_[i].least);
  return s;
}

bool DelayEstimator::accepts(const State& s) const noexcept {
  return std::equal(delays_.begin(), delays_.end(), s.probability,
                    [](const LoopDelay& delay, double p) { return p >= delay.least && p <= 1.0; });
}

int DelayEstimator::learn(State& s, int likeliest, const Evidence& evidence, double weight) const noexcept {
  double most = evidence[0][delays_[0].low], total = 0.0, probability[kMostDelays];
  for (std::size_t i = 0; i < delays_.size(); ++i)
    for (int d = delays_[i].low; d <= delays_[i].low + delays_[i].pending; ++d) most = std::max(most, evidence[i][d]);
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    const LoopDelay& delay = delays_[i];
    double mean = 0.0;
    for (int d = delay.low; d <= delay.low + delay.pending; ++d)
      mean += std::exp(std::max(evidence[i][d] - most, -kFar)) / (delay.pending + 1);
    total += probability[i] = s.probability[i] * std::pow(mean, weight);
  }
  if (!(total > 0.0)) return likeliest;
  for (std::size_t i = 0; i < delays_.size(); ++i) {
    s.probability[i] = std::max(probability[i] / total, delays_[i].least);
    if (s.probability[i] > s.probability[likeliest]) likeliest = static_cast<int>(i);
  }
  return likeliest;
}

}  // namespace enamel
