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
        Lane e, expected, all, step;
        e.fill(innovation);
        expected.fill(P);
        all.fill(variance);
        step.fill(largest);
        Evidence seen;
        kRigidSteps.weigh(e.data(), expected.data(), all.data(), step.data(), seen);
        const double gain = P / seen.variance[3];
        CHECK(gain * seen.innovation[3] == Approx(wanted.mean).epsilon(2e-3).margin(2e-3 * std::sqrt(P)));
        CHECK(P - gain * P == Approx(wanted.variance).epsilon(5e-3));
        CHECK(std::exp(-0.5 * seen.square[3]) / seen.volume[3] ==
              Approx(wanted.density * std::sqrt(2.0 * M_PI * variance)).epsilon(2e-3));
      }
}

#if defined(__x86_64__)
TEST_CASE("the observer's steps give the same bits with AVX2", "[observer_steps]") {
  if (!__builtin_cpu_supports("avx2")) return test::skipTest("the processor has no AVX2");
  using Observer = PushObserver<4>;
  test::Random random(5);
  Observer::Model model;
  fill(random, model.value[0], sizeof model.value / sizeof(double));
  fill(random, model.slope[0], sizeof model.slope / sizeof(double));
  model.lagKept = 0.3;
  model.growthKept = 0.9;
  model.growthSum = 1e-3;
  Observer::States x[2], column[2], gain[2];
  Observer::Pairs P[2], Q;
  Lane command, matters, variance, step;
  fill(random, x[0][0], sizeof x[0] / sizeof(double));
  fill(random, P[0][0], sizeof P[0] / sizeof(double));
  fill(random, Q[0], sizeof Q / sizeof(double));
  for (Lane* lane : {&command, &matters, &variance, &step}) fill(random, lane->data(), lane->size());
  std::memcpy(x[1], x[0], sizeof x[0]);
  std::memcpy(P[1], P[0], sizeof P[0]);
  Evidence seen[2];
  const ObserverSteps<4>* levels[] = {&kCableSteps, &kCableStepsAvx2};
  for (int i = 0; i < 2; ++i) {
    levels[i]->predict(model, command.data(), matters.data(), 0.1, Q, x[i], P[i]);
    levels[i]->carry(model, command.data(), matters.data(), 0.1, x[i]);
    levels[i]->weigh(command.data(), variance.data(), variance.data(), step.data(), seen[i]);
    levels[i]->correct(variance.data(), 2, P[i], column[i], gain[i]);
    levels[i]->gather(x[i], gain[i], variance, column[i], 0.3, P[i]);
  }
  CHECK(std::memcmp(x[0], x[1], sizeof x[0]) == 0);
  CHECK(std::memcmp(P[0], P[1], sizeof P[0]) == 0);
  CHECK(std::memcmp(&seen[0], &seen[1], sizeof seen[0]) == 0);
  CHECK(std::memcmp(gain[0], gain[1], sizeof gain[0]) == 0);
}
#endif

}  // namespace enamel::test_observer_steps
