// Paired comparisons: tables, examples by hand, and as many false findings as they say.
#include "enamel/study/paired.hpp"

#include <cmath>
#include <random>

#include "support/catch.hpp"

namespace enamel::test_paired {

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
  for (const double p : {1e-6, 0.01, 0.05, 0.5})
    for (const double freedom : {1.0, 2.7, 19.0, 1e4})
      CHECK(studentBeyond(studentQuantile(p, freedom), freedom) == Approx(p).epsilon(1e-9));
}

TEST_CASE("Holm's adjustment of an example by hand") {
  const double none = std::nan("");
  const std::vector<double> adjusted = holm({0.04, 0.01, none, 0.03, 0.005});
  const std::vector<double> expected{0.06, 0.03, none, 0.06, 0.02};  // 4 * 0.005, 3 * 0.01, 2 * 0.03, max(0.06, 0.04)
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO(i);
    if (std::isnan(expected[i]))
      CHECK(std::isnan(adjusted[i]));
    else
      CHECK(adjusted[i] == Approx(expected[i]));
  }
  CHECK(holm({0.9, 0.8}) == std::vector<double>{1.0, 1.0});
}

TEST_CASE("means of differences: examples by hand, and intervals that cover as often as they say") {
  const MeanDifference one = meanDifference(spreadOf({1.0, 2.0, 3.0, 4.0}));  // mean 2.5, variance 5/3
  CHECK(one.half == Approx(3.18245 * std::sqrt(5.0 / 12.0)).epsilon(1e-5));
  CHECK(one.p == Approx(studentBeyond(2.5 / std::sqrt(5.0 / 12.0), 3.0)));
  CHECK(one.effect == Approx(2.5 / std::sqrt(5.0 / 3.0)));
  CHECK(std::isnan(meanDifference(spreadOf({1.0})).half));
  CHECK(meanDifference(spreadOf({1.0, 1.0})).p == 0.0);
  CHECK(meanDifference(spreadOf({0.0, 0.0})).p == 1.0);
  const MeanDifference two = meanOfStrata({spreadOf({1.0, 2.0, 3.0, 4.0}), spreadOf({7.0}), spreadOf({0.0, 2.0})});
  CHECK(two.count == 6);
  CHECK(two.mean == Approx(1.75));
  const double error = 5.0 / 12.0 + 1.0, freedom = error * error / (25.0 / 144.0 / 3.0 + 1.0);
  CHECK(two.half == Approx(0.5 * std::sqrt(error) * studentQuantile(0.05, freedom)));
  CHECK(two.effect == Approx(1.75 / std::sqrt(0.5 * (5.0 / 3.0 + 2.0))));

  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  int missed = 0, missedStrata = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<Spread> strata;
    for (int s = 0; s < 4; ++s) {
      std::vector<double> x;
      for (int i = 0; i < 8; ++i) x.push_back(10.0 * s + (1.0 + s) * normal(engine));
      strata.push_back(spreadOf(x));
    }
    const MeanDifference first = meanDifference(strata[0]), mean = meanOfStrata(strata);
    missed += std::abs(first.mean) > first.half;
    missedStrata += std::abs(mean.mean - 15.0) > mean.half;
  }
  const double margin = 4.0 * std::sqrt(0.05 * 0.95 * kTrials);  // four standard deviations
  CHECK(missed == Approx(0.05 * kTrials).margin(margin));
  CHECK(missedStrata == Approx(0.05 * kTrials).margin(margin));  // Satterthwaite's freedom is an approximation
}

namespace {

// A study of two columns, whose results are made up.
StudyPlan planOf(int grid, int runs) {
  StudyPlan plan;
  plan.grid = grid;
  plan.runs = runs;
  plan.scenarios = {2, 1};
  plan.columns.resize(2);
  return plan;
}

// Column 0 has K_d = 1000 * random * factor, column 1 the same random number without the factor.
template <typename Factor>
std::vector<StudyResult> resultsOf(const StudyPlan& plan, unsigned seed, const Factor& factor) {
  std::vector<StudyResult> results;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    StudyResult result;
    result.run = runAt(plan, i);
    std::seed_seq shared{seed, result.run.stream}, own{seed, static_cast<unsigned>(i), 7u};
    std::mt19937_64 engine(shared), ownEngine(own);
    std::lognormal_distribution<double> wide(0.0, 2.0), narrow(0.0, 0.05);
    const double k = 1000.0 * wide(engine) * narrow(ownEngine);
    if (result.run.scenario == 1) {
      result.metrics.verdict = FirstImpactVerdict::measured;
      result.metrics.depthStiffness = result.run.column == 0 ? k * factor(result.run.point) : k;
    }
    results.push_back(result);
  }
  return results;
}

const PairedQuestion kQuestion{1, &PushMetrics::depthStiffness, true, true};

}  // namespace

TEST_CASE("pairs: a ratio is found at the points where it is, in spite of forces that vary much more") {
  const StudyPlan plan = planOf(3, 10);
  const auto results = resultsOf(plan, 1, [](std::size_t p) { return p < 4 ? 1.5 : p < 6 ? 1.0 : 0.8; });
  const auto all = comparePairs(plan, results, 0, {kQuestion, {3, &PushMetrics::depthStiffness, true, true}});
  REQUIRE(all.size() == 1);  // the plan has no scenario 3
  const PairedComparison& c = all[0];
  CHECK(c.count(PairedVerdict::better) == 4);
  CHECK(c.count(PairedVerdict::undecided) == 2);
  CHECK(c.count(PairedVerdict::worse) == 3);
  CHECK(c.wall.count == 90);
  const double truth = (4.0 * std::log(1.5) + 3.0 * std::log(0.8)) / 9.0;
  CHECK(c.wall.mean == Approx(truth).margin(2.0 * c.wall.half));  // 2 half intervals: 4 standard errors
  CHECK(c.wall.half < 0.03);                                      // unpaired, the deviation of 2 would give 0.4
  CHECK(c.verdict == PairedVerdict::better);
  CHECK(c.largerShare == Approx(50.0 / 90.0).margin(0.2));
  // The same question, seen from the other column.
  const PairedComparison back = comparePairs(plan, results, 1, {kQuestion}).at(0);
  CHECK(back.wall.mean == Approx(-c.wall.mean));
  CHECK(back.count(PairedVerdict::worse) == 4);
}

TEST_CASE("pairs: who loses more runs cannot be found better, and few pairs decide nothing") {
  const StudyPlan plan = planOf(2, 6);
  auto results = resultsOf(plan, 2, [](std::size_t) { return 3.0; });
  const auto lose = [&](std::size_t column, std::size_t point, int runs) {
    for (StudyResult& r : results)
      if (r.run.scenario == 1 && r.run.column == column && r.run.point == point && r.run.run < runs)
        r.status = Status::unreachable;
  };
  lose(1, 0, 2);  // the worse one loses: still decided
  lose(0, 1, 1);  // the better one loses: not decided
  lose(0, 2, 5);  // one pair: not decided
  const PairedComparison c = comparePairs(plan, results, 0, {kQuestion}).at(0);
  CHECK(c.verdicts == std::vector<PairedVerdict>{PairedVerdict::better, PairedVerdict::undecided,
                                                 PairedVerdict::undecided, PairedVerdict::better});
  CHECK(c.points[0].count == 4);
  CHECK(c.lostA == 6);
  CHECK(c.lostB == 2);
  CHECK(c.verdict == PairedVerdict::undecided);
}

TEST_CASE("pairs: equal renderers give a false finding in at most 5 % of the studies") {
  const StudyPlan plan = planOf(3, 5);
  int alarms = 0;
  constexpr int kTrials = 400;
  for (unsigned trial = 0; trial < kTrials; ++trial) {
    const auto results = resultsOf(plan, 100 + trial, [](std::size_t) { return 1.0; });
    const PairedComparison c = comparePairs(plan, results, 0, {kQuestion}).at(0);
    alarms += c.count(PairedVerdict::undecided) < 9;
  }
  CHECK(alarms <= 0.05 * kTrials + 4.0 * std::sqrt(0.05 * 0.95 * kTrials));  // four standard deviations
  CHECK(alarms > 0);                                                         // the test can find something
}

}  // namespace enamel::test_paired
