#include "enamel/control/discretise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "control/dense.hpp"
#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

using Eigen::MatrixXd;

// Number of halvings s for which the Pade approximant of degree 13 of 2^-s A is exact to rounding (Al-Mohy and Higham
// 2009, eq. 3.6 and algorithm 5.1).
int halvingsFor(const MatrixXd& A, const MatrixXd& A4, const MatrixXd& A6) {
  constexpr double kTheta13 = 4.25;
  const double d6 = std::pow(norm1(A6), 1.0 / 6.0);
  const double d8 = std::pow(norm1(product(A4, A4)), 1.0 / 8.0);
  const double d10 = std::pow(norm1(product(A4, A6)), 1.0 / 10.0);
  const double alpha = std::min(std::max(d6, d8), std::max(d8, d10));
  int halvings = alpha > kTheta13 ? static_cast<int>(std::ceil(std::log2(alpha / kTheta13))) : 0;
  // Cancellation among powers may hide rounding errors. Bound them by the powers of |A|, eq. 3.11.
  constexpr double kInverseCoefficient = 113250775606021113483283660800000000.0;  // 1 / |c_27|
  const double norm = norm1(A);
  if (norm == 0.0) return halvings;
  Eigen::VectorXd sums = Eigen::VectorXd::Ones(A.rows());
  const MatrixXd scaled = std::ldexp(1.0, -halvings) * A.cwiseAbs().transpose();
  double exponent = 0.0;  // sums are kept near one: |A|^27 may overflow
  for (int power = 0; power < 27; ++power) {
    sums = scaled * sums;
    const double largest = sums.maxCoeff();
    if (largest == 0.0) return halvings;
    sums /= largest;
    exponent += std::log2(largest);
  }
  const double excess = exponent - std::log2(std::ldexp(norm, -halvings)) - std::log2(kInverseCoefficient) -
                        std::log2(0.5 * std::numeric_limits<double>::epsilon());
  return halvings + std::max(0, static_cast<int>(std::ceil(excess / 26.0)));
}

}  // namespace

MatrixXd matrixExponential(const MatrixXd& input) {
  if (input.rows() != input.cols())
    throw DesignError("matrix exponential: the matrix is " + std::to_string(input.rows()) + " x " +
                      std::to_string(input.cols()) + ", must be square");
  if (!input.allFinite()) throw DesignError("matrix exponential: the matrix is not finite");
  const Eigen::Index n = input.rows();
  if (n == 0) return input;
  const double size = norm1(input);
  if (!std::isfinite(size)) throw DesignError("matrix exponential: the sum of a column overflows");
  // Far outside practical use, but the powers must not overflow.
  const int before = std::max(0, std::ilogb(std::max(size, 1.0)) - 60);
  MatrixXd A = std::ldexp(1.0, -before) * input;
  MatrixXd A2 = product(A, A), A4 = product(A2, A2), A6 = product(A4, A2);
  const int halvings = halvingsFor(A, A4, A6);
  A *= std::ldexp(1.0, -halvings);
  A2 *= std::ldexp(1.0, -2 * halvings);
  A4 *= std::ldexp(1.0, -4 * halvings);
  A6 *= std::ldexp(1.0, -6 * halvings);

  // Pade approximant of degree 13 (Higham 2005, eq. 3.7): e^A = (V - U)^-1 (V + U) = I + 2 (V - U)^-1 U.
  constexpr double b[] = {64764752532480000.,
                          32382376266240000.,
                          7771770303897600.,
                          1187353796428800.,
                          129060195264000.,
                          10559470521600.,
                          670442572800.,
                          33522128640.,
                          1323241920.,
                          40840800.,
                          960960.,
                          16380.,
                          182.,
                          1.};
  const MatrixXd I = MatrixXd::Identity(n, n);
  const MatrixXd U =
      product(A, product(A6, b[13] * A6 + b[11] * A4 + b[9] * A2) + b[7] * A6 + b[5] * A4 + b[3] * A2 + b[1] * I);
  const MatrixXd V = product(A6, b[12] * A6 + b[10] * A4 + b[8] * A2) + b[6] * A6 + b[4] * A4 + b[2] * A2 + b[0] * I;
  const MatrixXd denominator = V - U;
  MatrixXd E = solve(denominator, 2.0 * U);
  E += solve(denominator,
             2.0 * U - product(denominator, E));  // makes the backward error small entry by entry (Skeel 1980)
  for (int i = 0; i < before + halvings; ++i) E = 2.0 * E + product(E, E);
  E += I;
  if (!E.allFinite()) throw DesignError("matrix exponential: the result overflows");
  return E;
}

StateSpace zeroOrderHold(const StateSpace& continuous, double period) {
  const Eigen::Index n = continuous.A.rows(), m = continuous.B.cols();
  if (continuous.A.cols() != n || continuous.B.rows() != n)
    throw DesignError("zero-order hold: A must be n x n and B n x m");
  if (!(period > 0.0 && std::isfinite(period)))
    throw DesignError("zero-order hold: the period is " + formatNumber(period) + " s, must be greater than 0 s");
  MatrixXd block = MatrixXd::Zero(n + m, n + m);
  block.topLeftCorner(n, n) = period * continuous.A;
  block.topRightCorner(n, m) = period * continuous.B;
  const MatrixXd exponential = matrixExponential(block);
  return {exponential.topLeftCorner(n, n), exponential.topRightCorner(n, m)};
}

}  // namespace enamel
