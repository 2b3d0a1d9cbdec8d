// Performance of a renderer on a wall in Python: judge() and trials().
#include "enamel/study/wall_design.hpp"
#include "enamel/study/wall_trials.hpp"
#include "keywords.hpp"
#include "setup.hpp"

namespace enamel::python {
namespace {

struct JudgeOptions {
  int runs = 24;
  Delays delay{0, 0};
  double inertiaError = 0.0, period = 1e-3;
  std::uint64_t seed = 1;
  int threads = 0;
};

Keywords<JudgeOptions> judgeKeywords() {
  using O = JudgeOptions;
  Keywords<O> keywords("judge");
  keywords.add("runs", &O::runs).add("delay", &O::delay).add("inertia_error", &O::inertiaError);
  keywords.add("period", &O::period).add("seed", &O::seed).add("threads", &O::threads);
  return keywords;
}

struct TrialOptions {
  std::string filter;
  int runs = 20;
  Delays delay{0, 0};
  double noise = 0.5, period = 1e-3;
  std::uint64_t seed = 1;
  std::optional<Device> model;
  int threads = 0;
};

Keywords<TrialOptions> trialKeywords() {
  using O = TrialOptions;
  Keywords<O> keywords("trials");
  keywords.add("filter", &O::filter).add("runs", &O::runs).add("delay", &O::delay).add("noise", &O::noise);
  keywords.add("period", &O::period).add("seed", &O::seed).add("model", &O::model).add("threads", &O::threads);
  return keywords;
}

py::dict judge(const Device& device, const py::object& renderer, const JudgeOptions& options) {
  const auto failure = std::make_shared<Failure>();
  const MakeRenderer make = makerOf(renderer, failure);
  WallDesignSetup setup;
  setup.plant = device.mechanism;
  setup.period = options.period;
  setup.delay = {options.delay.first, options.delay.second};
  setup.inertiaError = options.inertiaError;
  setup.runs = options.runs;
  setup.seed = options.seed;
  WallScore score;
  {
    const py::gil_scoped_release release;
    score = evaluateWall(withinMotors(setup), make, 0, threadsOf(options.threads));
    failure->rethrow();
  }
  py::dict result;
  result["stiffness"] = score.stiffness;
  result["share"] = score.share;
  result["lowest share"] = score.lowestShare;
  result["chatter"] = score.chatter;
  result["bounce"] = score.bounce;
  result["ramp"] = score.ramp;
  result["impact"] = score.impact;
  result["deepest"] = score.deepest;
  result["lost"] = score.lost;
  result["unmeasured"] = score.unmeasured;
  return result;
}

py::list trials(const Device& device, const py::object& renderer, const TrialOptions& options) {
  const auto failure = std::make_shared<Failure>();
  WallTrialSetup setup;
  setup.plant = device.mechanism;
  setup.model = options.model ? options.model->mechanism : device.mechanism;
  setup.renderer = makerOf(renderer, failure);
  setup.delay = {options.delay.first, options.delay.second};
  setup.period = options.period;
  setup.noise = options.noise;
  setup.runs = options.runs;
  setup.seed = options.seed;
  std::vector<WallFigure> figures;
  {
    const py::gil_scoped_release release;
    figures = runWallTrials(setup, options.filter, threadsOf(options.threads));
    failure->rethrow();
  }
  py::list result;
  for (const WallFigure& f : figures) {
    py::dict figure;
    figure["trial"] = f.trial;
    figure["figure"] = f.figure;
    figure["unit"] = f.unit;
    figure["value"] = f.value;
    figure["lost"] = f.lost;
    result.append(figure);
  }
  return result;
}

}  // namespace

void addWall(py::module_& m) {
  const Keywords<JudgeOptions> ofJudge = judgeKeywords();
  const Keywords<TrialOptions> ofTrials = trialKeywords();
  const std::string judgeDoc =
      ofJudge.documented(deviceAnd("renderer"), "dict",
                         "Evaluate a renderer in simulated pushes, ramps and impacts at five points of a wall, with "
                         "encoders and with forces within the motors' limits. Return stiffness (N/m), shares of the "
                         "physical limit, chatter (N m or N), and bounce, ramp, impact and deepest (m). Also return "
                         "the numbers of runs that were lost or have no stiffness. Raises Error. The GIL is released.");
  const std::string trialsDoc =
      ofTrials.documented(deviceAnd("renderer"), "list",
                          "Simulate what people do with a wall: step, ramp, impact, release, slide, corner, pulse, "
                          "overload. Only tasks whose name contains `filter` are run. Return a list of figures, each "
                          "of the worst run. Raises Error. The GIL is released.");
  py::options help;
  help.disable_function_signatures();
  m.def(
      "judge",
      [ofJudge](const Device& device, const py::object& renderer, const py::kwargs& options) {
        return judge(device, renderer, ofJudge.read(options));
      },
      py::arg("device"), py::arg("renderer"), judgeDoc.c_str());
  m.def(
      "trials",
      [ofTrials](const Device& device, const py::object& renderer, const py::kwargs& options) {
        return trials(device, renderer, ofTrials.read(options));
      },
      py::arg("device"), py::arg("renderer"), trialsDoc.c_str());
}

}  // namespace enamel::python
