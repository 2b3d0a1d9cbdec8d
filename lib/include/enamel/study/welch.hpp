// Welch's test for a difference of two means.
#pragma once

#include "enamel/study/monte_carlo.hpp"

namespace enamel {

struct WelchTest {
  double t = 0.0;        ///< (mean a - mean b) / its standard error
  double freedom = 0.0;  ///< degrees of freedom, Welch and Satterthwaite
  double p = 1.0;        ///< two-sided: probability of such a |t| if the true means are equal
  double effect = 0.0;   ///< (mean a - mean b) / root mean square of the two deviations (Cohen's d)
};

/// Perform Welch's t test (B. L. Welch 1947, "The generalization of 'Student's' problem ..."). All results are NaN if a
/// sample has fewer than two values, or both samples have zero deviation. Realtime: no.
WelchTest welchTest(const Spread& a, const Spread& b);

/// Return the probability that |t| of Student's distribution is above `t` >= 0. It is the incomplete beta function
/// I_x(freedom / 2, 1 / 2) at x = freedom / (freedom + t^2), by Lentz's method (Abramowitz and Stegun 1964, 26.7.1 and
/// 26.5.8). The relative error is below 1e-10 for up to 1e6 degrees of freedom. Realtime: yes.
double studentBeyond(double t, double freedom) noexcept;

}  // namespace enamel
