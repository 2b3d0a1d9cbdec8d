// A Monte Carlo study over a wall in Python.
#include <map>

#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/parallel.hpp"
#include "keywords.hpp"
#include "setup.hpp"

namespace enamel::python {
namespace {

/// The options of `enamel study`, SI.
struct StudyOptions {
  std::vector<int> scenarios{1, 2};
  int grid = 11;
  double halfWidth = 0.025;
  int runs = 20;
  double lowestForce = 8.0, highestForce = 15.0, preload = 0.0, noise = 0.5;
  bool fingerRest = false;
  Delays delay{0, 0};
  bool encoders = false, guard = true;
  double period = 1e-3;
  std::uint64_t seed = 1;
  bool insideTick = false;
  std::string plant = kClosedForm;
  int threads = 0;
};

Keywords<StudyOptions> studyKeywords() {
  using O = StudyOptions;
  Keywords<O> keywords("study");
  keywords.add("scenarios", &O::scenarios).add("grid", &O::grid).add("half_width", &O::halfWidth);
  keywords.add("runs", &O::runs).add("lowest_force", &O::lowestForce).add("highest_force", &O::highestForce);
  keywords.add("preload", &O::preload).add("noise", &O::noise).add("finger_rest", &O::fingerRest);
  keywords.add("delay", &O::delay).add("encoders", &O::encoders);
  keywords.add("guard", &O::guard).add("period", &O::period).add("seed", &O::seed);
  keywords.add("inside_tick", &O::insideTick).add("plant", &O::plant).add("threads", &O::threads);
  return keywords;
}

struct Study {
  StudyPlan plan;
  std::vector<StudyResult> results;
};

StudyPlan planOf(const StudyOptions& options) {
  StudyPlan plan;
  plan.scenarios = options.scenarios;
  plan.grid = options.grid;
  plan.halfWidth = options.halfWidth;
  plan.runs = options.runs;
  plan.lowestForce = options.lowestForce;
  plan.highestForce = options.highestForce;
  plan.insideTick = options.insideTick;
  plan.setup.hand.preload = options.preload;
  plan.setup.hand.noise = options.noise;
  if (options.fingerRest) plan.setup.hand.rest = kFingerRest;
  plan.setup.delay = {options.delay.first, options.delay.second};
  plan.setup.encoders = encodersOf(options.encoders, "", 100.0);
  plan.setup.guarded = options.guard;
  plan.setup.period = options.period;
  plan.setup.seed = options.seed;
  return plan;
}

Study study(const Device& device, const std::map<std::string, py::object>& renderers, const StudyOptions& options) {
  const auto failure = std::make_shared<Failure>();
  Study result;
  StudyPlan& plan = result.plan;
  plan = planOf(options);
  for (const auto& [name, value] : renderers) {
    py::object renderer = value;
    Device own = device;
    if (py::isinstance<py::tuple>(value)) {
      const auto pair = value.cast<std::pair<py::object, Device>>();
      renderer = pair.first;
      own = pair.second;
    }
    StudyColumn column{name, own.mechanism, {}, plantOf(options.plant, own.parameters, plan.setup), 0.0};
    column.make = [make = makerOf(renderer, failure)](std::size_t) { return make(); };
    plan.columns.push_back(std::move(column));
  }
  const py::gil_scoped_release release;
  checkStudy(plan);
  result.results.resize(plan.size());
  parallelFor(plan.size(), threadsOf(options.threads), [&](std::size_t i) {
    result.results[i] = performRun(plan, runAt(plan, i), [&](const TickRecord&) { failure->rethrow(); });
  });
  failure->rethrow();
  return result;
}

py::array runsOf(const Study& study) {
  Table table;
  for (const char* name : {"scenario", "renderer", "point", "run", "status", "verdict", "faults"})
    table.column(name, {}, "i8");
  table.column("force");
  for (const Metric& metric : allMetrics()) table.column(metric.symbol);
  for (const StudyResult& r : study.results) {
    for (const std::size_t value :
         {static_cast<std::size_t>(r.run.scenario), r.run.column, r.run.point, static_cast<std::size_t>(r.run.run),
          static_cast<std::size_t>(r.status), static_cast<std::size_t>(r.metrics.verdict),
          static_cast<std::size_t>(r.metrics.faults)})
      table.add(static_cast<std::int64_t>(value));
    table.add(r.run.force);
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    for (const Metric& metric : allMetrics())
      table.add(r.status == Status::ok ? valueOf(r.metrics, metric).value_or(nothing) : nothing);
  }
  return table.finish();
}

py::list wallsOf(const Study& study) {
  py::list walls;
  const auto value = [](const std::optional<Extreme>& e) { return e ? py::cast(e->value) : py::object(py::none()); };
  for (const WallSummary& w : summarise(study.plan, pointStatistics(study.plan, study.results))) {
    py::dict wall;
    wall["scenario"] = w.scenario;
    wall["renderer"] = study.plan.columns[w.column].name;
    wall["lowest K_z1"] = value(w.lowestFirst);
    wall["highest K_z1"] = value(w.highestFirst);
    wall["lowest K_d"] = value(w.lowestDepthStiffness);
    wall["mean K_d"] = w.depthStiffness.mean;
    wall["lowest K_zs"] = value(w.lowestSteady);
    wall["highest K_zs"] = value(w.highestSteady);
    wall["lowest |C_zs|"] = value(w.lowestCompliance);
    wall["highest |C_zs|"] = value(w.highestCompliance);
    wall["largest depth"] = w.largestDepth;
    wall["chatter"] = w.chatter;
    wall["bounce"] = w.bounce;
    wall["failed"] = w.failed;
    wall["stable"] = w.stable();
    walls.append(wall);
  }
  return walls;
}

}  // namespace

void addStudy(py::module_& m) {
  py::class_<Study>(m, "Study", "The runs of a Monte Carlo study over a wall.")
      .def_property_readonly(
          "runs", &runsOf,
          "Runs as a structured array, one row a run. Columns: scenario, renderer (a number in `renderers`), point, "
          "run, and the metrics by their symbols, SI units. A metric is NaN if the run does not have it.")
      .def_property_readonly(
          "renderers",
          [](const Study& self) {
            std::vector<std::string> names;
            for (const StudyColumn& column : self.plan.columns) names.push_back(column.name);
            return names;
          },
          "Names of the renderers, by number.")
      .def_property_readonly("walls", &wallsOf,
                             "Results over the wall for each scenario and renderer, SI units. \"lowest\" and "
                             "\"highest\" are of the points' means.")
      .def(
          "point",
          [](const Study& self, std::size_t number) {
            if (number >= self.plan.points())
              throw py::index_error("point " + std::to_string(number) + " does not exist, the study has " +
                                    std::to_string(self.plan.points()) + " points");
            return queryPoint(self.plan, number);
          },
          py::arg("number"), "Return the query point with a number, (3,), m. Raises IndexError.");
  const Keywords<StudyOptions> keywords = studyKeywords();
  const std::string doc = keywords.documented(
      "device: " + TypeName<Device>::text() + ", renderers: Dict[str, object]", TypeName<Study>::text(),
      "Perform a Monte Carlo study over a wall: grid x grid points, `runs` runs at each point and scenario. "
      "`renderers`: names with a renderer, or a pair of a renderer and its own Device. The numbers do not depend on "
      "`threads` (0: all processors). Raises Error if a value is outside its range or a device cannot reach a point. "
      "The GIL is released.");
  py::options help;
  help.disable_function_signatures();
  m.def(
      "study",
      [keywords](const Device& device, const std::map<std::string, py::object>& renderers, const py::kwargs& options) {
        return study(device, renderers, keywords.read(options));
      },
      py::arg("device"), py::arg("renderers"), doc.c_str());
}

}  // namespace enamel::python
