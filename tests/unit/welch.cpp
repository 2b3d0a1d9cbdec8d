// Welch's test compared with tables and by simulation.
#include "enamel/study/welch.hpp"

#include <cmath>
#include <random>

#include "support/catch.hpp"

namespace enamel::test_welch {

TEST_CASE("Student's distribution: tables and closed forms") {
  // Two-sided 5 % points (Fisher and Yates), to the table's three decimals: d p / d t is about 0.05 there.
  for (const auto& [freedom, t] : {std::pair{1.0, 12.706}, {2.0, 4.303}, {10.0, 2.228}, {30.0, 2.042}, {120.0, 1.980}})
    CHECK(studentBeyond(t, freedom) == Approx(0.05).margin(6e-5));
  // One and two degrees of freedom have closed forms, also for extreme values; a million are equivalent to a normal
  // distribution.
  for (const double t : {1e-6, 0.3, 1.0, 7.0, 1e3, 1e6}) {
    CHECK(studentBeyond(t, 1.0) == Approx(2.0 / M_PI * std::atan(1.0 / t)).epsilon(1e-10));
    CHECK(studentBeyond(t, 2.0) == Approx(2.0 / (2.0 + t * t) / (1.0 + t / std::sqrt(2.0 + t * t))).epsilon(1e-10));
  }
  for (const double t : {0.5, 2.0, 4.0})
    CHECK(studentBeyond(t, 1e6) == Approx(std::erfc(t / std::sqrt(2.0))).epsilon(1e-4));
  CHECK(studentBeyond(0.0, 5.0) == 1.0);
}

TEST_CASE("Welch's test: a worked example, symmetry, and as many false alarms as it says") {
  // By hand: a = {1, 2, 3, 4}, b = {2, 4, 6, 8, 10}: means 2.5 and 6, variances 5/3 and 10.
  const Spread a = spreadOf({1.0, 2.0, 3.0, 4.0}), b = spreadOf({2.0, 4.0, 6.0, 8.0, 10.0});
  const WelchTest test = welchTest(a, b), back = welchTest(b, a);
  CHECK(test.t == Approx(-3.5 / std::sqrt(5.0 / 12.0 + 2.0)));
  CHECK(test.freedom == Approx(std::pow(5.0 / 12.0 + 2.0, 2) / (std::pow(5.0 / 12.0, 2) / 3.0 + 1.0)));
  CHECK(test.effect == Approx(-3.5 / std::sqrt(0.5 * (5.0 / 3.0 + 10.0))));
  CHECK(back.t == -test.t);
  CHECK(back.p == test.p);
  CHECK(std::isnan(welchTest(spreadOf({1.0}), b).p));
  CHECK(std::isnan(welchTest(spreadOf({1.0, 1.0}), spreadOf({2.0, 2.0})).t));

  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  int alarms = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> x, y;
    for (int i = 0; i < 12; ++i) x.push_back(normal(engine));
    for (int i = 0; i < 20; ++i) y.push_back(3.0 * normal(engine));
    alarms += welchTest(spreadOf(x), spreadOf(y)).p < 0.05;
  }
  CHECK(alarms == Approx(0.05 * kTrials).margin(4.0 * std::sqrt(0.05 * 0.95 * kTrials)));  // four standard deviations
}

}  // namespace enamel::test_welch
