// Riccati equations for which solvers lose digits: DAREX and the servo's own, with exact solutions.
#include <Eigen/Cholesky>

#include "bench/control_cases.hpp"
#include "bench/measurement.hpp"
#include "enamel/control/riccati.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"

namespace enamel::test_riccati_cases {

using Eigen::MatrixXd;
using Eigen::Vector2d;

TEST_CASE("hard Riccati equations are solved to their bound") {
  for (const bench::RiccatiCase& c : bench::riccatiCases()) {
    INFO(c.name);
    const RiccatiSolution solution = solveRiccati(c.A, c.B, c.Q, c.R);
    const double error = bench::relativeError(solution.P, c.X);
    UNSCOPED_INFO("error " << error << ", doublings " << solution.doublings << ", corrections "
                           << solution.corrections);
    CHECK(error < c.bound);
    CHECK(solution.P == solution.P.transpose());
    // The residual of a correctly rounded solution is that of rounding its entries.
    CHECK(solution.residual < 1e-14);
    // The gain must match the solution.
    const MatrixXd BX = c.B.transpose() * c.X;
    const MatrixXd K = (c.R + BX * c.B).llt().solve(BX * c.A);
    CHECK(bench::relativeError(solution.K, K) < std::max(c.bound, 1e-12));
  }
}

TEST_CASE("small entries of a badly scaled solution are right too") {
  // DAREX 12: X = diag(1, 1 + d^2). Relative to the largest entry, an error of 1 in X(0, 0) would pass.
  for (const bench::RiccatiCase& c : bench::riccatiCases())
    if (c.name.rfind("DAREX 12", 0) == 0) CHECK(bench::entrywiseError(solveRiccati(c.A, c.B, c.Q, c.R).P, c.X) < 1e-12);
}

TEST_CASE("equations without a stabilising solution are refused, and the message says why") {
  const MatrixXd I = MatrixXd::Identity(1, 1), I2 = MatrixXd::Identity(2, 2);
  const MatrixXd e2 = Vector2d(0, 1);
  const auto message = [](const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) -> std::string {
    try {
      solveRiccati(A, B, Q, R);
    } catch (const DesignError& error) {
      return error.what();
    }
    return "accepted";
  };
  using test::ContainsSubstring;
  CHECK_THAT(message(Vector2d(1.1, 0.5).asDiagonal(), e2, I2, I), ContainsSubstring("not stabilisable"));
  CHECK_THAT(message(Vector2d(1.1, 0.5).asDiagonal(), e2, 0 * I2, I), ContainsSubstring("not stabilisable"));
  CHECK_THAT(message(Vector2d(1.0, 0.5).asDiagonal(), e2, I2, I), ContainsSubstring("not stabilisable"));
  CHECK_THAT(message(I, I, 0 * I, I), ContainsSubstring("no stabilising solution"));
  CHECK_THAT(message(-I, I, 0 * I, I), ContainsSubstring("no stabilising solution"));
  MatrixXd rotation(2, 2);
  rotation << 0.6, -0.8, 0.8, 0.6;  // on the unit circle and unobservable
  CHECK_THAT(message(rotation, e2, 0 * I2, I), ContainsSubstring("no stabilising solution"));
  CHECK_THAT(message(I2, e2, I, I), ContainsSubstring("sizes") && ContainsSubstring("Q 1 x 1"));
  CHECK_THAT(message(I2, I, I2, I), ContainsSubstring("sizes"));
  CHECK_THAT(message(MatrixXd(0, 0), MatrixXd(0, 0), MatrixXd(0, 0), MatrixXd(0, 0)), ContainsSubstring("sizes"));
  CHECK_THAT(message(NAN * I, I, I, I), ContainsSubstring("not finite"));
  CHECK_THAT(message(I, I, HUGE_VAL * I, I), ContainsSubstring("not finite"));
  CHECK_THAT(message(I, I, -I, I), ContainsSubstring("Q is not positive semidefinite"));
  CHECK_THAT(message(I, I, I, 0 * I), ContainsSubstring("R is not positive definite"));
  MatrixXd indefinite(2, 2), skew(2, 2);
  indefinite << 0, 1, 1, 0;
  skew << 1, 1e-6, 0, 1;
  CHECK_THAT(message(0.5 * I2, e2, indefinite, I), ContainsSubstring("Q is not positive semidefinite"));
  CHECK_THAT(message(0.5 * I2, e2, Vector2d(1e9, -1e-9).asDiagonal(), I),
             ContainsSubstring("Q is not positive semidefinite"));
  CHECK_THAT(message(0.5 * I2, e2, skew, I), ContainsSubstring("Q is not symmetric"));
  CHECK_THAT(message(0.5 * I2, I2, I2, skew), ContainsSubstring("R is not symmetric"));
}

}  // namespace enamel::test_riccati_cases
