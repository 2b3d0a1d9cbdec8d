#include "bench/control_cases.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace enamel::bench {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kTight = 1e-12;  // largest forward error that the project allows

MatrixXd matrix(int rows, int columns, std::initializer_list<double> rowMajor) {
  MatrixXd M(rows, columns);
  int i = 0;
  for (const double value : rowMajor) {
    M(i / columns, i % columns) = value;
    ++i;
  }
  return M;
}

std::string named(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// Case 14 has an eigenvalue at 1 - 1e-8. The solution X uses alpha and beta as given: exact in long double, or rounded.
RiccatiCase case14(std::string name, long double alpha, long double beta, double bound) {
  RiccatiCase c{std::move(name),
                MatrixXd::Zero(4, 4),
                MatrixXd::Zero(4, 1),
                MatrixXd::Zero(4, 4),
                matrix(1, 1, {0.25}),
                MatrixXd::Identity(4, 4),
                bound};
  for (int i = 1; i < 4; ++i) c.A(i, i - 1) = 1.0;
  c.A(0, 0) = static_cast<double>(alpha);
  c.B(0, 0) = static_cast<double>(beta);
  c.Q(3, 3) = 1.0;
  const long double p = 0.25L / (beta * beta), s = p * (alpha - 1.0L) * (alpha + 1.0L);
  c.X(0, 0) = static_cast<double>(0.5L * (s + 1.0L) + std::sqrt(0.25L * (s + 1.0L) * (s + 1.0L) + p));
  return c;
}

}  // namespace

std::vector<RiccatiCase> riccatiCases() {
  const double root5 = std::sqrt(5.0);
  const MatrixXd I1 = MatrixXd::Identity(1, 1), I2 = MatrixXd::Identity(2, 2);
  std::vector<RiccatiCase> cases;

  const MatrixXd Q1 = matrix(2, 2, {9, 6, 6, 4});
  cases.push_back(
      {"DAREX 1", matrix(2, 2, {4, 3, -4.5, -3.5}), matrix(2, 1, {1, -1}), Q1, I1, 0.5 * (1 + root5) * Q1, kTight});
  cases.push_back({"DAREX 5", matrix(2, 2, {0, 1, 0, 0}), matrix(2, 1, {0, 1}), matrix(2, 2, {1, 2, 2, 4}), I1,
                   matrix(2, 2, {1, 2, 2, 2 + root5}), kTight});
  for (const double d : {1.0, 1e6})
    cases.push_back({named("DAREX 12, d = %g", d), matrix(2, 2, {0, d, 0, 0}), matrix(2, 1, {0, 1}), I2, I1,
                     matrix(2, 2, {1, 0, 0, 1 + d * d}), kTight});
  for (const double d : {1.0, 1e6}) {
    const MatrixXd I = MatrixXd::Identity(3, 3), U = I - MatrixXd::Constant(3, 3, 2.0 / 3.0);
    const Vector3d x(1.0, 0.5 * (1 + root5), 0.5 * (9 + std::sqrt(85.0)));
    cases.push_back({named("DAREX 13, d = %g", d), U * Vector3d(0, 1, 3).asDiagonal() * U, I, d * I, d * I,
                     d * U * x.asDiagonal() * U, kTight});
  }
  {
    const double tau = 1e8, alpha = 1.0 - 1.0 / tau, beta = 1.0 / tau;
    cases.push_back(case14("DAREX 14, tau = 1e8", 1.0L - 1.0L / 1e8L, 1.0L / 1e8L, 1e-7));
    // The same case with alpha and beta as rounded to double: the error of 1e-7 above comes from rounding the data, not
    // from the solver.
    cases.push_back(case14("DAREX 14, rounded data", alpha, beta, kTight));
  }
  {
    const int n = 100;
    MatrixXd shift = MatrixXd::Zero(n, n), last = MatrixXd::Zero(n, 1);
    for (int i = 0; i + 1 < n; ++i) shift(i, i + 1) = 1.0;
    last(n - 1, 0) = 1.0;
    cases.push_back({"DAREX 15, n = 100", shift, last, MatrixXd::Identity(n, n), I1,
                     VectorXd::LinSpaced(n, 1.0, n).asDiagonal(), kTight});
  }
  for (const double e : {1e-2, 1e-4, 1e-6, 1e-8})
    cases.push_back({named("scalar, q = eps^2, eps = %g", e), I1, I1, e * e * I1, I1,
                     0.5 * (e * e + std::sqrt(e * e * e * e + 4 * e * e)) * I1, kTight});
  cases.push_back({"shift of two, B = e2", matrix(2, 2, {0, 1, 0, 0}), matrix(2, 1, {0, 1}), I2, I1,
                   matrix(2, 2, {1, 0, 0, 2}), kTight});
  // For Q = 0 and an unstable A, X = 0 is a solution that does not stabilise. x = a^2 x / (1 + x) gives x = a^2 - 1.
  cases.push_back({"scalar, a = 2, q = 0", 2 * I1, I1, 0 * I1, I1, 3 * I1, kTight});
  return cases;
}

std::vector<ExponentialCase> exponentialCases() {
  // Bounds: rounding of data and result to 0.5 ulp, amplified by a few operations. 1e-13 for well-conditioned cases.
  std::vector<ExponentialCase> cases;
  for (const double b : {1.0, 1e6})
    cases.push_back({named("[1 b; 0 -1], b = %g", b), matrix(2, 2, {1, b, 0, -1}),
                     matrix(2, 2, {std::exp(1.0), b * std::sinh(1.0), 0, std::exp(-1.0)}), 1e-14});
  {
    // Eigenvalues -1 and -17, eigenvectors almost parallel: condition number 1e2.
    const MatrixXd A = matrix(2, 2, {-49, 24, -64, 31}), I = MatrixXd::Identity(2, 2);
    cases.push_back(
        {"[-49 24; -64 31]", A, std::exp(-1.0) / 16.0 * (A + 17.0 * I) - std::exp(-17.0) / 16.0 * (A + I), 1e-13});
  }
  for (const double c : {1.0, 1e8}) {
    const double fast = -1e8, slow = -1e-8;  // e^fast = 0
    cases.push_back({named("stiff, [-1e8 c; 0 -1e-8], c = %g", c), matrix(2, 2, {fast, c, 0, slow}),
                     matrix(2, 2, {0, c * std::exp(slow) / (slow - fast), 0, std::exp(slow)}), 1e-14});
    cases.push_back({named("stiff, [-1e-8 0; c -1e8], c = %g", c), matrix(2, 2, {slow, 0, c, fast}),
                     matrix(2, 2, {std::exp(slow), 0, c * std::exp(slow) / (slow - fast), 0}), 1e-14});
  }
  cases.push_back({"scales, [0 1e8; -1e-8 0]", matrix(2, 2, {0, 1e8, -1e-8, 0}),
                   matrix(2, 2, {std::cos(1.0), 1e8 * std::sin(1.0), -1e-8 * std::sin(1.0), std::cos(1.0)}), 1e-14});
  cases.push_back({"nilpotent, [0 1e8 0; 0 0 1e8; 0 0 0]", matrix(3, 3, {0, 1e8, 0, 0, 0, 1e8, 0, 0, 0}),
                   matrix(3, 3, {1, 1e8, 5e15, 0, 1, 1e8, 0, 0, 1}), 1e-14});
  return cases;
}

double entrywiseError(const MatrixXd& value, const MatrixXd& reference) {
  if (value.rows() != reference.rows() || value.cols() != reference.cols()) return HUGE_VAL;
  double worst = 0.0;
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    const double error = std::abs(value(i) - reference(i));
    worst = std::max(worst, reference(i) == 0.0 ? error : error / std::abs(reference(i)));
  }
  return worst;
}

}  // namespace enamel::bench
