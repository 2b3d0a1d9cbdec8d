// The discrete algebraic Riccati equation.
#pragma once

#include <Eigen/Core>

namespace enamel {

/// Stabilising solution and what it cost.
struct RiccatiSolution {
  Eigen::MatrixXd P;      ///< n x n, symmetric, P >= 0: the cost-to-go is x^T P x
  Eigen::MatrixXd K;      ///< m x n: u = -K x minimises sum x^T Q x + u^T R u
  double residual = 0.0;  ///< largest entry of the equation's residual over that of |A-BK|^T |P| |A-BK|, balanced
  int doublings = 0;
  int corrections = 0;
};

/// Solves P = A^T P A - A^T P B (R + B^T P B)^-1 B^T P A + Q, K = (R + B^T P B)^-1 B^T P A for the solution that makes
/// A - B K stable ("A Position-Control Based Approach ...", section IV-B).
///
/// 1. Balancing: a diagonal state transformation by powers of two (after Benner 2001).
/// 2. Structure-preserving doubling (Chu, Fan, Lin and Wang 2004, eq. 2.13), at most 60 steps.
/// 3. Newton's corrections (Kleinman 1968; Hewer 1971), at most 60, each a Stein equation solved by Smith's doubling
///    (1968). Their residual is formed in twice the working precision (Ogita, Rump and Oishi 2005), so the error of P
///    is that of rounding its entries even where the equation is ill-conditioned.
/// 4. One correction of K by the digits of P that rounding cut off.
/// 5. Checks: residual, P >= 0, closed loop stable (a power of A - B K has a norm below one).
/// Q must be symmetric and positive semidefinite, R symmetric and positive definite.
/// Throws DesignError: sizes, entries not finite, Q or R not as required, (A, B) not stabilisable, no stabilising
/// solution (an eigenvalue of the closed loop on the unit circle). Realtime: no.
RiccatiSolution solveRiccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& Q,
                             const Eigen::MatrixXd& R);

}  // namespace enamel
