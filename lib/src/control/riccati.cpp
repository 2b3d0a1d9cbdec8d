#include "enamel/control/riccati.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "control/dense.hpp"
#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr int kMaxDoublings = 60;
constexpr int kMaxSquarings = 48;  // the power 2^48 of a closed loop; at higher powers rounding decides
constexpr int kMaxCorrections = 60;

double largest(const MatrixXd& M) { return M.cwiseAbs().maxCoeff(); }
MatrixXd symmetric(const MatrixXd& M) { return 0.5 * (M + M.transpose()); }
MatrixXd solvePositive(const MatrixXd& R, const MatrixXd& B) { return R.llt().solve(B); }  // R^-1 B, R > 0
// S^T M S; it need not be symmetric.
MatrixXd transformed(const MatrixXd& M, const MatrixXd& S) { return product(product(S.transpose(), M), S); }

struct Problem {
  MatrixXd A, B, Q, R;
};

// --- checks of the data -------------------------------------------------------------------------------------------

void requireSymmetric(const MatrixXd& M, const char* name) {
  if ((M - M.transpose()).cwiseAbs().maxCoeff() > 1e-12 * largest(M))
    throw DesignError(std::string("Riccati: ") + name + " is not symmetric");
}

// M >= 0 up to `tolerance` of its diagonal, whatever the scale of each state: Cholesky of the shifted matrix.
bool isPositiveSemidefinite(const MatrixXd& M, double tolerance) {
  MatrixXd shifted = M;
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    if (M(i, i) == 0.0) {
      if (M.row(i).cwiseAbs().maxCoeff() > 0.0) return false;
      shifted(i, i) = 1.0;
    } else {
      shifted(i, i) *= 1.0 + tolerance;
    }
  }
  return shifted.llt().info() == Eigen::Success;
}

void check(const Problem& p) {
  const Eigen::Index n = p.A.rows(), m = p.B.cols();
  const auto size = [](const MatrixXd& M) { return std::to_string(M.rows()) + " x " + std::to_string(M.cols()); };
  if (n == 0 || m == 0 || p.A.cols() != n || p.B.rows() != n || p.Q.rows() != n || p.Q.cols() != n || p.R.rows() != m ||
      p.R.cols() != m)
    throw DesignError("Riccati: sizes do not fit: A " + size(p.A) + ", B " + size(p.B) + ", Q " + size(p.Q) + ", R " +
                      size(p.R));
  if (!p.A.allFinite() || !p.B.allFinite() || !p.Q.allFinite() || !p.R.allFinite())
    throw DesignError("Riccati: the data are not finite");
  requireSymmetric(p.Q, "Q");
  requireSymmetric(p.R, "R");
  if (!isPositiveSemidefinite(symmetric(p.Q), 100.0 * static_cast<double>(n) * kEpsilon))
    throw DesignError("Riccati: Q is not positive semidefinite");
  if (symmetric(p.R).llt().info() != Eigen::Success) throw DesignError("Riccati: R is not positive definite");
}

// Popov-Belevitch-Hautus: rank [A - z I, B] = n for every eigenvalue z of A outside the open unit disk.
bool isStabilisable(const Problem& p) {
  const Eigen::Index n = p.A.rows();
  Eigen::MatrixXcd pencil(n, n + p.B.cols());
  pencil.rightCols(p.B.cols()) = p.B.cast<std::complex<double>>();
  for (const std::complex<double> z : eigenvalues(p.A)) {
    if (std::abs(z) < 1.0 - 1e-12) continue;
    pencil.leftCols(n) = p.A.cast<std::complex<double>>();
    pencil.leftCols(n).diagonal().array() -= z;
    const VectorXd singular = singularValues(pencil);
    if (singular[n - 1] <= 1e-12 * singular[0]) return false;
  }
  return true;
}

// --- balancing ----------------------------------------------------------------------------------------------------

// Powers of two t, x = diag(t) z, that balance rows and columns of [A G; Q A^T] under diag(t, 1/t). Source: symplectic
// balancing of Benner 2001.
VectorXd balance(const MatrixXd& A, const MatrixXd& G, const MatrixXd& Q) {
  const Eigen::Index n = A.rows();
  VectorXd t = VectorXd::Ones(n);
  MatrixXd a = A.cwiseAbs(), g = G.cwiseAbs(), q = Q.cwiseAbs();
  a.diagonal().setZero();
  bool changed = true;
  for (int sweep = 0; changed && sweep < 5; ++sweep) {
    changed = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double column = a.col(i).sum() + q.col(i).sum(), row = a.row(i).sum() + g.row(i).sum();
      if (!(column > 0.0 && row > 0.0)) continue;
      const int exponent = static_cast<int>(std::lround(0.5 * std::log2(row / column)));
      if (exponent == 0) continue;
      const double f = std::ldexp(1.0, exponent);
      if (column * f + row / f > 0.95 * (column + row)) continue;
      changed = true;
      t[i] *= f;
      a.col(i) *= f, a.row(i) /= f;
      q.col(i) *= f, q.row(i) *= f;
      g.col(i) /= f, g.row(i) /= f;
    }
  }
  return t;
}

// --- twice the working precision ----------------------------------------------------------------------------------

// The unevaluated sum hi + lo.
struct Extended {
  MatrixXd hi, lo;
};

// The upper half of the digits (Veltkamp 1968): products of halves are exact.
double upperHalf(double x) {
  const double c = 134217729.0 * x;  // 2^27 + 1
  return c - (c - x);
}

// a b with every inner product as if in twice the working precision (Ogita, Rump and Oishi 2005, algorithm 5.3).
Extended multiply(const MatrixXd& a, const MatrixXd& b) {
  const Eigen::Index rows = a.rows();
  const MatrixXd aUpper = a.unaryExpr(&upperHalf), aLower = a - aUpper;
  Extended c{MatrixXd::Zero(rows, b.cols()), MatrixXd::Zero(rows, b.cols())};
  for (Eigen::Index j = 0; j < b.cols(); ++j) {
    double* hi = c.hi.data() + j * rows;
    double* lo = c.lo.data() + j * rows;
    for (Eigen::Index k = 0; k < a.cols(); ++k) {
      const double y = b(k, j), yUpper = upperHalf(y), yLower = y - yUpper;
      const double *x = a.data() + k * rows, *xUpper = aUpper.data() + k * rows, *xLower = aLower.data() + k * rows;
      for (Eigen::Index i = 0; i < rows; ++i) {
        const double product = x[i] * y;
        const double productError =
            xLower[i] * yLower - (((product - xUpper[i] * yUpper) - xLower[i] * yUpper) - xUpper[i] * yLower);
        const double sum = hi[i] + product, t = sum - hi[i];
        lo[i] += productError + ((hi[i] - (sum - t)) + (product - t));
        hi[i] = sum;
      }
    }
  }
  return c;
}

Extended multiply(const MatrixXd& a, const Extended& b) {
  Extended c = multiply(a, b.hi);
  c.lo += product(a, b.lo);
  return c;
}

// a += b, keeping the rounding error (Knuth 1969, two-sum).
void accumulate(Extended& a, const MatrixXd& hi) {
  const MatrixXd sum = a.hi + hi, t = sum - a.hi;
  a.lo += (a.hi - (sum - t)) + (hi - t);
  a.hi = sum;
}

void accumulate(Extended& a, const Extended& b) {
  accumulate(a, b.hi);
  a.lo += b.lo;
}

// --- the equation -------------------------------------------------------------------------------------------------

MatrixXd gainOf(const Problem& p, const MatrixXd& X) {
  const MatrixXd XBt = product(X, p.B).transpose();
  return solvePositive(p.R + product(XBt, p.B), product(XBt, p.A));
}

// Residuals of X and K, computed in twice the working precision.
struct Residuals {
  // Cost of one step under K minus X, made symmetric: Q - X + A^T X A + K^T ((R + B^T X B) K - 2 B^T X A). At the gain
  // of X it is the residual of the Riccati equation. An error of K enters only in second order.
  MatrixXd cost;
  MatrixXd gain;  // B^T X A - (R + B^T X B) K
};

Residuals residualsOf(const Problem& p, const MatrixXd& X, const MatrixXd& K) {
  const Extended XA = multiply(X, p.A), XB = multiply(X, p.B);
  const MatrixXd Bt = p.B.transpose(), Kt = K.transpose();
  Extended weight = multiply(Bt, XB);  // R + B^T X B
  accumulate(weight, p.R);
  const Extended BXA = multiply(Bt, XA), minusBXA{-BXA.hi, -BXA.lo};
  Extended inner = multiply(Kt, Extended{weight.hi.transpose(), weight.lo.transpose()});
  inner = {inner.hi.transpose(), inner.lo.transpose()};  // (R + B^T X B) K
  accumulate(inner, minusBXA);
  Residuals residuals{{}, -(inner.hi + inner.lo)};
  accumulate(inner, minusBXA);
  Extended sum = multiply(p.A.transpose(), XA);
  accumulate(sum, -X);
  accumulate(sum, p.Q);
  accumulate(sum, multiply(Kt, inner));
  residuals.cost = symmetric(sum.hi) + symmetric(sum.lo);
  return residuals;
}

// --- doubling -----------------------------------------------------------------------------------------------------

// Structure-preserving doubling (Chu, Fan, Lin and Wang 2004, eq. 2.13) from A, G = B R^-1 B^T, H = Q. H converges to
// X; every step squares the error. Returns nullopt if it overflows or does not settle.
std::optional<MatrixXd> doubling(const Problem& p, int& steps) {
  const Eigen::Index n = p.A.rows();
  MatrixXd A = p.A, H = p.Q, G = product(p.B, solvePositive(p.R, p.B.transpose()));
  MatrixXd both(n, 2 * n);
  for (steps = 1; steps <= kMaxDoublings; ++steps) {
    both << A, G;
    const MatrixXd solved = solve(MatrixXd::Identity(n, n) + product(G, H), both);  // (I + G H)^-1 [A, G]
    const MatrixXd WA = solved.leftCols(n), WG = solved.rightCols(n), At = A.transpose();
    const MatrixXd increment = symmetric(product(At, product(H, WA)));
    H += increment;
    if (!H.allFinite()) return std::nullopt;
    if (largest(increment) <= 1e-7 * largest(H)) return H;  // the rest, about its square, is for Newton
    G += symmetric(transformed(WG, At));
    A = product(A, WA);
    if (!G.allFinite() || !A.allFinite()) return std::nullopt;
  }
  return std::nullopt;
}

// --- Newton -------------------------------------------------------------------------------------------------------

// Powers S, S^2, S^4, ... up to the first with a norm below 1e-8. Empty if no power shows that S is stable.
std::vector<MatrixXd> squarings(const MatrixXd& S) {
  std::vector<MatrixXd> powers{S};
  while (!(powers.back().cwiseAbs().rowwise().sum().maxCoeff() < 1e-8)) {
    if (powers.size() > kMaxSquarings || !powers.back().allFinite()) return {};
    powers.push_back(product(powers.back(), powers.back()));
  }
  return powers;
}

// Solve D = S^T D S + W by Smith's doubling (1968).
MatrixXd solveStein(const std::vector<MatrixXd>& powers, MatrixXd W) {
  for (const MatrixXd& S : powers) W += symmetric(transformed(W, S));
  return W;
}

// Newton's method from X, whose gain must stabilise. Returns false if it cannot start or does not settle.
bool refine(const Problem& p, MatrixXd& X, int& corrections) {
  for (corrections = 1; corrections <= kMaxCorrections; ++corrections) {
    const MatrixXd K = gainOf(p, X);
    if (!K.allFinite()) return false;
    const std::vector<MatrixXd> powers = squarings(p.A - product(p.B, K));
    if (powers.empty()) return false;
    const MatrixXd D = solveStein(powers, residualsOf(p, X, K).cost);
    X = symmetric(X + D);
    // Two errors remain: the second-order term of Newton's method, and the error of D, computed in working precision.
    const double step = largest(D) / largest(X), amplification = std::ldexp(1.0, static_cast<int>(powers.size()));
    if (step == 0.0 || step * std::max(step, 100.0 * kEpsilon) * amplification < 0.1 * kEpsilon) return true;
    if (!std::isfinite(step)) return largest(X) == 0.0;
  }
  return false;
}

std::optional<MatrixXd> solveBalanced(const Problem& p, int& doublings, int& corrections) {
  if (std::optional<MatrixXd> X = doubling(p, doublings); X && refine(p, *X, corrections)) return X;
  // Doubling from Q finds the smallest solution. That is not the stabilising one if Q misses an unstable mode. Newton
  // from any stabilising gain converges to it, and weighting every state gives such a gain.
  Problem seen = p;
  seen.Q.diagonal().array() += std::max(largest(p.Q), 1.0);
  if (std::optional<MatrixXd> X = doubling(seen, doublings); X && refine(p, *X, corrections)) return X;
  return std::nullopt;
}

}  // namespace

RiccatiSolution solveRiccati(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  Problem p{A, B, Q, R};
  check(p);
  p.Q = symmetric(Q);
  p.R = symmetric(R);
  const VectorXd t = balance(A, product(B, solvePositive(p.R, B.transpose())), p.Q), inverse = t.cwiseInverse();
  p.A = inverse.asDiagonal() * A * t.asDiagonal();
  p.B = inverse.asDiagonal() * B;
  p.Q = t.asDiagonal() * p.Q * t.asDiagonal();

  RiccatiSolution solution;
  const std::optional<MatrixXd> X = solveBalanced(p, solution.doublings, solution.corrections);
  if (!X) {
    if (!isStabilisable(p)) throw DesignError("Riccati: (A, B) is not stabilisable: an unstable mode has no input");
    throw DesignError(
        "Riccati: no stabilising solution: the closed loop would have an eigenvalue on the unit circle, or the "
        "inputs hardly affect an unstable mode");
  }
  MatrixXd K = gainOf(p, *X);
  const MatrixXd S = p.A - product(p.B, K);
  const std::vector<MatrixXd> powers = squarings(S);
  if (powers.empty()) throw DesignError("Riccati: no stabilising solution: the closed loop is not stable");
  const Residuals residuals = residualsOf(p, *X, K);
  // Rounding X by E leaves S^T E S - E: at most a few units in the last place of these terms.
  const double magnitude = std::max(largest(transformed(X->cwiseAbs(), S.cwiseAbs())), largest(*X));
  if (magnitude > 0.0) solution.residual = largest(residuals.cost) / magnitude;
  if (!(solution.residual < 1e-13))
    throw DesignError("Riccati: the relative residual is " + formatNumber(solution.residual) +
                      ", must be less than 1e-13");
  // The gain of the exact solution: D, the digits of X that rounding cut off, may matter to it.
  const MatrixXd D = solveStein(powers, residuals.cost);
  K += solvePositive(p.R + transformed(*X, p.B), residuals.gain + product(product(p.B.transpose(), D), S));
  if (!isPositiveSemidefinite(*X, 1e-10)) throw DesignError("Riccati: the solution is not positive semidefinite");
  solution.P = inverse.asDiagonal() * *X * inverse.asDiagonal();
  solution.K = K * inverse.asDiagonal();
  return solution;
}

}  // namespace enamel
