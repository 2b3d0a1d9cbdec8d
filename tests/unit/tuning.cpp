#include "enamel/control/tuning.hpp"

#include <cmath>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "support/tune_problem.hpp"

namespace enamel::test_tuning {

using namespace enamel::test;

TEST_CASE("the paper's weights, evaluated") {
  const TuneProblem problem = nominalProblem();
  const auto exact = evaluateServo(problem, 0, ServoWeights{});
  REQUIRE(exact);
  CHECK(exact->stiffness == Approx(12.0 / 0.4529325e-3).epsilon(0.01));  // from an independent program
  CHECK(exact->toleratedDelay == 1);
  // Found independently: with velocities from encoder differences they chatter with 1.6 N m at a delay of 1.
  const auto late = evaluateServo(problem, 1, ServoWeights{});
  REQUIRE(late);
  CHECK(late->chatter == Approx(1.6).margin(0.1));
  CHECK(exact->chatter < 0.05);
  CHECK_FALSE(evaluateServo(problem, 2, ServoWeights{}));
}

TEST_CASE("a plant of wrong size is an error, not a servo that nothing meets") {
  TuneProblem problem = nominalProblem();
  problem.plant.B.conservativeResize(Eigen::NoChange, 5);
  CHECK_THROWS_AS(evaluateServo(problem, 0, ServoWeights{}), DesignError);
  CHECK_THROWS_AS(tuneServo(problem, TuneRequirements{}), DesignError);
}

TEST_CASE("the limit of the first impact, at home for 15 N") {
  const DevicePlant plant = devicePlant(std::make_shared<TauMechanism>(nominal()), Pose{});
  const auto limit = [&plant](int delay) {
    return firstImpactLimit(plant.effectiveMass, 1e-3, delay, 15.0, plant.largestForce);
  };
  // Found independently: 420, 106, 47 and 26 kN/m; F_max between 58 and 70 N over the wall.
  CHECK(plant.largestForce > 58.0);
  CHECK(plant.largestForce < 70.0);
  CHECK(limit(0) == Approx(420e3).epsilon(0.01));
  CHECK(limit(1) == Approx(106e3).epsilon(0.01));
  CHECK(limit(2) == Approx(47e3).epsilon(0.01));
  CHECK(limit(3) == Approx(26e3).epsilon(0.02));
  CHECK(firstImpactLimit(0.3, 1e-3, 0, 15.0, 10.0) == 0.0);
  CHECK(firstImpactLimit(0.3, 1e-3, 0, 5.0, 10.0, 12.0) == 0.0);
  // A preload before the step leaves a smaller step.
  CHECK(firstImpactLimit(0.3, 1e-3, 0, 15.0, 50.0, 1.0) ==
        Approx(firstImpactLimit(0.3, 1e-3, 0, 15.0, 50.0) * 50.0 / 49.0).epsilon(1e-14));
  // Bang-bang control reaches it: free for t1, then braked by F_max - F.
  const double m = 0.3, F = 15.0, brake = 50.0 - F, t1 = 2e-3, v = F / m * t1;
  const double depth = 0.5 * F / m * t1 * t1 + 0.5 * m * v * v / brake;
  CHECK(firstImpactLimit(m, 1e-3, 1, F, 50.0) == Approx(F / depth));
}

}  // namespace enamel::test_tuning
