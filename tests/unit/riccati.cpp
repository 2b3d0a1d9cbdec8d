#include "enamel/control/riccati.hpp"

#include <Eigen/Cholesky>

#include "control/dense.hpp"
#include "enamel/control/margins.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/run_length.hpp"

namespace enamel::test_riccati {

using namespace enamel::test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

struct System {
  MatrixXd A, B, Q, R;
};

// Random sizes, Q of any rank, spectral radius up to about 3: stabilisable and detectable with probability one. At most
// four states per input: with one input for nine unstable states, P is 1e14, and the solver finds no initial gain.
System randomSystem(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const Index m = 1 + static_cast<Index>(random() % 4), n = 1 + static_cast<Index>(random() % 4) * m;
  const Index rank = 1 + static_cast<Index>(random() % static_cast<std::uint64_t>(n));
  const MatrixXd C = randomMatrix(random, rank, n), D = randomMatrix(random, m, m);
  return {1.5 * randomMatrix(random, n, n), randomMatrix(random, n, m), C.transpose() * C,
          D.transpose() * D + 0.1 * MatrixXd::Identity(m, m)};
}

RiccatiSolution solve(const System& s) { return solveRiccati(s.A, s.B, s.Q, s.R); }

// Return the cost of u = -K x from x over many steps.
double costOf(const System& s, const MatrixXd& K, VectorXd x) {
  double cost = 0.0;
  for (int j = 0; j < 100000; ++j) {
    const VectorXd u = -K * x;
    const double step = x.dot(s.Q * x) + u.dot(s.R * u);
    cost += step;
    x = s.A * x + s.B * u;
    if (x.squaredNorm() < 1e-40) break;
  }
  return cost;
}

}  // namespace

TEST_CASE("random equations: residual, symmetry, P >= 0, stability") {
  for (int seed = 1; seed <= count(200, 20000); ++seed) {
    INFO("seed " << seed);
    const System s = randomSystem(static_cast<std::uint64_t>(seed));
    const RiccatiSolution r = solve(s);
    using Long = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
    const Long A = s.A.cast<long double>(), B = s.B.cast<long double>(), P = r.P.cast<long double>();
    const auto times = [](const Long& a, const Long& b) -> Long { return a.lazyProduct(b); };
    const Long PA = times(P, A), N = times(B.transpose(), PA);
    const Long M = s.R.cast<long double>() + times(B.transpose(), times(P, B));
    const Long residual =
        times(A.transpose(), PA) - times(N.transpose(), M.ldlt().solve(N)) + s.Q.cast<long double>() - P;
    // Rounding P by E leaves S^T E S - E with S = A - B K: n eps of these terms. 80 bits add about 1e-16.
    const MatrixXd S = (s.A - s.B * r.K).cwiseAbs();
    const double scale =
        product(product(S.transpose(), MatrixXd(r.P.cwiseAbs())), S).maxCoeff() + r.P.cwiseAbs().maxCoeff();
    CHECK(static_cast<double>(residual.cwiseAbs().maxCoeff()) < 1e-14 * scale);
    CHECK(r.P == r.P.transpose());
    // Semidefinite except for rounding; the largest eigenvalue is not below any diagonal entry.
    const MatrixXd shift = 1e-13 * r.P.diagonal().maxCoeff() * MatrixXd::Identity(r.P.rows(), r.P.cols());
    CHECK((r.P + shift).llt().info() == Eigen::Success);
    CHECK(spectralRadius(s.A - s.B * r.K) < 1.0);
  }
}

TEST_CASE("P is the cost-to-go of a simulated trajectory") {
  for (int seed = 1; seed <= count(50, 2000); ++seed) {
    INFO("seed " << seed);
    const System s = randomSystem(static_cast<std::uint64_t>(seed));
    const RiccatiSolution r = solve(s);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) + 1000);
    const VectorXd x = randomMatrix(random, s.A.rows(), 1);
    // A sum of positive terms: rounding only.
    CHECK(costOf(s, r.K, x) == Approx(x.dot(r.P * x)).epsilon(1e-9));
  }
}

TEST_CASE("no perturbed gain costs less") {
  for (int seed = 1; seed <= count(10, 200); ++seed) {
    const System s = randomSystem(static_cast<std::uint64_t>(seed));
    const RiccatiSolution r = solve(s);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) + 2000);
    const VectorXd x = randomMatrix(random, s.A.rows(), 1);
    const double best = costOf(s, r.K, x);
    for (int i = 0; i < 100; ++i) {
      INFO("seed " << seed << ", perturbation " << i);
      MatrixXd change = 0.1 * std::max(r.K.cwiseAbs().maxCoeff(), 1e-3) * randomMatrix(random, r.K.rows(), r.K.cols());
      while (spectralRadius(s.A - s.B * (r.K + change)) > 0.999) change *= 0.5;  // else its cost is infinite, or nearly
      CHECK(costOf(s, r.K + change, x) > best * (1.0 - 1e-13));                  // rounding of the sum
    }
  }
}

TEST_CASE("units of states, inputs and cost do not matter") {
  for (int seed = 1; seed <= count(50, 2000); ++seed) {
    INFO("seed " << seed);
    const System s = randomSystem(static_cast<std::uint64_t>(seed));
    const RiccatiSolution r = solve(s);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed) + 3000);
    const VectorXd t = (10.0 * randomMatrix(random, s.A.rows(), 1)).array().exp();  // x = diag(t) z: 1e-4 to 1e4
    const VectorXd v = (10.0 * randomMatrix(random, s.B.cols(), 1)).array().exp();  // u = diag(v) w
    const double c = 1e7;                                                           // cost in another unit
    const VectorXd ti = t.cwiseInverse(), vi = v.cwiseInverse();
    const System scaled{ti.asDiagonal() * s.A * t.asDiagonal(), ti.asDiagonal() * s.B * v.asDiagonal(),
                        c * (t.asDiagonal() * s.Q * t.asDiagonal()), c * (v.asDiagonal() * s.R * v.asDiagonal())};
    // The scaled data are rounded: 1e-16, amplified by the condition of the equation.
    CHECK(relativeError(ti.asDiagonal() * solve(scaled).P * ti.asDiagonal() / c, r.P) < 1e-9);
    CHECK(relativeError(v.asDiagonal() * solve(scaled).K * ti.asDiagonal(), r.K) < 1e-9);
  }
}

TEST_CASE("states that cost nothing and feed nothing are accepted where they are stable") {
  MatrixXd A(2, 2), B(2, 1);
  A << 1.2, 0.0, 0.0, 0.5;
  B << 1.0, 0.0;
  const MatrixXd Q = Eigen::Vector2d(1.0, 0.0).asDiagonal();
  const RiccatiSolution r = solveRiccati(A, B, Q, MatrixXd::Identity(1, 1));
  CHECK(r.P(1, 1) == 0.0);
  CHECK(r.K(0, 1) == 0.0);
  const double p = r.P(0, 0);
  CHECK(p == Approx(1.44 * p - 1.44 * p * p / (1.0 + p) + 1.0).epsilon(1e-14));
}

TEST_CASE("the servo's equation agrees with an independent program") {
  VectorXd q(18);
  q << VectorXd::Constant(6, 1.0), VectorXd::Constant(6, 1e3), VectorXd::Constant(6, 1e7);
  const RiccatiSolution r = solveRiccati(reference("Ad"), reference("Bd"), q.asDiagonal(), MatrixXd::Identity(6, 6));
  // The stored P and K are SciPy's. In quadruple precision their errors are 6e-14 and 8e-14; ours are 1e-33 and 5e-16.
  CHECK(relativeError(r.P, reference("P")) < 1e-12);
  CHECK(relativeError(r.K, reference("K")) < 1e-12);
}

}  // namespace enamel::test_riccati
