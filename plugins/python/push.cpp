// A push in Python.
#include <optional>

#include "enamel/core/error.hpp"
#include "enamel/study/metrics.hpp"
#include "keywords.hpp"
#include "setup.hpp"

namespace enamel::python {
namespace {

/// The options of `enamel push`, SI.
struct PushOptions {
  std::shared_ptr<SceneFile> scene;
  int scenario = 1;
  double force = 12.0, preload = 0.0, noise = 0.5;
  std::optional<Array> start, tip;
  bool guard = true;
  double maxForce = kUnlimited;
  bool guide = true, arm = false, fingerRest = false;
  Delays delay{0, 0};
  bool encoders = false;
  std::string rates;
  double lowPass = 100.0, period = 1e-3;
  int substeps = 1;
  double duration = 3.0;
  std::uint64_t seed = 1;
  std::uint32_t run = 0;
  bool insideTick = false;
  std::string plant = kClosedForm;
  std::optional<Device> model;
};

Keywords<PushOptions> pushKeywords() {
  using O = PushOptions;
  Keywords<O> keywords("push");
  keywords.add("scene", &O::scene).add("scenario", &O::scenario).add("force", &O::force).add("preload", &O::preload);
  keywords.add("noise", &O::noise).add("start", &O::start).add("tip", &O::tip).add("guard", &O::guard);
  keywords.add("max_force", &O::maxForce).add("guide", &O::guide).add("arm", &O::arm);
  keywords.add("finger_rest", &O::fingerRest).add("delay", &O::delay);
  keywords.add("encoders", &O::encoders).add("rates", &O::rates).add("low_pass", &O::lowPass);
  keywords.add("period", &O::period).add("substeps", &O::substeps).add("duration", &O::duration).add("seed", &O::seed);
  keywords.add("run", &O::run).add("inside_tick", &O::insideTick).add("plant", &O::plant).add("model", &O::model);
  return keywords;
}

PushSetup setupOf(const PushOptions& options) {
  PushSetup setup;
  setup.hand.scenario = options.scenario;
  setup.hand.force = options.force;
  setup.hand.preload = options.preload;
  setup.hand.noise = options.noise;
  setup.hand.guide = options.guide;
  if (options.arm) setup.hand.arm = kArm;
  if (options.fingerRest) setup.hand.rest = kFingerRest;
  if (options.start) setup.start.position = vec3(*options.start, "start", "m");
  if (options.tip) setToolTip(vec3(*options.tip, "tip", "m"), setup);
  setup.force = options.maxForce;
  if (options.scene) {
    if (options.start || options.tip)
      throw Error("start and tip are only for the wall z = 0: a scene has its own start and tool");
    if (options.scene->scene.obstacles().empty()) throw Error("the scene has no obstacle");
    setScene(*options.scene, setup);
  }
  setup.guarded = options.guard;
  setup.delay = {options.delay.first, options.delay.second};
  setup.encoders = encodersOf(options.encoders, options.rates, options.lowPass);
  setup.period = options.period;
  setup.substeps = options.substeps;
  setup.duration = options.duration;
  setup.seed = options.seed;
  setup.run = options.run;
  if (options.insideTick) setup.hand.instant = randomInstant(options.seed, options.run);
  return setup;
}

class TickTable {
 public:
  explicit TickTable(int n) : n_(n) {
    table_.column("tick", {}, "u8");
    for (const char* name : {"time", "gap", "gap_rate", "normal_force"}) table_.column(name);
    for (const char* name : {"position", "point", "normal"}) table_.column(name, {3});
    table_.column("rotation", {3, 3});
    for (const char* name : {"twist", "person", "rendered"}) table_.column(name, {6});
    for (const char* name : {"q", "requested", "command", "torque"}) table_.column(name, {n});
    for (const char* name : {"mode", "saturated", "status", "guard"}) table_.column(name, {}, "i8");
  }
  void add(const TickRecord& r) {
    table_.add(r.tick);
    for (const double value : {r.time, r.nearest.gap, r.gapRate, r.normalForce}) table_.add(value);
    for (const Vec3* v : {&r.pose.position, &r.nearest.point, &r.nearest.normal}) table_.add(*v);
    table_.add(r.pose.rotation);
    for (const Vec6* v : {&r.twist, &r.handWrench, &r.rendered}) table_.add(*v);
    for (const JointVector* v : {&r.q, &r.requested, &r.command, &r.torque}) table_.addJoints(*v, n_);
    for (const int value : {static_cast<int>(r.mode), static_cast<int>(r.saturated), static_cast<int>(r.status),
                            static_cast<int>(r.guard)})
      table_.add(static_cast<std::int64_t>(value));
  }
  py::array finish() { return table_.finish(); }

 private:
  int n_;
  Table table_;
};

py::dict dictOf(const PushMetrics& metrics) {
  py::dict values;
  for (const Metric& metric : allMetrics()) values[metric.symbol] = valueOf(metrics, metric);
  return values;
}

struct Push {
  py::array ticks;
  PushMetrics metrics;
  std::optional<std::string> stopped;
};

Push push(const Device& device, const py::object& renderer, const PushOptions& options) {
  PushSetup setup = setupOf(options);
  const MakePlant makePlant = plantOf(options.plant, device.parameters, setup);
  checkPush(setup);

  const auto failure = std::make_shared<Failure>();
  const Mechanism& mechanism = *device.mechanism;
  const std::unique_ptr<Renderer> own = makerOf(renderer, failure)();
  TickTable table(mechanism.joints());
  PushResult result{};
  std::optional<PushMetrics> metrics;
  {
    const py::gil_scoped_release release;
    MetricsCollector collector(setup, largestStiffness(mechanism, setup), mechanism.limits().effort);
    const auto perTick = [&](const TickRecord& tick, const VirtualLoop&) {
      failure->rethrow();
      collector.add(tick);
      table.add(tick);
    };
    result = runPush(makePlant ? makePlant(setup.run)
                               : std::make_unique<ClosedFormPlant>(mechanism, setup.integrator, setup.substeps),
                     options.model ? *options.model->mechanism : mechanism, *own, setup, perTick);
    failure->rethrow();
    metrics = collector.metrics();
  }
  if (result.status != Status::ok && result.status != Status::stopped)
    throw Error("the device left its workspace at " + std::to_string(static_cast<double>(result.ticks) * setup.period) +
                " s: its pose is " + toString(result.status));
  std::optional<std::string> stopped;
  if (result.status == Status::stopped) stopped = toString(result.guard);
  return {table.finish(), *metrics, stopped};
}

}  // namespace

void addPush(py::module_& m) {
  py::class_<Push>(m, "Push", "Result of a push: its ticks, metrics and verdict.")
      .def_readonly("ticks", &Push::ticks,
                    "Ticks as a structured array, one row a tick, SI units: state and measurement before the tick's "
                    "torque acts. modes, statuses and guard_reasons give the names of the numbers.")
      .def_property_readonly(
          "metrics", [](const Push& self) { return dictOf(self.metrics); },
          "Metrics by their symbols, SI units; None if the push does not have one.")
      .def_property_readonly(
          "verdict", [](const Push& self) { return toString(self.metrics.verdict); },
          "Whether the push has a first-impact stiffness, or the reason why not.")
      .def_readonly("stopped", &Push::stopped, "Reason why the guard stopped the renderer, or None.");
  const Keywords<PushOptions> keywords = pushKeywords();
  const std::string doc = keywords.documented(
      deviceAnd("renderer"), TypeName<Push>::text(),
      "Simulate one push of a tool against a wall on the virtual device, as enamel push does. The wall is z = 0, or "
      "the obstacle of a scene that is nearest to its start. Scenario 1: a step of `force` (N) at 1 s; 2: a hand moves "
      "into the wall. `finger_rest`: a finger 15 mm behind the tip rests on a tooth. `delay`: smallest and largest "
      "delay of the command, ticks. `model`: the Device that renderer and "
      "guard use instead of `device`. The same arguments give the same bits. Raises Error if a value is outside its "
      "range or the device leaves its workspace, and any exception of a PythonRenderer. The GIL is released.");
  py::options help;
  help.disable_function_signatures();
  m.def(
      "push",
      [keywords](const Device& device, const py::object& renderer, const py::kwargs& options) {
        return push(device, renderer, keywords.read(options));
      },
      py::arg("device"), py::arg("renderer"), doc.c_str());
}

}  // namespace enamel::python
