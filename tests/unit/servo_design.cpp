#include "enamel/control/servo_design.hpp"

#include "enamel/control/discretise.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/control/riccati.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"

namespace enamel::test_servo_design {

using namespace enamel::test;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_CASE("the servo of the reference plant agrees with an independent program") {
  const ServoDesign design = designServo(referencePlant(), 1e-3, ServoWeights{});
  // The project's limit; the stored numbers are accurate to 8e-14 (see the test of riccati).
  CHECK(relativeError(design.augmented.A, reference("Ad")) < 1e-12);
  CHECK(relativeError(design.augmented.B, reference("Bd")) < 1e-12);
  CHECK(relativeError(design.P, reference("P")) < 1e-12);
  CHECK(relativeError(design.K, reference("K")) < 1e-12);
  CHECK(spectralRadius(design.augmented.A - design.augmented.B * design.K) == Approx(0.9582).margin(5e-5));
}

TEST_CASE("a servo may be designed in other units of time") {
  // In milliseconds, rates and integrals scale with the unit of time; torque does not. The weight of q' becomes 1e6
  // times as large, that of the integral 1e-6, and the total cost is unchanged.
  const StateSpace plant = referencePlant();
  const ServoDesign seconds = designServo(plant, 1e-3, ServoWeights{});
  VectorXd toMilliseconds(12);
  toMilliseconds << VectorXd::Constant(6, 1e-3), VectorXd::Ones(6);
  const VectorXd back = toMilliseconds.cwiseInverse();
  const StateSpace slow{1e-3 * (toMilliseconds.asDiagonal() * plant.A * back.asDiagonal()),
                        1e-3 * (toMilliseconds.asDiagonal() * plant.B)};
  const ServoDesign milliseconds = designServo(slow, 1.0, {1e6, 1e3, 1e1, 1.0});
  VectorXd units(18);
  units << toMilliseconds, VectorXd::Constant(6, 1e3);
  CHECK(relativeError(milliseconds.K * units.asDiagonal(), seconds.K) < 1e-12);  // rounding of the scaled data
  CHECK(relativeError(units.asDiagonal() * milliseconds.P * units.asDiagonal(), seconds.P) < 1e-12);
}

TEST_CASE("a common factor of all weights changes nothing") {
  const ServoDesign one = designServo(referencePlant(), 1e-3, ServoWeights{});
  const ServoDesign other = designServo(referencePlant(), 1e-3, {1e-5, 1e-2, 1e2, 1e-5});
  CHECK(relativeError(other.K, one.K) < 1e-12);
}

TEST_CASE("the servo for a delay is the optimal one of the plant with the commands under way") {
  const StateSpace plant{(Eigen::Matrix2d() << -0.5, -40.0, 1.0, 0.0).finished(), Eigen::Vector2d(2.0, 0.0)};
  const ServoDesign design = designServo(plant, 1e-2, {1.0, 1e2, 1e3, 1.0});
  for (const int delay : {1, 2, 3}) {
    // x(j + 1) = A x + B c_d, c_(i + 1) (j + 1) = c_i, c_1 (j + 1) = u.
    const Eigen::Index n = 3 + delay;
    MatrixXd A = MatrixXd::Zero(n, n), B = MatrixXd::Zero(n, 1);
    A.topLeftCorner(3, 3) = design.augmented.A;
    A.block(0, n - 1, 3, 1) = design.augmented.B;
    for (Eigen::Index i = 4; i < n; ++i) A(i, i - 1) = 1.0;
    B(3, 0) = 1.0;
    VectorXd q = VectorXd::Zero(n);
    q.head(3) << 1.0, 1e2, 1e3;
    const MatrixXd optimal = solveRiccati(A, B, q.asDiagonal(), MatrixXd::Identity(1, 1)).K;
    const DelayedServo servo = servoForDelay(design, delay);
    MatrixXd K(1, n);
    K << servo.K, servo.commandGain;
    CHECK(relativeError(K, optimal) < 1e-9);  // of two solutions of the Riccati equation
    CHECK(spectralRadius(A - B * K) < 1.0);
  }
  CHECK(servoForDelay(design, 0).K == design.K);
  CHECK(servoForDelay(design, 0).commandGain.size() == 0);
  CHECK_THROWS_AS(servoForDelay(design, -1), DesignError);
}

TEST_CASE("integrals: xi' = -q, and the running loop updates them as a tick does") {
  const StateSpace plant = referencePlant();
  const StateSpace augmented = augmentWithIntegrals(plant);
  VectorXd x = VectorXd::LinSpaced(18, 1.0, 18.0);
  const VectorXd u = VectorXd::LinSpaced(6, -1.0, 1.0), rate = augmented.A * x + augmented.B * u;
  CHECK(relativeError(rate.head(12), plant.A * x.head(12) + plant.B * u) < 1e-15);
  CHECK(rate.tail(6) == -x.segment(6, 6));
  const ServoDesign design = designServo(plant, 1e-3, ServoWeights{});
  const StateSpace loop = runningLoop(design), held = zeroOrderHold(plant, 1e-3);
  const VectorXd next = loop.A * x + loop.B * u;
  CHECK(relativeError(next.head(12), held.A * x.head(12) + held.B * u) < 1e-15);
  CHECK(relativeError(next.tail(6), x.tail(6) - 1e-3 * x.segment(6, 6)) < 1e-15);
}

TEST_CASE("unusable plants and weights are refused") {
  const StateSpace plant = referencePlant();
  const StateSpace odd{plant.A, plant.B.leftCols(5)};
  CHECK_THROWS_AS(designServo(odd, 1e-3, ServoWeights{}), DesignError);
  CHECK_THROWS_AS(designServo(plant, -1e-3, ServoWeights{}), DesignError);
  CHECK_THROWS_AS(designServo(plant, 1e-3, {-1.0, 1e3, 1e7, 1.0}), DesignError);
  CHECK_THROWS_AS(designServo(plant, 1e-3, {1.0, 1e3, NAN, 1.0}), DesignError);
  CHECK_THROWS_AS(designServo(plant, 1e-3, {1.0, 1e3, 1e7, 0.0}), DesignError);
  // Integrals without cost cannot be stabilised without cost: their modes stay on the unit circle.
  CHECK_THROWS_AS(designServo(plant, 1e-3, {1.0, 1e3, 0.0, 1.0}), DesignError);
  const StateSpace dead{plant.A, 0.0 * plant.B};
  CHECK_THROWS_WITH(designServo(dead, 1e-3, ServoWeights{}), test::ContainsSubstring("not stabilisable"));
}

}  // namespace enamel::test_servo_design
