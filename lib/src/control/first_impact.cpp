#include "enamel/control/first_impact.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {
namespace {

// s after the onset: time that does not count, and least time that must count.
constexpr double kSettling = 0.5, kJudged = 0.25;
constexpr double kRinging = 0.25, kReturned = 0.1, kFlight = 0.1;  // of D_z1
constexpr double kBlock = 0.125;                                   // s
constexpr double kGrows = 10.0, kChatters = 0.25;                  // of the first block's deviation; of a motor's limit

std::uint64_t ticksIn(double time, double period) noexcept {
  return static_cast<std::uint64_t>(std::llround(time / period));
}

// Lowest gap between two ticks, from the cubic that the values and rates at both ends determine.
double lowestGap(double gap, double rate, double nextGap, double nextRate, double period) noexcept {
  if (!(rate < 0.0 && nextRate >= 0.0)) return std::fmin(gap, nextGap);
  // The cubic's slope for s in [0, 1] is a s^2 + b s + c: negative at 0, not negative at 1, and with one root between.
  const double before = rate * period, after = nextRate * period, way = nextGap - gap;
  const double a = 3.0 * (before + after) - 6.0 * way, b = 6.0 * way - 4.0 * before - 2.0 * after, c = before;
  const double root = std::sqrt(std::fmax(0.0, b * b - 4.0 * a * c));
  const double s = b >= 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a);
  return gap + s * (c + s * (0.5 * b + s * a / 3.0));
}

}  // namespace

bool FirstImpact::add(double gap, double rate, double nextGap, double nextRate, double period) noexcept {
  if (returned_ || !(rate < 0.0 && nextRate >= 0.0)) return false;
  const double lowest = lowestGap(gap, rate, nextGap, nextRate, period);
  if (!(lowest < rest_)) return false;
  depth_ = rest_ - lowest;
  returned_ = true;
  return true;
}

const char* toString(FirstImpactVerdict verdict) noexcept {
  switch (verdict) {
    case FirstImpactVerdict::measured: return "measured";
    case FirstImpactVerdict::noStep: return "no step of force";
    case FirstImpactVerdict::noReturn: return "never returned";
    case FirstImpactVerdict::rings: return "rings";
    case FirstImpactVerdict::slips: return "slipped";
    case FirstImpactVerdict::unstable: return "unstable";
    case FirstImpactVerdict::flies: return "began off the wall";
  }
  return "unknown verdict";
}

void ImpactMonitor::rest(const ImpactTick& tick) noexcept {
  restDepth_ -= tick.gap;
  restForce_ += tick.force;
  lowestAtRest_ = std::fmin(lowestAtRest_, tick.gap);
  ++restTicks_;
}

void ImpactMonitor::push(const ImpactTick& tick) noexcept {
  if (ticks_ == 0) {
    rest_ = -(restDepth_ - tick.gap) / (restTicks_ + 1);
    unrest_ = std::fmax(0.0, rest_ - std::fmin(lowestAtRest_, tick.gap));
  }
  bounce_ = std::fmax(bounce_, tick.gap - rest_);
  if (ticks_ > 0 && ticks_ <= ticksIn(kDepthWindow, period_))
    deepest_ = std::fmax(deepest_, rest_ - lowestGap(last_.gap, last_.rate, tick.gap, tick.rate, period_));
  FirstImpact turn(rest_);
  if (ticks_ > 0 && !over_ && turn.add(last_.gap, last_.rate, tick.gap, tick.rate, period_) &&
      turn.depth() > std::fmax(depth_, unrest_)) {
    depth_ = turn.depth();
    force_ = last_.force - preload();
    slipped_ = tick.drift > depth_;
  }
  over_ =
      depth_ > 0.0 && (over_ || rest_ - tick.gap < (1.0 - kReturned) * depth_ || ticks_ >= ticksIn(kSettling, period_));
  last_ = tick;
  if (ticks_ >= ticksIn(kSettling, period_)) {
    lateSum_ -= tick.gap;
    lateSquares_ += tick.gap * tick.gap;
    lateSaturated_ += tick.saturated;
    ++lateTicks_;
    block_.add(tick);
    if (block_.ticks >= ticksIn(kBlock, period_)) {
      if (firstBlock_.ticks == 0) firstBlock_ = block_;
      lastBlock_ = block_;
      block_ = Block{};
    }
  }
  ++ticks_;
}

void ImpactMonitor::Block::add(const ImpactTick& tick) noexcept {
  ++ticks;
  sum -= tick.gap;
  squares += tick.gap * tick.gap;
  for (int i = 0; i < tick.torque.size(); ++i) {
    torque[i] += tick.torque[i];
    torqueSquares[i] += tick.torque[i] * tick.torque[i];
  }
}

double ImpactMonitor::Block::deviation() const noexcept {
  const double count = static_cast<double>(std::max<std::uint64_t>(ticks, 1)), mean = sum / count;
  return std::sqrt(std::fmax(0.0, squares / count - mean * mean));
}

double ImpactMonitor::Block::chatter() const noexcept {
  const double count = static_cast<double>(std::max<std::uint64_t>(ticks, 1));
  double largest = 0.0;
  for (int i = 0; i < kMaxJoints; ++i) {
    const double mean = torque[i] / count;
    largest = std::fmax(largest, torqueSquares[i] / count - mean * mean);
  }
  return std::sqrt(largest);
}

bool ImpactMonitor::ringing() const noexcept {
  if (lateTicks_ < ticksIn(kJudged, period_)) return false;
  const double count = static_cast<double>(lateTicks_), mean = lateSum_ / count;
  return std::sqrt(std::fmax(0.0, lateSquares_ / count - mean * mean)) > kRinging * depth_;
}

bool ImpactMonitor::unstable() const noexcept {
  if (lateTicks_ < ticksIn(kJudged, period_)) return false;
  return 2 * lateSaturated_ > lateTicks_ || lastBlock_.chatter() > kChatters;
}

FirstImpactVerdict ImpactMonitor::verdict() const noexcept {
  const bool grows = ringing() && depth_ > 0.0 && lastBlock_.deviation() > kGrows * firstBlock_.deviation();
  if (unstable() || grows) return FirstImpactVerdict::unstable;
  if (depth_ == 0.0) return FirstImpactVerdict::noReturn;
  if (ringing()) return FirstImpactVerdict::rings;
  if (slipped_) return FirstImpactVerdict::slips;
  return rest_ > kFlight * depth_ ? FirstImpactVerdict::flies : FirstImpactVerdict::measured;
}

}  // namespace enamel
