#include "enamel/control/linearise.hpp"

#include <cmath>

#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/run_length.hpp"

namespace enamel::test_linearise {

using namespace enamel::test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::ContainsSubstring;

namespace {

OutputFunction identity() {
  return [](const VectorXd& x) { return x; };
}

// x' = sum of random sines and exponentials of linear forms, with its Jacobians.
struct SmoothPlant {
  MatrixXd a, b, c, d;
  SmoothPlant(std::mt19937_64& random, Index n, Index m)
      : a(randomMatrix(random, n, n)),
        b(randomMatrix(random, n, m)),
        c(randomMatrix(random, n, n)),
        d(randomMatrix(random, n, m)) {}
  VectorXd operator()(const VectorXd& x, const VectorXd& u) const {
    return (a * x + b * u).array().sin() + (c * x + d * u).array().exp();
  }
  void jacobians(const VectorXd& x, const VectorXd& u, MatrixXd& A, MatrixXd& B) const {
    const VectorXd cosine = (a * x + b * u).array().cos(), exponential = (c * x + d * u).array().exp();
    A = cosine.asDiagonal() * a + exponential.asDiagonal() * c;
    B = cosine.asDiagonal() * b + exponential.asDiagonal() * d;
  }
};

std::string refusal(const std::function<void()>& run) {
  try {
    run();
  } catch (const DesignError& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("smooth plants are linearised to rounding, and the estimate tells the error") {
  for (int seed = 1; seed <= count(30, 1000); ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(static_cast<std::uint64_t>(seed));
    const Index n = 1 + seed % 7, m = 1 + seed % 3;
    const SmoothPlant plant(random, n, m);
    const VectorXd x = 2.0 * randomMatrix(random, n, 1), u = 2.0 * randomMatrix(random, m, 1);
    const Linearisation result = linearise(plant, identity(), x, u);
    MatrixXd A, B;
    plant.jacobians(x, u, A, B);
    const double error = std::max(relativeError(result.model.A, A), relativeError(result.model.B, B));
    // Rounding in f (1e-16 of values up to e^14, with slopes of order 1) over steps of about 0.03.
    CHECK(error < 1e-11);
    CHECK(relativeError(result.C, MatrixXd::Identity(n, n)) < 1e-14);
    // Ridders' estimate is the size of the last change: right to a small factor, and not a hundred times too large.
    CHECK(error < 10.0 * result.error + 1e-15);
    CHECK(result.error < 1e-10);
    CHECK(result.offset == plant(x, u));
  }
}

TEST_CASE("the step adapts to the plant's own scale") {
  for (const double scale : {1e-6, 1e-3, 1.0, 1e3}) {  // of the variable over which the plant bends
    INFO("scale " << scale);
    const auto f = [scale](const VectorXd& x, const VectorXd&) { return VectorXd((x / scale).array().tanh()); };
    const double at = 0.3 * scale, exact = 1.0 / (scale * std::cosh(0.3) * std::cosh(0.3));
    const Linearisation result = linearise(f, identity(), VectorXd::Constant(1, at), VectorXd(0));
    const double error = std::abs(result.model.A(0, 0) / exact - 1.0);
    CHECK(error < 1e-14 * std::max(1.0, 1.0 / scale) + 1e-12);  // rounding over a step of a tenth of the scale
    CHECK(error < 10.0 * result.error + 1e-15);
  }
}

TEST_CASE("rounding inside the plant is not taken for accuracy") {
  // The output is a small difference of large numbers: at tiny steps its quotients are multiples of a coarse step and
  // repeat exactly.
  const auto f = [](const VectorXd& x, const VectorXd&) {
    return VectorXd::Constant(1, std::atan2(1.0 + x[0], 3.0) - std::atan2(1.0, 3.0));
  };
  const Linearisation result = linearise(f, identity(), VectorXd::Zero(1), VectorXd(0));
  CHECK(std::abs(result.model.A(0, 0) - 0.3) < 1e-13);
}

TEST_CASE("a plant may be undefined outside a small neighbourhood") {
  const auto f = [](const VectorXd& x, const VectorXd&) {
    return VectorXd::Constant(1, std::sqrt(1e-4 - x[0] * x[0]));
  };
  const Linearisation result = linearise(f, identity(), VectorXd::Constant(1, 5e-3), VectorXd(0));
  CHECK(std::abs(result.model.A(0, 0) + 1.0 / std::sqrt(3.0)) < 1e-10);
}

TEST_CASE("plants that cannot be linearised are refused") {
  const VectorXd x = VectorXd::Zero(2), u = VectorXd::Zero(1);
  const auto good = [](const VectorXd& at, const VectorXd&) { return at; };
  const auto bad = [](const VectorXd& at, const VectorXd&) { return VectorXd(NAN * at.array() + NAN); };
  const auto isolated = [](const VectorXd& at, const VectorXd&) {
    return at.isZero(0.0) ? at : VectorXd(VectorXd::Constant(2, NAN));
  };
  const auto tooLong = [](const VectorXd&, const VectorXd&) { return VectorXd(VectorXd::Zero(3)); };
  CHECK_THAT(refusal([&] { linearise(bad, identity(), x, u); }),
             ContainsSubstring("not finite at the operating point"));
  CHECK_THAT(refusal([&] { linearise(isolated, identity(), x, u); }), ContainsSubstring("not finite near"));
  CHECK_THAT(refusal([&] { linearise(tooLong, identity(), x, u); }), ContainsSubstring("3 entries"));
  CHECK_THAT(refusal([&] { linearise(good, identity(), NAN * x.array() + NAN, u); }),
             ContainsSubstring("operating point"));
}

TEST_CASE("outputs as states: eq. 5 keeps the input-output behaviour") {
  std::mt19937_64 random(11);
  for (int i = 0; i < 20; ++i) {
    INFO("draw " << i);
    Linearisation l;
    l.model = {randomMatrix(random, 6, 6), randomMatrix(random, 6, 2)};
    l.C = randomMatrix(random, 6, 6);
    const StateSpace y = outputsAsStates(l);
    // The Markov parameters C A^k B must equal those of the new states; the tolerance includes the condition of C.
    MatrixXd old = l.model.B, now = y.B;
    for (int k = 0; k < 5; ++k) {
      CHECK(relativeError(now, l.C * old) < 1e-10);
      old = l.model.A * old;
      now = y.A * now;
    }
  }
}

TEST_CASE("eq. 5 refuses a singular C, whatever the units, and accepts extreme units") {
  Linearisation l;
  l.model = {MatrixXd::Identity(3, 3), MatrixXd::Ones(3, 1)};
  l.C = MatrixXd::Identity(3, 3);
  l.C(0, 0) = 1e-9, l.C(2, 2) = 1e9;  // nanometres and gigahertz
  CHECK(relativeError(outputsAsStates(l).A, MatrixXd::Identity(3, 3)) < 1e-15);
  l.C << 1, 2, 3, 2, 4, 6, 0, 0, 1;
  CHECK_THAT(refusal([&] { outputsAsStates(l); }), ContainsSubstring("C is singular"));
  l.C << 1, 0, 0, 0, 0, 0, 0, 0, 1;
  CHECK_THAT(refusal([&] { outputsAsStates(l); }), ContainsSubstring("C is singular"));
  l.C << 1, 0, 1, 1, 0, 0, 0, 0, 1;
  CHECK_THAT(refusal([&] { outputsAsStates(l); }), ContainsSubstring("no output shows state 1"));
  l.C = MatrixXd::Identity(2, 3);
  CHECK_THAT(refusal([&] { outputsAsStates(l); }), ContainsSubstring("2 x 3"));
}

}  // namespace enamel::test_linearise
