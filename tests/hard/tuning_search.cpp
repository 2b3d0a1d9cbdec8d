#include <cmath>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/control/tuning.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"
#include "support/tune_problem.hpp"

namespace enamel::test_tuning_search {

using namespace enamel::test;

TEST_CASE("a tuned servo keeps to its requirements, and its neighbours do not do better") {
  const TuneProblem problem = nominalProblem();
  double previous = HUGE_VAL;
  for (const int delay : longRun() ? std::vector<int>{0, 1, 2, 3} : std::vector<int>{1}) {
    INFO("delay " << delay);
    TuneRequirements requirements;
    requirements.delay = delay;
    const auto tuned = tuneServo(problem, requirements);
    REQUIRE(tuned);
    // Evaluate the result again with the functions themselves.
    const StateSpace loop = runningLoop(tuned->design);
    CHECK(toleratedDelay(loop, tuned->design.K) >= delay);
    CHECK(diskMargin(loop, tuned->design.K, problem.period, delay) >= requirements.diskMargin);
    const auto again = evaluateServo(problem, delay, tuned->design.weights);
    REQUIRE(again);
    CHECK(again->chatter <= requirements.chatter);
    CHECK(again->stiffness == tuned->stiffness);
    CHECK(tuned->stiffness < previous);  // delay costs stiffness
    previous = tuned->stiffness;
    for (const double factor : {0.7, 1.4})
      for (int i = 0; i < 3; ++i) {
        ServoWeights w = tuned->design.weights;
        (i == 0 ? w.velocity : i == 1 ? w.position : w.integral) *= factor;
        const auto neighbour = evaluateServo(problem, delay, w);
        CHECK((!neighbour || neighbour->stiffness <= tuned->stiffness ||
               neighbour->diskMargin < requirements.diskMargin || neighbour->chatter > requirements.chatter));
      }
  }
}

TEST_CASE("the step response of Table II is reachable and kept where it is required") {
  const TuneProblem problem = nominalProblem();
  TuneRequirements requirements;
  requirements.delay = 2;
  requirements.stepResponse = true;
  const auto tuned = tuneServo(problem, requirements);
  REQUIRE(tuned);
  const auto rows = measureRequirements(tuned->design, linearPlant(tuned->design, problem.jacobian), problem.jacobian);
  for (int i = 0; i < 3; ++i) CHECK(rows[static_cast<std::size_t>(i)].met());
}

TEST_CASE("requirements that nothing meets give nothing") {
  TuneRequirements requirements;
  requirements.diskMargin = 1.01;  // |1 + L| -> 1 is the limit
  CHECK_FALSE(tuneServo(nominalProblem(), requirements));
}

}  // namespace enamel::test_tuning_search
