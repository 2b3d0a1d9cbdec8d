// The observer's steps: the information in a rounded reading, and the same bits on all SIMD levels.
#include "render/observer_steps.hpp"

#include <cmath>
#include <cstring>

#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/skip.hpp"

namespace enamel::test_observer_steps {
namespace {

// Mean and variance of x after a reading, and the reading's density, by the trapezoidal rule. x is N(0, P); the reading
// is x + u + g with u uniform over `largest` and g Gaussian with the rest of the variance.
struct Posterior {
  double mean, variance, density;
};
Posterior posteriorOf(double reading, double P, double variance, double largest) {
  const double rest = std::sqrt(std::max(0.0, variance - largest * largest / 12.0)), d = std::sqrt(P);
  const auto distribution = [](double t) { return 0.5 * std::erfc(-t / M_SQRT2); };
  double sum = 0.0, first = 0.0, second = 0.0;
  constexpr int kSteps = 200000;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = 16.0 * d * (2.0 * i / kSteps - 1.0), from = reading - x - 0.5 * largest, to = from + largest;
    const double noise = rest > 0.0 ? (distribution(to / rest) - distribution(from / rest)) / largest
                                    : (from <= 0.0 && to >= 0.0 ? 1.0 / largest : 0.0);
    const double density = std::exp(-0.5 * x * x / P) / std::sqrt(2.0 * M_PI * P) * noise;
    sum += density;
    first += density * x;
    second += density * x * x;
  }
  const double mean = first / sum;
  return {mean, second / sum - mean * mean, sum * 32.0 * d / kSteps};
}

void fill(test::Random& random, double* begin, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) begin[i] = random.uniform(0.1, 1.0);
}

}  // namespace

TEST_CASE("a rounded reading leaves the moments of the cut Gaussian, and has its likelihood", "[observer_steps]") {
  for (const double share : {0.0025, 0.2, 0.7, 1.0})  // part of the variance due to the largest step
    for (const double P : {0.03, 0.5, 4.0, 60.0})
      for (const double innovation : {0.0, 0.4, -1.5, 3.0, 6.0}) {
        const double variance = 1.0, largest = std::sqrt(12.0 * share);
        INFO("share " << share << ", expected variance " << P << ", innovation " << innovation);
        const Posterior wanted = posteriorOf(innovation, P, variance, largest);
        if (!(wanted.density > 1e-12)) continue;  // impossible reading
        Lane e, expected, all, precision, step;
        e.fill(innovation);
        expected.fill(P);
        all.fill(variance);
        precision.fill(1.0 / std::sqrt(variance));
        step.fill(largest);
        Evidence seen;
        kRigidSteps.weigh(e, expected, all, precision, step, seen);
        const double gain = P / seen.variance[3];
        CHECK(gain * seen.innovation[3] == Approx(wanted.mean).epsilon(2e-3).margin(2e-3 * std::sqrt(P)));
        CHECK(P - gain * P == Approx(wanted.variance).epsilon(5e-3));
        CHECK(std::exp(-0.5 * seen.square[3]) / seen.volume[3] ==
              Approx(wanted.density * std::sqrt(2.0 * M_PI * variance)).epsilon(2e-3));
      }
}

#if defined(__x86_64__)
struct Innovation {
  Lane difference, variance;
};

TEST_CASE("the observer's steps give the same bits with AVX2", "[observer_steps]") {
  if (!__builtin_cpu_supports("avx2")) return test::skipTest("the processor has no AVX2");
  using Observer = PushObserver<4>;
  test::Random random(5);
  Observer::Model model;
  fill(random, model.value[0], sizeof model.value / sizeof(double));
  fill(random, model.slope[0], sizeof model.slope / sizeof(double));
  fill(random, model.byCable[0], sizeof model.byCable / sizeof(double));
  model.lagKept = 0.3;
  model.growthKept = 0.9;
  model.growthSum = 1e-3;
  ModeData data{1e-3, 1, 1, {}, 0.3, 20.0, 0.15};
  data.drive.rotorInertia = 0.2;
  Observer::State begin;
  fill(random, begin.part[0].x[0], sizeof begin / sizeof(double));
  begin.age = Lane{};
  for (int i = 0; i < Observer::kStates; ++i)
    for (double& variance : begin.P[Observer::at(i, i)]) variance = 10.0;  // positive definite
  begin.modes = 6.0;
  begin.count = 3.0;  // an old one, two that end
  begin.delays = 2.0;
  begin.age[1] = begin.age[2] = 1.0;
  Observer::States row;
  fill(random, row[0], sizeof row / sizeof(double));
  Lane command, variance, reading;
  fill(random, command.data(), command.size());
  fill(random, reading.data(), reading.size());
  variance.fill(0.3);
  const auto run = [&](const ObserverSteps<4>& steps, Observer::State& s, Innovation& seen) {
    s = begin;
    steps.predict(data, model, command, variance, s);
    steps.innovation(2, reading, s, seen.difference, seen.variance);
    steps.correct(data, model, 2, reading, s);
    steps.merge(s);
    steps.carry(model, command, reading, 0.1, s.mean);
    steps.shift(data.drive, 3.0, 2e-4, s);
    steps.advanceSensitivity(model, command, s.mean, s.byCable);
    steps.pullBack(model, s.part[0].x);
    return steps.moments(s, row);
  };
  Observer::State wanted, found;
  Innovation seen, alike;
  const Observer::Moments moments = run(kCableSteps, wanted, seen), same = run(kCableStepsAvx2, found, alike);
  CHECK(std::isfinite(seen.difference[0] + seen.variance[0]));
  CHECK((seen.difference == alike.difference && seen.variance == alike.variance));
  CHECK(std::isfinite(moments.mean));
  CHECK(std::memcmp(&wanted, &found, sizeof wanted) == 0);
  CHECK((same.mean == moments.mean && same.deviation == moments.deviation));
}
#endif

}  // namespace enamel::test_observer_steps
