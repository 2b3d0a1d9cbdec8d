// Paired comparison of the renderers of a study. Runs of the same scenario, point and number have the same random
// forces, noise and delays with every renderer.
#pragma once

#include <limits>
#include <vector>

#include "enamel/study/monte_carlo.hpp"

namespace enamel {

/// Return the probability that |t| of Student's distribution is above `t` >= 0. It is the incomplete beta function
/// I_x(freedom / 2, 1 / 2) at x = freedom / (freedom + t^2), by Lentz's method (Abramowitz and Stegun 1964, 26.7.1 and
/// 26.5.8). The relative error is below 1e-10 for up to 1e6 degrees of freedom. Realtime: yes.
double studentBeyond(double t, double freedom) noexcept;

/// Return the t that |t| of Student's distribution exceeds with probability `p` (0 to 1), by bisection. Realtime: no.
double studentQuantile(double p, double freedom) noexcept;

/// Adjust p values for their number by Holm's step-down procedure (S. Holm 1979). If every value below 0.05 counts as a
/// finding, a false finding has a probability of at most 0.05. NaN remains NaN and is not counted. Realtime: no.
std::vector<double> holm(const std::vector<double>& p);

/// Mean of differences with its 95 % interval, and the test of "the mean is zero" (Student). NaN if there are too few.
/// Without deviation the interval is zero, and p is 0 or 1.
struct MeanDifference {
  int count = 0;
  double mean = std::numeric_limits<double>::quiet_NaN();
  double half = mean;    ///< half of the 95 % interval
  double p = mean;       ///< two-sided
  double effect = mean;  ///< mean over standard deviation (Cohen's d_z); NaN without deviation
};

/// Return interval and test for the mean of differences. Realtime: no.
MeanDifference meanDifference(const Spread& differences);

/// Return the mean of the means of strata, such as query points. The strata are fixed, their values random. The degrees
/// of freedom are those of Satterthwaite (1946), and `effect` is relative to the deviation within the strata. A stratum
/// with fewer than two values is left out. Realtime: no.
MeanDifference meanOfStrata(const std::vector<Spread>& strata);

/// A question about two renderers: the metric and how to compare it.
struct PairedQuestion {
  int scenario = 1;
  MetricMember metric;
  bool isRatio = true;  ///< compare logarithms of positive values, else differences
  bool moreIsBetter = true;
};

enum class PairedVerdict { better, worse, undecided };

/// The comparison of column `a` with column `b`. Differences are a - b, or ln(a / b) for a ratio. A difference is found
/// only if its adjusted p is below 0.05. It is undecided if the better column lost more of the runs than the other.
struct PairedComparison {
  PairedQuestion question;
  std::size_t a = 0, b = 0;
  std::vector<MeanDifference> points;   ///< over the runs of each query point
  std::vector<double> adjusted;         ///< Holm's p of each point, for all points and columns of the question
  std::vector<PairedVerdict> verdicts;  ///< of each point
  MeanDifference wall;                  ///< mean of the points' means
  double wallAdjusted = std::numeric_limits<double>::quiet_NaN();  ///< Holm's p, of judgeWalls()
  PairedVerdict verdict = PairedVerdict::undecided;                ///< of the wall
  double largerShare = std::numeric_limits<double>::quiet_NaN();   ///< share of the pairs in which a is larger
  int lostA = 0, lostB = 0;                                        ///< runs

  /// Return the number of points with a verdict.
  int count(PairedVerdict v) const noexcept;
};

/// Compare column `a` with each other column, for each question whose scenario the plan has. A pair counts if both runs
/// have the metric and none is lost. `results` must be complete and in the order of their numbers. The walls are judged
/// for the comparisons of this call. Realtime: no.
std::vector<PairedComparison> comparePairs(const StudyPlan& plan, const std::vector<StudyResult>& results,
                                           std::size_t a, const std::vector<PairedQuestion>& questions);

/// Adjust the tests of the walls for the number of all `comparisons`, and give each its verdict. Realtime: no.
void judgeWalls(const std::vector<PairedComparison*>& comparisons);

}  // namespace enamel
