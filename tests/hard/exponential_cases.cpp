// Matrices whose exponential is hard to compute: far from normal, stiff, badly scaled.
#include "bench/control_cases.hpp"
#include "enamel/control/discretise.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"

namespace enamel::test_exponential_cases {

using Eigen::MatrixXd;

TEST_CASE("hard exponentials are right entry by entry") {
  for (const bench::ExponentialCase& c : bench::exponentialCases()) {
    INFO(c.name);
    CHECK(bench::entrywiseError(matrixExponential(c.A), c.exponential) < c.bound);
  }
}

TEST_CASE("a zero-order hold over a stiff plant keeps its slow states") {
  // A motor with an electrical pole at 1e8 1/s in front of a double integrator, held for Ts. The torque follows at
  // once: q' = Ts - 1/a and q = Ts^2/2 - Ts/a + 1/a^2, except for e^{-a Ts} = 0.
  const double a = 1e8, period = 1e-3;
  MatrixXd A = MatrixXd::Zero(3, 3), B = MatrixXd::Zero(3, 1);
  A(0, 0) = -a, B(0, 0) = a, A(1, 0) = 1.0, A(2, 1) = 1.0;
  const StateSpace held = zeroOrderHold({A, B}, period);
  MatrixXd expected(3, 1);
  expected << 1.0, period - 1.0 / a, 0.5 * period * period - period / a + 1.0 / (a * a);
  CHECK(bench::entrywiseError(held.B, expected) < 1e-14);  // a few rounding errors
}

TEST_CASE("exponentials that do not exist in doubles are refused") {
  const MatrixXd I = MatrixXd::Identity(1, 1);
  CHECK_THROWS_AS(matrixExponential(MatrixXd::Zero(2, 3)), DesignError);
  CHECK_THROWS_AS(matrixExponential(NAN * I), DesignError);
  CHECK_THROWS_AS(matrixExponential(1000.0 * I), DesignError);
  CHECK(matrixExponential(-1000.0 * I)(0, 0) == 0.0);
  CHECK(matrixExponential(-1e300 * I)(0, 0) == 0.0);
  CHECK(matrixExponential(0.0 * I)(0, 0) == 1.0);
  CHECK_THROWS_AS(zeroOrderHold({I, I}, 0.0), DesignError);
  CHECK_THROWS_AS(zeroOrderHold({I, I}, NAN), DesignError);
  CHECK_THROWS_AS(zeroOrderHold({I, MatrixXd::Zero(2, 1)}, 1e-3), DesignError);
}

}  // namespace enamel::test_exponential_cases
