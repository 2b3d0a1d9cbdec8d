#include "enamel/study/tap_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace enamel {
namespace {

constexpr double kTapBefore = 5e-3, kTapAfter = 0.06;  // s: window around the touch
constexpr double kRiseTime = 0.03;                     // s after the touch
constexpr double kTapForce = 0.01;                     // share of the largest force: smaller ones do not count
constexpr double kBandFrom = 20.0, kBandTo = 1000.0, kBandStep = 5.0;  // Hz
constexpr double kStiffFrom = 250.0, kStiffTo = 350.0;                 // Hz
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

double amplitudeOf(const std::vector<double>& signal, double period, double frequency) {
  const std::complex<double> turn = std::polar(1.0, -2.0 * M_PI * frequency * period);
  std::complex<double> sum = 0.0;
  for (auto value = signal.rbegin(); value != signal.rend(); ++value) sum = sum * turn + *value;
  return std::abs(sum) * period;
}

}  // namespace

double accelerationOf(const Tap& material, double from, double until) noexcept {
  const double w = 2.0 * M_PI * material.frequency, B = material.decay;
  // Speed that the tool has lost: 1 - exp(-B t) (cos w t + B / w sin w t).
  const auto lost = [&](double t) {
    return t <= 0.0 ? 0.0 : 1.0 - std::exp(-B * t) * (std::cos(w * t) + B / w * std::sin(w * t));
  };
  return (lost(until) - lost(from)) / (until - from);
}

double matchOf(const std::vector<double>& signal, const std::vector<double>& other, double period) {
  double product = 0.0, squares = 0.0;
  for (double f = kBandFrom; f <= std::min(kBandTo, 0.5 / period); f += kBandStep) {
    const double a = amplitudeOf(signal, period, f), b = amplitudeOf(other, period, f);
    product += a * b;
    squares += a * a + b * b;
  }
  return squares > 0.0 ? 2.0 * product / squares : kMissing;
}

TapMetrics tapMetrics(const std::vector<TapSample>& trace, const Tap& material) {
  TapMetrics metrics{kMissing, kMissing, kMissing, kMissing, kMissing};
  const auto inside = std::find_if(trace.begin(), trace.end(), [](const TapSample& s) { return s.gap < 0.0; });
  if (inside == trace.begin() || inside == trace.end()) return metrics;
  const TapSample& outside = *(inside - 1);
  const double touch = outside.time + outside.gap / (outside.gap - inside->gap) * (inside->time - outside.time);
  const auto first = std::find_if(trace.begin(), trace.end(),
                                  [&](const TapSample&s) { return s.time >= touch - kTapBefore; }),
             last = std::find_if(first, trace.end(), [&](const TapSample&s) { return s.time > touch + kTapAfter; });
  if (last - first < 3) return metrics;
  const double period = (std::prev(last)->time - first->time) / static_cast<double>(last - first - 1);

  double most = 0.0;
  for (auto s = first; s != last; ++s) most = std::max(most, s->force);
  const auto begins = std::find_if(first, last, [&](const TapSample& s) { return s.force > kTapForce * most; });
  const auto before = begins != last && begins < inside ? begins : inside - 1;
  metrics.speed = -before->rate;
  if (most > 0.0 && begins != first && last - begins > 1) {
    // A force that follows the touch begins at the touch; an early one begins after the last sample without it.
    const double start = begins->time < touch ? (begins - 1)->time : std::max(touch, (begins - 1)->time);
    metrics.rateHardness = ((begins + 1)->force - (begins - 1)->force) / ((begins + 1)->time - start) / metrics.speed;
    double steepest = 0.0;
    for (auto s = first + 1; s != last && s->time < touch + kRiseTime; ++s)
      steepest = std::max(steepest, (s->force - (s - 1)->force) / (s->time - (s - 1)->time));
    metrics.extendedRateHardness = steepest / metrics.speed;
  }

  std::vector<double> force, depth, handle, model;
  for (auto s = first; s != last; ++s) {
    force.push_back(s->force);
    depth.push_back(std::max(0.0, -s->gap));
    handle.push_back(s->acceleration);
    model.push_back(metrics.speed * accelerationOf(material, s->time - touch, s->time - touch + period));
  }
  double forces = 0.0, depths = 0.0;
  for (double f = kStiffFrom; f <= kStiffTo; f += kBandStep) {
    forces += std::pow(amplitudeOf(force, period, f), 2);
    depths += std::pow(amplitudeOf(depth, period, f), 2);
  }
  metrics.dynamicStiffness = std::sqrt(forces / depths);
  metrics.match = matchOf(handle, model, period);
  return metrics;
}

}  // namespace enamel
