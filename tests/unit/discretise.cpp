#include "enamel/control/discretise.hpp"

#include "enamel/control/servo_design.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/run_length.hpp"

namespace enamel::test_discretise {

using namespace enamel::test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_CASE("the exponential of a matrix with known eigenvectors") {
  for (int seed = 1; seed <= count(50, 2000); ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const Index n = 1 + seed % 20;
    // Orthogonal eigenvectors: the exponential is as well conditioned as its entries.
    MatrixXd V = MatrixXd::Identity(n, n);
    for (Index i = 0; i < n; ++i) {  // reflections
      const VectorXd way = randomMatrix(random, n, 1).normalized();
      V -= 2.0 * way * (way.transpose() * V);
    }
    const VectorXd lambda = 5.0 * randomMatrix(random, n, 1);
    const MatrixXd E = matrixExponential(V * lambda.asDiagonal() * V.transpose());
    const VectorXd exponentials = lambda.array().exp();
    CHECK(relativeError(E, V * exponentials.asDiagonal() * V.transpose()) < 2e-14);
  }
}

TEST_CASE("e^A e^-A = I and e^2A = (e^A)^2") {
  for (int seed = 1; seed <= count(50, 2000); ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const Index n = 1 + seed % 12;
    const MatrixXd A = randomMatrix(random, n, n), E = matrixExponential(A);
    // Rounding, amplified by |e^A| |e^-A|, up to e^{2 sqrt n}.
    CHECK((E * matrixExponential(-A) - MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff() < 1e-11);
    CHECK(relativeError(matrixExponential(2.0 * A), E * E) < 1e-12);
  }
}

TEST_CASE("the zero-order hold agrees with a fine integration") {
  for (int seed = 1; seed <= count(20, 500); ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const Index n = 2 + seed % 6, m = 1 + seed % 3;
    const StateSpace plant{3.0 * randomMatrix(random, n, n), randomMatrix(random, n, m)};
    const double period = 0.5;
    const StateSpace held = zeroOrderHold(plant, period);
    VectorXd x = randomMatrix(random, n, 1), start = x;
    const VectorXd u = randomMatrix(random, m, 1);
    const int steps = 2000;
    const double h = period / steps;
    const auto f = [&](const VectorXd& at) { return VectorXd(plant.A * at + plant.B * u); };
    for (int i = 0; i < steps; ++i) {  // Runge-Kutta of order four: error about (|A| h)^4 = 1e-12
      const VectorXd k1 = f(x), k2 = f(x + 0.5 * h * k1), k3 = f(x + 0.5 * h * k2), k4 = f(x + h * k3);
      x += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    }
    CHECK(relativeError(held.A * start + held.B * u, x) < 1e-10);
  }
}

TEST_CASE("two half periods make a period; time and states may be rescaled") {
  for (int seed = 1; seed <= count(20, 500); ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const Index n = 2 + seed % 6;
    const StateSpace plant{randomMatrix(random, n, n), randomMatrix(random, n, 2)};
    const StateSpace whole = zeroOrderHold(plant, 1.0), half = zeroOrderHold(plant, 0.5);
    CHECK(relativeError(half.A * half.A, whole.A) < 1e-14);  // a few rounding errors
    CHECK(relativeError(half.A * half.B + half.B, whole.B) < 1e-14);
    const StateSpace faster = zeroOrderHold({1e3 * plant.A, 1e3 * plant.B}, 1e-3);
    CHECK(relativeError(faster.A, whole.A) < 1e-14);
    CHECK(relativeError(faster.B, whole.B) < 1e-14);
    const VectorXd t = (3.0 * randomMatrix(random, n, 1)).array().exp(), inverse = t.cwiseInverse();  // units
    const StateSpace scaled =
        zeroOrderHold({t.asDiagonal() * plant.A * inverse.asDiagonal(), t.asDiagonal() * plant.B}, 1.0);
    CHECK(relativeError(inverse.asDiagonal() * scaled.A * t.asDiagonal(), whole.A) <
          1e-12);  // scales differ by up to e^6
    CHECK(relativeError(inverse.asDiagonal() * scaled.B, whole.B) < 1e-12);
  }
}

TEST_CASE("the augmented servo plant, held for 1 ms, agrees with an independent program") {
  const StateSpace held = zeroOrderHold(augmentWithIntegrals(referencePlant()), 1e-3);
  // SciPy's exponential. Compared in quadruple precision, its errors are 3e-17 and 2e-16; ours are 3e-17 and 3e-16.
  CHECK(relativeError(held.A, reference("Ad")) < 1e-15);
  CHECK(relativeError(held.B, reference("Bd")) < 1e-15);
}

}  // namespace enamel::test_discretise
