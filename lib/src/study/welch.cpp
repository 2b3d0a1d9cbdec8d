#include "enamel/study/welch.hpp"

#include <cmath>

namespace enamel {
namespace {

// The continued fraction of I_x(a, b), for x < (a + 1) / (a + b + 2).
double betaFraction(double x, double a, double b) noexcept {
  constexpr double kTiny = 1e-300;
  constexpr int kMost = 20000;
  const auto safe = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1.0, d = 1.0 / safe(1.0 - (a + b) * x / (a + 1.0)), h = d;
  for (int m = 1; m <= kMost; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                 odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double change = 1.0;
    for (const double term : {even, odd}) {
      d = 1.0 / safe(1.0 + term * d);
      c = safe(1.0 + term / c);
      change *= c * d;
    }
    h *= change;
    if (std::abs(change - 1.0) < 1e-14) break;
  }
  return h;
}

// I_x(a, b). `rest` is 1 - x without cancellation.
double incompleteBeta(double x, double rest, double a, double b) noexcept {
  if (x <= 0.0) return 0.0;
  if (rest <= 0.0) return 1.0;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log(rest));
  return x < (a + 1.0) / (a + b + 2.0) ? front * betaFraction(x, a, b) / a : 1.0 - front * betaFraction(rest, b, a) / b;
}

}  // namespace

double studentBeyond(double t, double freedom) noexcept {
  const double whole = freedom + t * t;
  return incompleteBeta(freedom / whole, t * t / whole, 0.5 * freedom, 0.5);
}

WelchTest welchTest(const Spread& a, const Spread& b) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const double ea = a.deviation * a.deviation / a.count, eb = b.deviation * b.deviation / b.count, error = ea + eb;
  if (a.count < 2 || b.count < 2 || !(error > 0.0)) return {none, none, none, none};
  WelchTest test;
  test.t = (a.mean - b.mean) / std::sqrt(error);
  test.freedom = error * error / (ea * ea / (a.count - 1) + eb * eb / (b.count - 1));
  test.p = studentBeyond(std::abs(test.t), test.freedom);
  test.effect = (a.mean - b.mean) / std::sqrt(0.5 * (a.deviation * a.deviation + b.deviation * b.deviation));
  return test;
}

}  // namespace enamel
