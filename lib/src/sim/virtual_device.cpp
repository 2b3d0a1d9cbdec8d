#include "enamel/sim/virtual_device.hpp"

#include <algorithm>
#include <cmath>

#include "core/assert.hpp"

namespace enamel {

Encoders::Encoders(const EncoderOptions& options, double counts, double period) noexcept
    : options_(options),
      count_(2.0 * M_PI / counts),
      period_(period),
      gain_(options.rates == RateSource::lowPass ? -std::expm1(-2.0 * M_PI * options.cutoff * period) : 1.0) {}

Measurement Encoders::measure(const Vec6& q, const Vec6& rates) noexcept {
  Measurement m{q, rates};
  if (options_.quantised)
    for (int i = 0; i < 6; ++i) m.q[i] = count_ * std::nearbyint(q[i] / count_);
  if (options_.rates == RateSource::exact) return m;
  if (started_) {
    const Vec6 difference = (m.q - last_) / period_;
    filtered_ += gain_ * (difference - filtered_);
  }
  started_ = true;
  last_ = m.q;
  m.rates = filtered_;
  return m;
}

Motors::Motors(const Delay& delay, const Vec6& initial) noexcept : delay_(delay), initial_(initial) {
  ENAMEL_ASSERT(delay.low >= 0 && delay.low <= delay.high && delay.high <= kMaxDelay);
  commands_.fill(initial);
}

Vec6 Motors::actuate(std::uint64_t tick, const Vec6& command, const RandomStream& random) noexcept {
  commands_[tick % commands_.size()] = command;
  int delay = delay_.low;
  if (delay_.high > delay_.low) {
    const int choices = delay_.high - delay_.low + 1;
    delay += std::min(choices - 1, static_cast<int>(choices * random.uniform(RandomStream::Purpose::delay, tick)));
  }
  return static_cast<std::uint64_t>(delay) > tick ? initial_ : commands_[(tick - delay) % commands_.size()];
}

}  // namespace enamel
