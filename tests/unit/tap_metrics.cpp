// Metrics of a tap against analytic taps.
#include "enamel/study/tap_metrics.hpp"

#include <cmath>
#include <functional>

#include "support/catch.hpp"

namespace enamel::test_tap_metrics {

namespace {

constexpr double kSpeed = 0.3, kPeriod = 1e-3;  // m/s, s
constexpr double kTouch = 0.0203;               // s, between two samples

// A mass that hits a surface at kTouch, sampled every `period` s. The functions get the time since the touch.
std::vector<TapSample> traceOf(double period, const std::function<double(double)>& gap,
                               const std::function<double(double)>& rate, const std::function<double(double)>& force) {
  std::vector<TapSample> trace;
  for (int i = 0; i < static_cast<int>(0.12 / period); ++i) {
    const double t = i * period - kTouch, next = t + period;
    const auto rateAt = [&](double at) { return at > 0.0 ? rate(at) : -kSpeed; };
    trace.push_back({i * period, t > 0.0 ? gap(t) : -kSpeed * t, rateAt(t), (rateAt(next) - rateAt(t)) / period,
                     t > 0.0 ? force(t) : 0.0});
  }
  return trace;
}

// The tap of a mass of 0.2 kg against a spring and a damper, until it leaves.
TapMetrics springTap(double stiffness, double damping, double period) {
  const double mass = 0.2, decay = 0.5 * damping / mass, w = std::sqrt(stiffness / mass - decay * decay);
  const auto isIn = [&](double t) { return t < M_PI / w; };
  const auto depth = [&](double t) { return isIn(t) ? kSpeed * std::exp(-decay * t) * std::sin(w * t) / w : 0.0; };
  const auto rate = [&](double t) {  // of the depth
    return isIn(t) ? kSpeed * std::exp(-decay * t) * (std::cos(w * t) - decay / w * std::sin(w * t)) : 0.0;
  };
  return tapMetrics(traceOf(
                        period, [&](double t) { return -depth(t); }, [&](double t) { return -rate(t); },
                        [&](double t) { return stiffness * depth(t) + damping * rate(t); }),
                    tapOf("enamel"));
}

// A tool whose acceleration is that of a material, times `factor`.
std::vector<TapSample> materialTap(const Tap& tap, double factor, double period) {
  const double w = 2.0 * M_PI * tap.frequency, B = tap.decay;
  const auto rate = [=](double t) {
    const double lost = 1.0 - std::exp(-B * t) * (std::cos(w * t) + B / w * std::sin(w * t));
    return -kSpeed * (1.0 - factor * lost);
  };
  const auto gap = [](double t) { return -kSpeed * t; };  // only its zero and its sign count here
  return traceOf(period, gap, rate, [](double) { return 1.0; });
}

}  // namespace

TEST_CASE("taps: a spring has its stiffness in each metric", "[tap]") {
  for (const double stiffness : {2e3, 2e4, 2e5}) {
    const TapMetrics coarse = springTap(stiffness, 0.0, kPeriod), fine = springTap(stiffness, 0.0, 2e-5);
    CHECK(fine.speed == Approx(kSpeed).epsilon(1e-12));
    CHECK(coarse.dynamicStiffness == Approx(stiffness).epsilon(1e-12));
    CHECK(fine.dynamicStiffness == Approx(stiffness).epsilon(1e-12));
    // The force is k v sin(w t) / w. It counts from 1 % of its maximum on, at w t = 0.01. Within the next two samples
    // of 20 us its rate has fallen by (w t)^2 / 2 at most.
    const double falls = 0.5 * std::pow(0.01 + std::sqrt(stiffness / 0.2) * 4e-5, 2);
    CHECK(fine.rateHardness == Approx(stiffness).epsilon(falls + 1e-9));
    CHECK(fine.extendedRateHardness == Approx(stiffness).epsilon(falls + 1e-9));
    CHECK(fine.rateHardness <= stiffness);
  }
}

TEST_CASE("taps: a damper adds to the dynamic stiffness and to the extended rate-hardness", "[tap]") {
  const double stiffness = 2e4, damping = 20.0;
  const TapMetrics spring = springTap(stiffness, 0.0, 2e-5), damped = springTap(stiffness, damping, 2e-5);
  // |k + i w b| at 250 and 350 Hz
  CHECK(damped.dynamicStiffness > 0.98 * std::hypot(stiffness, 2.0 * M_PI * 250.0 * damping));
  CHECK(damped.dynamicStiffness < 1.02 * std::hypot(stiffness, 2.0 * M_PI * 350.0 * damping));
  // The force jumps to b v at the touch: over a sample of 20 us this is the largest rate.
  CHECK(damped.extendedRateHardness == Approx(stiffness + damping / 2e-5).epsilon(0.02));
  CHECK(damped.rateHardness > 10.0 * spring.rateHardness);
}

TEST_CASE("taps: an early force counts from the last sample without it", "[tap]") {
  std::vector<TapSample> trace = materialTap(tapOf("metal"), 1.0, kPeriod);
  for (TapSample& s : trace) s.force = s.time < 0.019 - 1e-9 ? 0.0 : s.time < 0.02 - 1e-9 ? 2.0 : 6.0;
  const TapMetrics m = tapMetrics(trace, tapOf("metal"));
  CHECK(m.rateHardness == Approx(6.0 / (2.0 * kPeriod) / kSpeed));
  CHECK(m.extendedRateHardness == Approx(4.0 / kPeriod / kSpeed));
}

TEST_CASE("taps: the tap of a material matches itself, and others less", "[tap]") {
  for (const NamedTap& known : kNamedTaps) {
    INFO(known.name);
    for (const double period : {kPeriod, 1e-4}) {
      CHECK(tapMetrics(materialTap(known.tap, 1.0, period), known.tap).match == Approx(1.0).epsilon(1e-9));
      for (const double factor : {0.25, 2.0})
        CHECK(tapMetrics(materialTap(known.tap, factor, period), known.tap).match ==
              Approx(2.0 * factor / (1.0 + factor * factor)).epsilon(1e-9));
    }
    Tap lower = known.tap, longer = known.tap;
    lower.frequency *= 0.7;
    longer.decay *= 0.3;
    CHECK(tapMetrics(materialTap(lower, 1.0, kPeriod), known.tap).match < 0.9);
    CHECK(tapMetrics(materialTap(longer, 1.0, kPeriod), known.tap).match < 0.9);
  }
}

TEST_CASE("taps: the acceleration of a material is a decaying sinusoid that stops the tool", "[tap]") {
  for (const NamedTap& known : kNamedTaps) {
    const double w = 2.0 * M_PI * known.tap.frequency, B = known.tap.decay;
    CHECK(accelerationOf(known.tap, -1.0, 0.0) == 0.0);
    CHECK(accelerationOf(known.tap, 0.0, 1.0) == Approx(1.0).epsilon(1e-12));
    for (const double t : {3e-4, 1e-3, 7e-3})  // the mean over 2 us differs by its curvature, below 1e-5 of the peak
      CHECK(accelerationOf(known.tap, t - 1e-6, t + 1e-6) ==
            Approx((B * B + w * w) / w * std::exp(-B * t) * std::sin(w * t)).margin(1e-5 * w));
  }
  CHECK_THROWS_WITH(tapOf("wood"), test::ContainsSubstring(
                                       "is \"wood\", must be one of \"enamel\", \"dentine\", \"metal\", \"plastic\""));
}

TEST_CASE("taps: a trace without a touch has no metrics", "[tap]") {
  std::vector<TapSample> trace = materialTap(tapOf("metal"), 1.0, kPeriod);
  CHECK(std::isnan(tapMetrics({}, tapOf("metal")).match));
  CHECK(std::isnan(tapMetrics({trace.begin(), trace.begin() + 20}, tapOf("metal")).speed));
  CHECK(std::isnan(tapMetrics({trace.begin() + 30, trace.end()}, tapOf("metal")).rateHardness));
}

}  // namespace enamel::test_tap_metrics
