// Search of the best spring.
#include "enamel/study/best_spring.hpp"

#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_best_spring {

namespace {

StudyPlan plan(int delay) {
  StudyPlan plan;
  plan.scenarios = {1};
  plan.grid = 1;
  plan.runs = 8;
  plan.insideTick = true;
  plan.lowestForce = 1.0;
  plan.highestForce = 2.0;
  plan.setup.delay = {delay, delay};
  plan.setup.duration = 1.8;
  plan.setup.encoders = {true, RateSource::difference};
  plan.setup.hand.preload = 0.13;
  plan.setup.hand.noise = 0.06;
  StudyColumn column;
  column.name = "device";
  column.plant = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  plan.columns = {column};
  return plan;
}

struct Judged {
  double stiffness = 0.0;  // mean K_d of the runs that are not lost, N/m
  int lost = 0;
};

Judged judge(StudyPlan plan, const ImpedanceOptions& spring) {
  plan.columns[0].make = [&](std::size_t) { return std::make_unique<ImpedanceRenderer>(spring); };
  Judged judged;
  std::vector<double> measured;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const StudyResult run = performRun(plan, runAt(plan, i));
    judged.lost += isLost(run);
    if (!isLost(run)) measured.push_back(run.metrics.depthStiffness.value());
  }
  if (!measured.empty()) judged.stiffness = spreadOf(measured).mean;
  return judged;
}

}  // namespace

TEST_CASE("no other spring is stiffer than the best one", "[best_spring]") {
  for (const int delay : {0, 2}) {
    const BestSpring best = findBestSpring(plan(delay), 0, 1);
    const Judged here = judge(plan(delay), best.spring);
    INFO("delay " << delay << ": " << best.spring.stiffness << " N/m, " << best.spring.damping << " N s/m, K_d "
                  << best.stiffness << " N/m in the search, " << here.stiffness << " N/m here");
    REQUIRE(best.stiffness > 0.0);
    CHECK(here.stiffness != best.stiffness);                       // other random numbers
    CHECK(here.stiffness == Approx(best.stiffness).epsilon(0.2));  // means of 8 pushes that deviate by up to a fifth
    for (const double k : {0.5, 0.8, 1.25, 2.0, 4.0})
      for (const double b : {0.5, 0.8, 1.0, 1.25, 2.0})
        if (const Judged other = judge(plan(delay), {k * best.spring.stiffness, b * best.spring.damping});
            other.lost == 0)
          CHECK(other.stiffness < 1.2 * best.stiffness);
  }
}

TEST_CASE("the best spring does not depend on the threads, and gets softer with a delay", "[best_spring]") {
  const BestSpring alone = findBestSpring(plan(1), 0, 1), together = findBestSpring(plan(1), 0, 3);
  CHECK(alone.spring.stiffness == together.spring.stiffness);
  CHECK(alone.spring.damping == together.spring.damping);
  CHECK(alone.stiffness == together.stiffness);
  CHECK(alone.stiffness < findBestSpring(plan(0), 0, 1).stiffness);
}

TEST_CASE("without a spring that holds every push, the search finds none", "[best_spring]") {
  StudyPlan strong = plan(0);
  strong.lowestForce = strong.highestForce = 500.0;  // above the motors
  CHECK(findBestSpring(strong, 0, 1).stiffness == 0.0);
}

}  // namespace enamel::test_best_spring
