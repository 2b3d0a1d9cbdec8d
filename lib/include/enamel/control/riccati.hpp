// The discrete algebraic Riccati equation.
#pragma once

#include <Eigen/Core>

namespace enamel {

/// Stabilising solution, with its residual and the steps it took.
struct RiccatiSolution {
  Eigen::MatrixXd P;      ///< n x n, symmetric, P >= 0; the cost-to-go is x^T P x
  Eigen::MatrixXd K;      ///< m x n; u = -K x minimises sum x^T Q x + u^T R u
  double residual = 0.0;  ///< largest entry of the equation's residual over that of |A-BK|^T |P| |A-BK|, balanced
  int doublings = 0;
  int corrections = 0;
};

/// Solve the discrete algebraic Riccati equation for the solution that makes A - B K stable ("A Position-Control Based
/// Approach ...", section IV-B). Realtime: no.
///
///   P = A^T P A - A^T P B (R + B^T P B)^-1 B^T P A + Q,   K = (R + B^T P B)^-1 B^T P A.
///
/// 1. Balancing: a diagonal state transformation by powers of two (after Benner 2001).
/// 2. Structure-preserving doubling (Chu, Fan, Lin and Wang 2004, eq. 2.13), at most 60 steps.
/// 3. Newton's corrections (Kleinman 1968; Hewer 1971), at most 60. Each is a Stein equation, solved by doubling
///    (Smith 1968). Their residual is computed in twice the working precision (Ogita, Rump and Oishi 2005). P is
///    therefore accurate to the rounding of its entries, also if the equation is ill-conditioned.
/// 4. One correction of K with the digits of P that rounding removed.
/// 5. Checks: the residual is small, P >= 0, and the closed loop is stable (a power of A - B K has a norm below one).
///
/// Q must be symmetric and positive semidefinite. R must be symmetric and positive definite.
/// Throws DesignError:
/// - sizes do not match, or entries are not finite;
/// - Q or R is invalid;
/// - (A, B) is not stabilisable;
/// - no stabilising solution exists (an eigenvalue of the closed loop is on the unit circle).
RiccatiSolution solveRiccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& Q,
                             const Eigen::MatrixXd& R);

}  // namespace enamel
