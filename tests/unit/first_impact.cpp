// The first impact of a push: its depth between ticks, and the reasons for its absence.
#include "enamel/control/first_impact.hpp"

#include <cmath>

#include "support/catch.hpp"

namespace enamel::test_first_impact {

namespace {

constexpr double kPeriod = 1e-3;
constexpr double kForce = 12.0, kPreload = 0.5, kRest = -1e-4;  // N, N, m

// A mass on a spring and a damper with a step of force: gap = rest - (F / k) (1 - e^{-d t} (cos w t + d / w sin w t)).
struct Oscillator {
  double omega, decay;  // rad/s, 1/s
  double depth = 1e-3;  // F / k, m
  double drift = 0.0;   // m

  ImpactTick at(double time) const {
    const double fading = std::exp(-decay * time), c = std::cos(omega * time), s = std::sin(omega * time);
    return {kRest - depth * (1.0 - fading * (c + decay / omega * s)),
            -depth * fading * (omega + decay * decay / omega) * s, kPreload + kForce, drift, false};
  }
};

template <typename Motion>
ImpactMonitor watch(const Motion& motion, int ticks) {
  ImpactMonitor impact(kPeriod);
  for (int i = 0; i < 100; ++i) impact.rest({kRest, 0.0, kPreload, 0.0, false});
  for (int i = 0; i < ticks; ++i) impact.push(motion(kPeriod * i));
  return impact;
}

ImpactMonitor watch(const Oscillator& oscillator, int ticks) {
  return watch([&](double time) { return oscillator.at(time); }, ticks);
}

}  // namespace

TEST_CASE("the deepest point lies between ticks, and counts from the rest; the force counts from the preload",
          "[first_impact]") {
  for (const double omega : {150.0, 700.0}) {  // turns after 21 and after 4.5 ticks
    const Oscillator oscillator{omega, 30.0};
    const ImpactMonitor impact = watch(oscillator, 750);
    REQUIRE(impact.verdict() == FirstImpactVerdict::measured);
    const double exact = oscillator.depth * (1.0 + std::exp(-oscillator.decay * M_PI / omega));
    double atTicks = 0.0;
    for (int i = 0; i < 50; ++i) atTicks = std::fmax(atTicks, kRest - oscillator.at(kPeriod * i).gap);
    // The cubic's error is below (w Ts)^4 / 384 of the amplitude: 6e-4 of it at 700 rad/s.
    CHECK(std::abs(impact.depth() - exact) < 1e-3 * exact);
    if (omega > 500.0) CHECK(exact - atTicks > 5e-3 * exact);  // the depth at ticks is smaller
    CHECK(impact.force() == Approx(kForce));
    CHECK(impact.preload() == Approx(kPreload));
    CHECK(impact.stiffness() == Approx(kForce / exact).epsilon(1e-3));
    CHECK(impact.deepest() == impact.depth());
  }
}

TEST_CASE("the deepest point counts for a tenth of a second, also where nothing returns", "[first_impact]") {
  const auto sinking = [](double time) {
    return ImpactTick{kRest - 0.02 * time, -0.02, kPreload + kForce, 0.0, false};
  };
  CHECK(watch(sinking, 50).deepest() == Approx(0.02 * 0.049));
  CHECK(watch(sinking, 400).deepest() == Approx(0.02 * 0.1));
  CHECK(watch(sinking, 400).verdict() == FirstImpactVerdict::noReturn);
  // Turns at 12.5 and 62.5 ms: the second, deeper one counts; a third one at 112.5 ms does not.
  const auto deeper = [](double time) {
    const double w = 2.0 * M_PI / 0.05, size = 1e-3 * (1.0 + 10.0 * time), c = 1e-3 * 10.0;
    return ImpactTick{kRest - size * std::sin(w * time), -c * std::sin(w * time) - size * w * std::cos(w * time),
                      kPreload + kForce, 0.0, false};
  };
  CHECK(watch(deeper, 400).deepest() == Approx(1.625e-3).epsilon(2e-3));
  CHECK(watch([](double) { return ImpactTick{0.0, 0.0, kPreload + kForce, 0.0, false}; }, 400).deepest() == 0.0);
}

TEST_CASE("a law that turns within two ticks is as deep as it was between them", "[first_impact]") {
  // Both ticks are at rest level with opposite speeds: the parabola between them is v Ts / 4 deep.
  FirstImpact impact(0.0);
  REQUIRE(impact.add(0.0, -0.4, 0.0, 0.4, kPeriod));
  CHECK(impact.depth() == Approx(1e-4));
  CHECK_FALSE(impact.add(0.0, -0.8, 0.0, 0.8, kPeriod));  // only the first one counts
  CHECK(impact.depth() == Approx(1e-4));
}

TEST_CASE("a halt on the way in is no return, and a turn after the return does not count", "[first_impact]") {
  // Depths in mm at the turns, connected by cosines of 10 ticks each: 0 1 d 3 e.
  const auto staircase = [](double halt, double last) {
    return [halt, last](double time) {
      const double turns[] = {0.0, 1.0, halt, 3.0, 0.0, last, 0.0, 0.0};
      const double phase = std::fmin(6.9, time / 0.01);
      const int i = static_cast<int>(phase);
      const double s = M_PI * (phase - i), step = 1e-3 * (turns[i + 1] - turns[i]);
      return ImpactTick{kRest - 1e-3 * turns[i] - 0.5 * step * (1.0 - std::cos(s)),
                        -0.5 * step * std::sin(s) * M_PI / 0.01, kPreload + kForce, 0.0, false};
    };
  };
  CHECK(watch(staircase(0.95, 2.0), 750).depth() == Approx(3e-3).epsilon(1e-3));
  CHECK(watch(staircase(0.85, 2.0), 750).depth() == Approx(1e-3).epsilon(1e-3));
  CHECK(watch(staircase(0.95, 9.0), 750).depth() == Approx(3e-3).epsilon(1e-3));
}

TEST_CASE("no stiffness: never returned, rings, slipped", "[first_impact]") {
  const auto creeping = [](double time) { return ImpactTick{kRest - 0.01 * time, -0.01, kForce, 0.0, false}; };
  CHECK(watch(creeping, 2000).verdict() == FirstImpactVerdict::noReturn);

  const Oscillator ringing{150.0, 0.0};                                  // its depth swings by 0.7 F / k
  CHECK(watch(ringing, 700).verdict() == FirstImpactVerdict::measured);  // too short for a verdict
  CHECK(watch(ringing, 750).verdict() == FirstImpactVerdict::rings);
  const auto saturated = [](double time) {
    ImpactTick tick = Oscillator{150.0, 30.0}.at(time);
    tick.saturated = time > 0.6;
    return tick;
  };
  CHECK(watch(saturated, 750).verdict() == FirstImpactVerdict::unstable);

  Oscillator slipping{150.0, 30.0};
  slipping.drift = 1.4e-3;  // below the first impact's 1.53e-3
  CHECK(watch(slipping, 750).verdict() == FirstImpactVerdict::measured);
  slipping.drift = 1.6e-3;
  CHECK(watch(slipping, 750).verdict() == FirstImpactVerdict::slips);
}

TEST_CASE("a push that begins off the wall by more than a tenth of its depth has no stiffness", "[first_impact]") {
  const Oscillator oscillator{150.0, 30.0};
  for (const double gap : {0.5e-4, 3e-4}) {
    ImpactMonitor impact(kPeriod);
    for (int i = 0; i < 100; ++i) impact.rest({gap, 0.0, 0.0, 0.0, false});
    for (int i = 0; i < 750; ++i) {
      ImpactTick tick = oscillator.at(kPeriod * i);
      tick.gap += gap - kRest;
      impact.push(tick);
    }
    REQUIRE(impact.depth() > 1e-3);
    CHECK(impact.verdict() == (gap < 0.1 * impact.depth() ? FirstImpactVerdict::measured : FirstImpactVerdict::flies));
    CHECK(impact.deepest() > 0.0);
  }
}

}  // namespace enamel::test_first_impact
