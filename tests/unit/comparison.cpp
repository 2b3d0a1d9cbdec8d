// Scores and ranks of compared renderers.
#include "enamel/study/comparison.hpp"

#include <cmath>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_comparison {

namespace {

StudyPlan springs(const std::vector<double>& stiffnesses) {
  StudyPlan plan;
  plan.grid = 1;
  plan.runs = 2;
  plan.setup.delay = {1, 1};
  for (const double stiffness : stiffnesses)
    plan.columns.push_back(
        {"spring", makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml"))), [stiffness](std::size_t) {
           return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{stiffness, 20.0});
         }});
  return plan;
}

StudyResult result(std::size_t column, int scenario, double depth, double stiffness) {
  StudyResult r;
  r.run.column = column;
  r.run.scenario = scenario;
  r.metrics.largestDepth = depth;
  if (stiffness > 0.0) r.metrics.firstStiffness = stiffness;
  r.metrics.verdict = FirstImpactVerdict::measured;
  return r;
}

}  // namespace

TEST_CASE("scores separate scenarios and leave out what was lost") {
  const StudyPlan plan = springs({1000.0, 2000.0});
  std::vector<StudyResult> runs = {result(0, 1, 1e-3, 5e3), result(0, 1, 3e-3, 0.0), result(0, 2, 9e-3, 0.0),
                                   result(1, 1, 2e-3, 4e3), result(1, 1, 8e-3, 4e3), result(1, 1, 7e-3, 6e3)};
  runs[0].metrics.limitShare = 0.5;
  runs[0].metrics.work = -1.0;  // absorbs energy, so it gives none
  runs[1].metrics.work = 4.0;
  runs[4].status = Status::stopped;
  runs[5].metrics.verdict = FirstImpactVerdict::unstable;
  const std::vector<RendererScore> scores = scoresOf(plan, runs);
  REQUIRE(scores.size() == 2);
  CHECK(scores[0].runs == 3);
  CHECK(scores[0].lost == 0);
  CHECK(scores[0].stiffness == std::vector<double>{5e3});
  CHECK(scores[0].depth == std::vector<double>{1e-3, 3e-3});
  CHECK(scores[0].depthOfHand == std::vector<double>{9e-3});
  CHECK(scores[0].share == 0.25);
  CHECK(scores[0].energy == 2.0);
  CHECK(scores[1].lost == 2);
  CHECK(scores[1].depth == std::vector<double>{2e-3});
  CHECK(std::isnan(scoresOf(plan, {}).front().chatter));
}

TEST_CASE("ranks: equal ones share, what is not felt is equal, and lost runs come last") {
  std::vector<RendererScore> scores(3);
  for (RendererScore& s : scores) {
    s.chatter = s.energy = 0.0;
    s.depth = {1e-3};
    s.share = 0.5;
  }
  const auto places = [&] {
    rankRenderers(scores);
    double sum = 0.0;
    for (const RendererScore& s : scores) sum += s.rank;
    CHECK(sum == Approx(1.0 + 2.0 + 3.0));
  };
  places();
  for (const RendererScore& s : scores) CHECK(s.rank == Approx(2.0));
  scores[0].chatter = 0.049;  // N m: below what a hand feels
  places();
  CHECK(scores[0].rank == Approx(2.0));
  scores[0].chatter = 0.06;  // last in one of six: rank 3 instead of 2
  places();
  CHECK(scores[0].rank == Approx(2.0 + 1.0 / 6.0));
  scores[2].share = 0.9;  // more is better
  places();
  CHECK(bestOf(scores) == 2);
  scores[2].lost = 1;
  places();
  CHECK(scores[2].rank == Approx(3.0));
  CHECK(bestOf(scores) == 1);
}

TEST_CASE("wall trials of a comparison are those of the library, on the columns' plants") {
  const StudyPlan plan = springs({1000.0, 2000.0});
  std::vector<RendererScore> scores = scoresOf(plan, {});
  addWallTrials(plan, {"ramp", "release"}, 2, scores);
  WallTrialSetup setup;
  setup.plant = setup.model = plan.columns[1].plant;
  setup.renderer = [&plan] { return plan.columns[1].make(0); };
  setup.delay = {1, 1};
  setup.runs = 2;
  for (const WallFigure& figure : runWallTrials(setup, "release", 2)) {
    INFO(figure.figure);
    REQUIRE(figure.lost == 0);
    CHECK(scores[1].figure("release", figure.figure) == figure.value);
  }
  CHECK(scores[0].figure("ramp", "depth") > scores[1].figure("ramp", "depth"));
  CHECK(std::isnan(scores[0].figure("slide", "rms depth")));
  scores[0].trials.front().lost = 1;
  CHECK(std::isinf(scores[0].figure("ramp", "depth")));
}

}  // namespace enamel::test_comparison
