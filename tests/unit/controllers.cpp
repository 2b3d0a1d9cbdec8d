// The rivals: each is a renderer, their parameters are in files, and prediction of a delay keeps a hold stable.
#include "enamel/study/controllers.hpp"

#include <algorithm>
#include <filesystem>
#include <regex>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/study/wall_trials.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/pushes.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_controllers {

using test::ContainsSubstring;

namespace {

std::shared_ptr<const Mechanism> tau() { return std::make_shared<TauMechanism>(test::nominal()); }

WallDesignSetup setupFor(int delay) {
  WallDesignSetup setup;
  setup.plant = tau();
  setup.delay = {delay, delay};
  setup.runs = 2;
  return setup;
}

}  // namespace

TEST_CASE("every rival is a renderer that a wall can be pushed with") {
  WallDesignSetup setup = setupFor(0);
  setup.lowestForce = setup.ramp = 4.0;  // the search begins with a spring of 1000 N/m, and a run 20 mm inside is lost
  setup.highestForce = 8.0;
  for (const ControllerSpec& spec : rivalSpecs()) {
    INFO(spec.name);
    std::vector<double> values;
    for (const ControllerParameter& p : spec.parameters) {
      CHECK(p.low < p.start);
      CHECK(p.start < p.high);
      values.push_back(p.start);
    }
    const WallScore score = evaluateWall(setup, spec.with({tau(), 1e-3, {}}, values), 3, 2);
    CHECK(score.lost == 0);
    CHECK(score.deepest > 0.0);
    // The impact is that of the trials, with as many runs as the ramp has.
    WallTrialSetup impacts;
    impacts.plant = impacts.model = setup.plant;
    impacts.renderer = spec.with({tau(), 1e-3, {}}, values);
    impacts.runs = 1;
    impacts.seed = setup.seed + 3;
    double bounce = 0.0;
    for (const WallFigure& figure : runWallTrials(impacts, "impact", 2))
      if (figure.figure == "bounce") bounce = std::max(bounce, 1e-6 * figure.value);
    CHECK(bounce > 0.0);
    CHECK(score.impact == bounce);
  }
  CHECK_THROWS_WITH(rivalSpec("magic"), ContainsSubstring("virtual-coupling"));
}

TEST_CASE("a hold that foresees the delay survives one that the same weights do not") {
  const std::vector<double> paper = {1.0, 1e3, 1e7};
  const WallDesignSetup setup = setupFor(2);
  const ControllerUse use{setup.plant, setup.period, setup.delay};
  const WallScore blind = evaluateWall(setup, rivalSpec("hold").with(use, paper), 3, 2),
                  foresees = evaluateWall(setup, rivalSpec("hold-delay").with(use, paper), 3, 2);
  CHECK(blind.lost > 0);
  CHECK(foresees.lost == 0);
  CHECK(foresees.stiffness > 1e3);
  // Without delay there is nothing to predict.
  const ControllerUse now{setup.plant, setup.period, {}};
  WallDesignSetup without = setupFor(0);
  CHECK(evaluateWall(without, rivalSpec("hold").with(now, paper), 3, 2).stiffness ==
        evaluateWall(without, rivalSpec("hold-delay").with(now, paper), 3, 2).stiffness);
}

TEST_CASE("the search makes a spring better, and numbers that no servo has cost only themselves") {
  WallDesignSetup setup = setupFor(0);
  const ControllerSpec& spec = rivalSpec("impedance");
  std::vector<double> start, scores;
  for (const ControllerParameter& p : spec.parameters) start.push_back(p.start);
  const std::vector<double> found =
      designController(setup, spec, start, 4, 2, [&](int, const WallScore& score) { scores.push_back(score.value); });
  REQUIRE(scores.size() == 4);
  const ControllerUse use{setup.plant, setup.period, setup.delay};
  CHECK(evaluateWall(setup, spec.with(use, found), 9, 2).value >
        evaluateWall(setup, spec.with(use, start), 9, 2).value);

  // The result does not depend on the number of threads.
  setup.runs = 1;
  std::vector<std::vector<double>> bests;
  for (const int threads : {1, 3}) {
    scores.clear();
    std::vector<double> best = designController(setup, spec, start, 2, threads,
                                                [&](int, const WallScore& score) { scores.push_back(score.value); });
    best.insert(best.end(), scores.begin(), scores.end());
    bests.push_back(best);
  }
  CHECK(bests[0] == bests[1]);
  setup.runs = 2;

  ControllerSpec picky = spec;
  picky.with = [&spec](const ControllerUse& u, const std::vector<double>& values) -> MakeRenderer {
    if (values[0] > 1000.0) throw Error("too stiff");
    return spec.with(u, values);
  };
  CHECK(designController(setup, picky, start, 2, 2, {})[0] <= 1000.0);
  CHECK_THROWS_WITH(designController(setup, picky, {2000.0, 1.0}, 1, 1, {}), ContainsSubstring("too stiff"));
  CHECK_THROWS_AS(designController(setup, spec, {1.0}, 1, 1, {}), Error);
  setup.plant = nullptr;
  CHECK_THROWS_AS(designController(setup, spec, start, 1, 1, {}), Error);
}

TEST_CASE("values of controllers are a file that is read as it was written, or refused with its place") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "controllers.json";
  std::vector<ControllerValues> written;
  for (const ControllerSpec& spec : rivalSpecs()) {
    ControllerValues values{spec.name, 0, 3, {}};
    for (const ControllerParameter& p : spec.parameters) values.values.push_back(p.start / 3.0);
    written.push_back(values);
  }
  const auto same = [&] {
    const ControllerFile file = loadControllers(path);
    CHECK(file.model == "tau.toml");
    REQUIRE(file.controllers.size() == written.size());
    for (std::size_t i = 0; i < written.size(); ++i) {
      CHECK(file.controllers[i].controller == written[i].controller);
      CHECK(file.controllers[i].delayLow == 0);
      CHECK(file.controllers[i].delayHigh == 3);
      CHECK(file.controllers[i].values == written[i].values);
    }
  };
  std::string text = controllersText({"tau.toml", written});
  writeFile(path, text);
  same();
  // The keys of version 0.2.
  text = std::regex_replace(text, std::regex("\"controllers\""), "\"laws\"");
  writeFile(path, std::regex_replace(text, std::regex("\"controller\""), "\"law\""));
  same();
  const auto refuse = [&](const std::string& wrong, const std::string& why) {
    writeFile(path, wrong);
    CHECK_THROWS_WITH(loadControllers(path), ContainsSubstring(why) && ContainsSubstring("controllers.json"));
  };
  refuse("[]", "has no list \"controllers\"");
  refuse(R"({"laws": 1})", "has no list \"laws\"");
  refuse(R"({"controllers": [{"controller": "magic", "delay": [0, 0]}]})", "magic");
  refuse(R"({"controllers": [{"law": "impedance", "delay": [0, 0]}]})", "controllers[0].controller");
  refuse(R"({"controllers": [{"controller": "impedance", "delay": [2, 1], "stiffness": 1000, "damping": 1}]})",
         "controllers[0].delay");
  refuse(R"({"laws": [{"law": "impedance", "delay": [0, 0], "stiffness": 1000}]})", "laws[0].damping");
  refuse(R"({"laws": [{"law": "impedance", "delay": [0, 0], "stiffness": -1, "damping": 1}]})", "N/m");
}

}  // namespace enamel::test_controllers
