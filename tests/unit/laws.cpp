// The rivals: each is a renderer, their values are files, and foreseeing a delay makes a hold survive it.
#include "enamel/study/laws.hpp"

#include <algorithm>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/study/wall_trials.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/pushes.hpp"

namespace enamel::test_laws {

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
  setup.lowestForce = setup.ramp = 4.0;  // the search begins with a spring of 1000 N/m, and 20 mm inside is lost
  setup.highestForce = 8.0;
  for (const Law& law : rivalLaws()) {
    INFO(law.name);
    std::vector<double> values;
    for (const LawParameter& p : law.parameters) {
      CHECK(p.low < p.start);
      CHECK(p.start < p.high);
      values.push_back(p.start);
    }
    const WallScore score = judgeWall(setup, law.with({tau(), 1e-3, {}}, values), 3, 2);
    CHECK(score.lost == 0);
    CHECK(score.deepest > 0.0);
    // The impact is that of the trials, on as many runs as the ramp has.
    WallTrialSetup impacts;
    impacts.plant = impacts.model = setup.plant;
    impacts.renderer = law.with({tau(), 1e-3, {}}, values);
    impacts.runs = 1;
    impacts.seed = setup.seed + 3;
    double bounce = 0.0;
    for (const WallFigure& figure : runWallTrials(impacts, "impact", 2))
      if (figure.figure == "bounce") bounce = std::max(bounce, 1e-6 * figure.value);
    CHECK(bounce > 0.0);
    CHECK(score.impact == bounce);
  }
  CHECK_THROWS_WITH(rivalLaw("magic"), ContainsSubstring("virtual-coupling"));
}

TEST_CASE("a hold that foresees the delay survives one that the same weights do not") {
  const std::vector<double> paper = {1.0, 1e3, 1e7};
  const WallDesignSetup setup = setupFor(2);
  const LawUse use{setup.plant, setup.period, setup.delay};
  const WallScore blind = judgeWall(setup, rivalLaw("hold").with(use, paper), 3, 2),
                  foresees = judgeWall(setup, rivalLaw("hold-delay").with(use, paper), 3, 2);
  CHECK(blind.lost > 0);
  CHECK(foresees.lost == 0);
  CHECK(foresees.stiffness > 1e3);
  // Without delay there is nothing to foresee.
  const LawUse now{setup.plant, setup.period, {}};
  WallDesignSetup without = setupFor(0);
  CHECK(judgeWall(without, rivalLaw("hold").with(now, paper), 3, 2).stiffness ==
        judgeWall(without, rivalLaw("hold-delay").with(now, paper), 3, 2).stiffness);
}

TEST_CASE("the search makes a spring better, and numbers that no servo has cost only themselves") {
  WallDesignSetup setup = setupFor(0);
  const Law& law = rivalLaw("impedance");
  std::vector<double> start, scores;
  for (const LawParameter& p : law.parameters) start.push_back(p.start);
  const std::vector<double> found =
      designLaw(setup, law, start, 4, 2, [&](int, const WallScore& score) { scores.push_back(score.value); });
  REQUIRE(scores.size() == 4);
  const LawUse use{setup.plant, setup.period, setup.delay};
  CHECK(judgeWall(setup, law.with(use, found), 9, 2).value > judgeWall(setup, law.with(use, start), 9, 2).value);

  Law picky = law;
  picky.with = [&law](const LawUse& u, const std::vector<double>& values) -> MakeRenderer {
    if (values[0] > 1000.0) throw Error("too stiff");
    return law.with(u, values);
  };
  CHECK(designLaw(setup, picky, start, 2, 2, {})[0] <= 1000.0);
  CHECK_THROWS_WITH(designLaw(setup, picky, {2000.0, 1.0}, 1, 1, {}), ContainsSubstring("too stiff"));
  CHECK_THROWS_AS(designLaw(setup, law, {1.0}, 1, 1, {}), Error);
}

TEST_CASE("values of laws are a file that is read as it was written, or refused with its place") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "laws.json";
  std::vector<LawValues> laws;
  for (const Law& law : rivalLaws()) {
    LawValues values{law.name, 0, 3, {}};
    for (const LawParameter& p : law.parameters) values.values.push_back(p.start / 3.0);
    laws.push_back(values);
  }
  writeFile(path, lawsText({"tau.toml", laws}));
  CHECK(loadLaws(path).model == "tau.toml");
  const std::vector<LawValues> read = loadLaws(path).laws;
  REQUIRE(read.size() == laws.size());
  for (std::size_t i = 0; i < laws.size(); ++i) {
    CHECK(read[i].law == laws[i].law);
    CHECK(read[i].delayLow == 0);
    CHECK(read[i].delayHigh == 3);
    CHECK(read[i].values == laws[i].values);
  }
  const auto refuse = [&](const std::string& text, const std::string& why) {
    writeFile(path, text);
    CHECK_THROWS_WITH(loadLaws(path), ContainsSubstring(why) && ContainsSubstring("laws.json"));
  };
  refuse("[]", "laws");
  refuse(R"({"laws": [{"law": "magic", "delay": [0, 0]}]})", "magic");
  refuse(R"({"laws": [{"law": "impedance", "delay": [2, 1], "stiffness": 1000, "damping": 1}]})", "laws[0].delay");
  refuse(R"({"laws": [{"law": "impedance", "delay": [0, 0], "stiffness": 1000}]})", "laws[0].damping");
  refuse(R"({"laws": [{"law": "impedance", "delay": [0, 0], "stiffness": -1, "damping": 1}]})", "N/m");
}

}  // namespace enamel::test_laws
