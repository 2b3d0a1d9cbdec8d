// Renderers, designs, pushes, studies and recordings in Python.
#include <algorithm>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>

#include "apps/enamel/plants.hpp"
#include "binding.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/drill.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/surface_file.hpp"
#include "enamel/render/virtual_coupling.hpp"
#include "enamel/runtime/replay.hpp"
#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_design.hpp"
#include "enamel/study/wall_trials.hpp"

namespace enamel::python {
namespace {

// ---- renderers ---------------------------------------------------------------------------------------------------

/// How to make a renderer: a run makes its own, so that runs share no state.
struct RendererRecipe {
  std::string name;
  MakeRenderer make;
};

/// The first exception of the renderers in Python of one call: they cannot throw in a tick.
class Failure {
 public:
  void keep(std::exception_ptr error) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!first_) first_ = std::move(error);
  }
  void rethrow() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::mutex mutex_;
  std::exception_ptr first_;
};

// May be let go on any thread.
std::shared_ptr<py::object> shared(py::object object) {
  return {new py::object(std::move(object)), [](py::object* kept) {
            const py::gil_scoped_acquire acquire;
            delete kept;
          }};
}

/// A renderer whose law is a Python object: for experiments, not for real time. It has no state that could be saved.
class ScriptedRenderer final : public Renderer {
 public:
  ScriptedRenderer(std::shared_ptr<py::object> self, std::shared_ptr<Failure> failure)
      : self_(std::move(self)), failure_(std::move(failure)) {
    needsInertia_ = self_->attr("needs_inertia").cast<bool>();
  }
  bool needsInertia() const noexcept override { return needsInertia_; }

 private:
  template <typename Body>
  bool attempt(const Body& body) noexcept {
    if (failed_) return false;
    const py::gil_scoped_acquire acquire;
    try {
      body();
      return true;
    } catch (...) {
      failed_ = true;
      failure_->keep(std::current_exception());
      return false;
    }
  }

  void prepare(double period) override {
    const py::gil_scoped_acquire acquire;
    self_->attr("activate")(period);
  }
  void resetState() noexcept override {
    attempt([this] { self_->attr("reset")(); });
  }
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  Status render(const TickFrame& input, TickOutput& output) noexcept override {
    const Kinematics& k = input.kinematics;
    const bool done = attempt([&] {
      const Array torque = Array::ensure(self_->attr("render")(py::cast(input)));
      if (!torque) throw py::type_error("render() must return the torque of every joint");
      output.torque = joints(torque, static_cast<int>(k.q.size()), "what render() returned", "N m or N");
    });
    if (!done) return Status::notFinite;
    const Contact& deepest = input.contacts.contacts[0];
    const bool touches = input.contacts.count > 0 && deepest.gap < 0.0;
    output.mode = touches ? RenderMode::contact : RenderMode::free;
    if (touches) output.normalForce = deepest.normal.dot(wrenchOf(k, output.torque - k.gravity).head<3>());
    return Status::ok;
  }

  std::shared_ptr<py::object> self_;
  std::shared_ptr<Failure> failure_;
  bool needsInertia_ = false, failed_ = false;
};

MakeRenderer makerOf(const py::object& renderer, const std::shared_ptr<Failure>& failure) {
  if (py::isinstance<RendererRecipe>(renderer)) return renderer.cast<const RendererRecipe&>().make;
  if (!PyCallable_Check(renderer.ptr()))
    throw py::type_error(
        "a renderer is what enamel.position_control() and its like return, or a callable that makes a PythonRenderer");
  return [make = shared(renderer), failure]() -> std::unique_ptr<Renderer> {
    const py::gil_scoped_acquire acquire;
    py::object made = (*make)();
    if (py::isinstance<RendererRecipe>(made)) return made.cast<const RendererRecipe&>().make();
    if (!py::hasattr(made, "render")) throw py::type_error("the callable made no PythonRenderer");
    return std::make_unique<ScriptedRenderer>(shared(std::move(made)), failure);
  };
}

using Delays = std::pair<int, int>;

RendererRecipe positionControl(const Device& device, double period, const Delays& delay, const py::object& file,
                               const std::map<std::string, double>& numbers) {
  SurfaceServoOptions options;
  if (file.is_none()) {
    options = surfaceServoFor(device.mechanism->limits().count, period, delay.first, delay.second);
  } else {
    const std::string path = py::str(file).cast<std::string>();
    options = loadSurfaceServo(path).options;
    if (options.count.size() != device.mechanism->joints())
      throw Error(path + ": the servo is for " + std::to_string(options.count.size()) + " joints, the device has " +
                  std::to_string(device.mechanism->joints()));
  }
  for (const auto& [key, value] : numbers) {
    const std::string& name = key;  // which Clang lets a lambda capture
    const auto& all = surfaceServoParameters();
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; });
    if (found == all.end()) throw Error("position_control has no number \"" + name + "\"");
    options.*found->value = value;
  }
  SurfaceServoRenderer{options};  // refuses here what a run would refuse
  return {"position-control", [options] { return std::make_unique<SurfaceServoRenderer>(options); }};
}

RendererRecipe hold(const Device& device, double period, const std::optional<Eigen::MatrixXd>& gain, bool release,
                    bool antiWindup) {
  const auto design = gain ? *gain : designServo(device.mechanism, Pose{}, period).K;
  if (design.rows() > kMaxJoints || design.cols() > 3 * kMaxJoints)
    throw Error("a gain of " + std::to_string(design.rows()) + " x " + std::to_string(design.cols()) +
                " is for no device");
  PositionControlOptions options;
  options.release = release;
  options.antiWindup = antiWindup;
  const ServoGain servo = design;
  PositionControlRenderer(servo, period, options);
  return {"hold", [=] { return std::make_unique<PositionControlRenderer>(servo, period, options); }};
}

RendererRecipe impedance(double stiffness, double damping) {
  const ImpedanceOptions options{stiffness, damping};
  ImpedanceRenderer{options};
  return {"impedance", [options] { return std::make_unique<ImpedanceRenderer>(options); }};
}

RendererRecipe passivity(double stiffness, double damping, bool memory) {
  const ImpedanceOptions options{stiffness, damping};
  ImpedanceRenderer{options};
  return {"passivity", [options, memory] {
            return std::make_unique<PassivityRenderer>(std::make_unique<ImpedanceRenderer>(options),
                                                       memory ? PassivityBound::memory : PassivityBound::energy);
          }};
}

RendererRecipe virtualCoupling(double stiffness, double damping, double mass) {
  const VirtualCouplingOptions options{stiffness, damping, mass};
  VirtualCouplingRenderer{options};
  return {"virtual-coupling", [options] { return std::make_unique<VirtualCouplingRenderer>(options); }};
}

RendererRecipe plugin(const py::object& path, const py::object& device, const std::map<std::string, py::object>& set) {
  const auto library = PluginLibrary::load(py::str(path).cast<std::string>());
  PluginSetup setup;
  if (!device.is_none()) setup.devicePath = py::str(device).cast<std::string>();
  for (const auto& [key, value] : set) setup.parameters[key] = py::str(value).cast<std::string>();
  (void)makeRenderer(library, setup);
  return {library->description().name, [library, setup] { return makeRenderer(library, setup); }};
}

// ---- pushes ------------------------------------------------------------------------------------------------------

RateSource ratesOf(const std::string& rates, bool encoders) {
  if (rates.empty()) return encoders ? RateSource::difference : RateSource::exact;
  if (rates == "exact") return RateSource::exact;
  if (rates == "difference") return RateSource::difference;
  if (rates == "low-pass") return RateSource::lowPass;
  throw Error("rates is \"" + rates + "\", must be exact, difference or low-pass");
}

app::MakePlant plantOf(const std::string& plant, const DeviceParameters& parameters, VirtualDeviceSetup& setup) {
  if (const std::string problem = app::checkPlant(plant); !problem.empty()) throw Error("plant " + problem);
  return app::makerOf(plant, parameters, setup);
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
    for (const Vec6* v : {&r.twist, &r.person, &r.rendered}) table_.add(*v);
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

Push push(const Device& device, const py::object& renderer, const std::shared_ptr<SceneFile>& scene, int scenario,
          double force, double preload, double noise, const std::optional<Array>& start,
          const std::optional<Array>& tip, bool guard, double maxForce, bool guide, bool arm, const Delays& delay,
          bool encoders, const std::string& rates, double lowPass, double period, int substeps, double duration,
          std::uint64_t seed, std::uint32_t run, bool insideTick, const std::string& plant,
          const std::optional<Device>& model) {
  PushSetup setup;
  setup.person.scenario = scenario;
  setup.person.force = force;
  setup.person.preload = preload;
  setup.person.noise = noise;
  setup.person.guide = guide;
  if (arm) setup.person.arm = kArm;
  if (start) setup.start.position = vec3(*start, "start", "m");
  if (tip) holdAt(vec3(*tip, "tip", "m"), setup);
  setup.force = maxForce;
  if (scene) {
    if (start || tip)
      throw Error("a push into a scene has its own start and tool: start and tip are for the wall z = 0");
    if (scene->scene.obstacles().empty()) throw Error("the scene has no obstacle");
    pushIn(*scene, setup);
  }
  setup.guarded = guard;
  setup.delay = {delay.first, delay.second};
  setup.encoders = {encoders, ratesOf(rates, encoders), lowPass};
  setup.period = period;
  setup.substeps = substeps;
  setup.duration = duration;
  setup.seed = seed;
  setup.run = run;
  if (insideTick) setup.person.instant = randomInstant(seed, run);
  const app::MakePlant makePlant = plantOf(plant, device.parameters, setup);
  checkPush(setup);

  const auto failure = std::make_shared<Failure>();
  const Mechanism& mechanism = *device.mechanism;
  const std::unique_ptr<Renderer> own = makerOf(renderer, failure)();
  TickTable table(mechanism.joints());
  PushResult result{};
  std::optional<PushMetrics> metrics;
  {
    const py::gil_scoped_release release;
    MetricsCollector collector(setup, largestStiffness(mechanism, setup), mechanism.limits().torque);
    const auto perTick = [&](const TickRecord& tick, const VirtualLoop&) {
      failure->rethrow();
      collector.add(tick);
      table.add(tick);
    };
    result = runPush(
        makePlant ? makePlant(run) : std::make_unique<ClosedFormPlant>(mechanism, setup.integrator, setup.substeps),
        model ? *model->mechanism : mechanism, *own, setup, perTick);
    failure->rethrow();
    metrics = collector.metrics();
  }
  if (result.status != Status::ok && result.status != Status::stopped)
    throw Error("the device left its workspace at " + std::to_string(static_cast<double>(result.ticks) * period) +
                " s: its pose is " + toString(result.status));
  std::optional<std::string> stopped;
  if (result.status == Status::stopped) stopped = toString(result.guard);
  return {table.finish(), *metrics, stopped};
}

// ---- studies -----------------------------------------------------------------------------------------------------

struct Study {
  StudyPlan plan;
  std::vector<StudyResult> results;
};

Study study(const Device& device, const std::map<std::string, py::object>& renderers, const std::vector<int>& scenarios,
            int grid, double halfWidth, int runs, double lowestForce, double highestForce, double preload, double noise,
            const Delays& delay, bool encoders, bool guard, double period, std::uint64_t seed, bool insideTick,
            const std::string& plant, int threads) {
  const auto failure = std::make_shared<Failure>();
  Study result;
  StudyPlan& plan = result.plan;
  plan.scenarios = scenarios;
  plan.grid = grid;
  plan.halfWidth = halfWidth;
  plan.runs = runs;
  plan.lowestForce = lowestForce;
  plan.highestForce = highestForce;
  plan.insideTick = insideTick;
  plan.setup.person.preload = preload;
  plan.setup.person.noise = noise;
  plan.setup.delay = {delay.first, delay.second};
  plan.setup.encoders = {encoders, ratesOf("", encoders), 100.0};
  plan.setup.guarded = guard;
  plan.setup.period = period;
  plan.setup.seed = seed;
  for (const auto& [name, value] : renderers) {
    py::object renderer = value;
    Device own = device;
    if (py::isinstance<py::tuple>(value)) {
      const auto pair = value.cast<std::pair<py::object, Device>>();
      renderer = pair.first;
      own = pair.second;
    }
    StudyColumn column{name, own.mechanism, {}, plantOf(plant, own.parameters, plan.setup), 0.0};
    column.make = [make = makerOf(renderer, failure)](std::size_t) { return make(); };
    plan.columns.push_back(std::move(column));
  }
  const py::gil_scoped_release release;
  checkStudy(plan);
  result.results.resize(plan.size());
  parallelFor(plan.size(), threads > 0 ? threads : availableThreads(), [&](std::size_t i) {
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

py::dict judge(const Device& device, const py::object& renderer, int runs, const Delays& delay, double inertiaError,
               double period, std::uint64_t seed, int threads) {
  const auto failure = std::make_shared<Failure>();
  const MakeRenderer make = makerOf(renderer, failure);
  WallDesignSetup setup;
  setup.plant = device.mechanism;
  setup.period = period;
  setup.delay = {delay.first, delay.second};
  setup.inertiaError = inertiaError;
  setup.runs = runs;
  setup.seed = seed;
  WallScore score;
  {
    const py::gil_scoped_release release;
    score = judgeWall(withinMotors(setup), make, 0, threads > 0 ? threads : availableThreads());
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

py::list trials(const Device& device, const py::object& renderer, const std::string& filter, int runs,
                const Delays& delay, double noise, double period, std::uint64_t seed,
                const std::optional<Device>& model, int threads) {
  const auto failure = std::make_shared<Failure>();
  WallTrialSetup setup;
  setup.plant = device.mechanism;
  setup.model = model ? model->mechanism : device.mechanism;
  setup.renderer = makerOf(renderer, failure);
  setup.delay = {delay.first, delay.second};
  setup.period = period;
  setup.noise = noise;
  setup.runs = runs;
  setup.seed = seed;
  std::vector<WallFigure> figures;
  {
    const py::gil_scoped_release release;
    figures = runWallTrials(setup, filter, threads > 0 ? threads : availableThreads());
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

// ---- recordings --------------------------------------------------------------------------------------------------

class Recording {
 public:
  explicit Recording(const std::string& path) : reader_(path) {
    DeviceParameters parameters = parseDevice(header().deviceText, header().deviceFile);
    device_ = {parameters, makeMechanism(parameters)};
  }
  const RecordingHeader& header() const noexcept { return reader_.header(); }
  const Device& device() const noexcept { return device_; }

  std::shared_ptr<SceneFile> scene() const {
    if (!header().sceneText.empty())
      return std::make_shared<SceneFile>(parseScene(header().sceneText, header().sceneFile));
    auto wall = std::make_shared<SceneFile>();
    wall->scene = flatWall();
    return wall;
  }

  py::array ticks() {
    const int n = header().joints;
    Table table;
    table.column("tick", {}, "u8");
    for (const char* name : {"time", "normal_force"}) table.column(name);
    for (const char* name : {"q", "rates", "applied", "requested", "command"}) table.column(name, {n});
    table.column("position", {3});
    table.column("rotation", {3, 3});
    for (const char* name : {"mode", "saturated", "status", "guard", "enabled", "reset"}) table.column(name, {}, "i8");
    {
      const py::gil_scoped_release release;
      Kinematics kinematics = device_.mechanism->home();
      RecordedChunk chunk;
      for (std::uint64_t i = 0; i < reader_.chunks(); ++i) {
        if (const std::string problem = reader_.read(i, chunk); !problem.empty()) {
          if (i + 1 == reader_.chunks()) break;  // cut off
          throw Error(problem);
        }
        for (const RecordedTick& t : chunk.ticks) add(t, n, kinematics, table);
      }
    }
    return table.finish();
  }

  py::dict replayed(const py::object& renderer) {
    const auto failure = std::make_shared<Failure>();
    const std::unique_ptr<Renderer> own = makerOf(renderer, failure)();
    ReplayResult result;
    {
      const py::gil_scoped_release release;
      const auto file = scene();
      HapticTick tick(*device_.mechanism, file->scene, file->tool, *own, header().guard, header().start);
      std::optional<Drill> drill;
      if (file->bur) tick.attach(&drill.emplace(file->tool, file->solids, *file->bur));
      result = replay(reader_, tick, 0, [&](const RecordedTick&, const HapticTick&) { failure->rethrow(); });
      failure->rethrow();
    }
    py::dict found;
    found["ticks"] = result.ticks;
    found["different"] = result.different;
    found["lost"] = result.lost;
    found["damage"] = result.damage;
    found["closed"] = result.closed;
    found["requested"] = result.requested;
    found["command"] = result.command;
    return found;
  }

 private:
  void add(const RecordedTick& t, int n, Kinematics& kinematics, Table& table) const {
    const Measurement& m = t.measurement;
    table.add(t.number);
    table.add(m.time);
    table.add(t.normalForce);
    for (const JointVector* v : {&m.q, &m.rates, &m.applied, &t.requested, &t.command}) table.addJoints(*v, n);
    const bool found = device_.mechanism->track(m.q, m.rates, false, kinematics) == Status::ok;
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    table.add(found ? kinematics.pose.position : Vec3(Vec3::Constant(nothing)));
    table.add(found ? kinematics.pose.rotation : Mat3(Mat3::Constant(nothing)));
    for (const int value : {static_cast<int>(t.mode), static_cast<int>(t.saturated), static_cast<int>(t.status),
                            static_cast<int>(t.reason), static_cast<int>(m.enabled), static_cast<int>(t.reset)})
      table.add(static_cast<std::int64_t>(value));
  }

  RecordingReader reader_;
  Device device_;
};

template <typename Enum>
py::tuple namesUpTo(Enum last) {
  py::list names;
  for (int i = 0; i <= static_cast<int>(last); ++i) names.append(toString(static_cast<Enum>(i)));
  return py::tuple(names);
}

}  // namespace

void addRuns(py::module_& m) {
  m.attr("modes") = namesUpTo(RenderMode::fault);
  m.attr("statuses") = namesUpTo(Status::stopped);
  m.attr("guard_reasons") = namesUpTo(GuardReason::deadlines);
  m.attr("verdicts") = namesUpTo(FirstImpactVerdict::unstable);
  m.attr("plants") = app::plantNames();

  py::class_<TickFrame>(m, "Tick", "What a renderer knows at a tick. SI; in W.")
      .def_readonly("time", &TickFrame::time, "s, strictly increasing.")
      .def_readonly("kinematics", &TickFrame::kinematics, "Measured; the inertia where needs_inertia is set.")
      .def_readonly("max_torque", &TickFrame::maxTorque, "Limit of every motor, (n,), N m or N.")
      .def_readonly("applied", &TickFrame::applied,
                    "Torque that really acted since the last tick, (n,), N m or N; (0,): the device cannot tell.")
      .def_property_readonly(
          "contacts",
          [](const TickFrame& self) {
            std::vector<ContactRow> rows;
            for (int i = 0; i < self.contacts.count; ++i)
              rows.push_back(rowOf(0, self.contacts.contacts[static_cast<std::size_t>(i)]));
            return arrayOf(std::move(rows));
          },
          "contact_dtype, the deepest first; within 1 mm.");

  py::class_<RendererRecipe>(m, "Renderer", "How to make a renderer: every run makes its own.")
      .def_readonly("name", &RendererRecipe::name)
      .def("__repr__", [](const RendererRecipe& self) { return "<enamel.Renderer \"" + self.name + "\">"; });
  const Delays none{0, 0};
  m.def(
      "position_control",
      [](const Device& device, double period, const Delays& delay, const py::object& file, const py::kwargs& numbers) {
        return positionControl(device, period, delay, file, numbers.cast<std::map<std::string, double>>());
      },
      py::arg("device"), py::arg("period") = 1e-3, py::arg("delay") = none, py::arg("file") = py::none(),
      "The contact-space servo: it pushes and never pulls, lets the tool slide. `delay`: smallest and largest of the "
      "command, ticks; `file`: of enamel design --surface; any of its numbers by name. Raises Error: a number outside "
      "its range; a file for another device.");
  m.def(
      "hold", &hold, py::arg("device"), py::arg("period") = 1e-3, py::arg("gain") = py::none(),
      py::arg("release") = true, py::arg("anti_windup") = false,
      "The paper's law: once the tool touches, a servo holds it there. `gain`, (n, 3n): of design_servo(), by default "
      "designed at home. Raises Error: a gain that is not n x 3n or not finite; DesignError.");
  m.def("impedance", &impedance, py::arg("stiffness") = 6000.0, py::arg("damping") = 0.0,
        "The conventional wall: a spring (N/m) and a damper (N s/m) along the contact's normal. Raises Error: one that "
        "is "
        "negative or not finite.");
  m.def(
      "passivity", &passivity, py::arg("stiffness") = 6000.0, py::arg("damping") = 0.0, py::arg("memory") = false,
      "The impedance wall under a time-domain passivity controller; with `memory` a depth gives back only what it has "
      "taken. Raises Error as impedance().");
  m.def("virtual_coupling", &virtualCoupling, py::arg("stiffness") = 3000.0, py::arg("damping") = 2.0,
        py::arg("mass") = 0.02,
        "A tool of the program's own (kg) touches the wall, and a spring (N/m) and a damper (N s/m) tie the device to "
        "it. "
        "Raises Error: a number that is not positive or not finite.");
  m.def(
      "plugin",
      [](const py::object& path, const py::object& device, const py::kwargs& parameters) {
        return plugin(path, device, parameters.cast<std::map<std::string, py::object>>());
      },
      py::arg("path"), py::arg("device") = py::none(),
      "A renderer plugin by its file; `device`: path of the device file; further parameters are the plugin's. Raises "
      "PluginError: it cannot be loaded, or refuses the configuration.");

  py::class_<ServoDesign>(m, "ServoDesign", "A servo u = -K [q'; q - q_op; xi] and the models that it was designed on.")
      .def_readonly("period", &ServoDesign::period, "Ts, s.")
      .def_readonly("K", &ServoDesign::K, "(n, 3n): N m s/rad, N m/rad, N m/(rad s).")
      .def_readonly("P", &ServoDesign::P, "(3n, 3n), cost-to-go.")
      .def_property_readonly(
          "A", [](const ServoDesign& self) -> const Eigen::MatrixXd& { return self.plant.A; },
          py::return_value_policy::reference_internal, "Of the continuous plant, states [q'; q - q_op], (2n, 2n).")
      .def_property_readonly(
          "B", [](const ServoDesign& self) -> const Eigen::MatrixXd& { return self.plant.B; },
          py::return_value_policy::reference_internal, "(2n, n).");
  m.def(
      "design_servo",
      [](const Device& device, const std::optional<Array>& position, double period, double velocity, double weight,
         double integral, double torque) {
        Pose pose;
        if (position) pose.position = vec3(*position, "position", "m");
        const py::gil_scoped_release release;
        return designServo(device.mechanism, pose, period, ServoWeights{velocity, weight, integral, torque});
      },
      py::arg("device"), py::arg("position") = py::none(), py::arg("period") = 1e-3, py::arg("velocity") = 1.0,
      py::arg("weight") = 1e3, py::arg("integral") = 1e7, py::arg("torque") = 1.0,
      "The paper's whole chain for a device at rest at a position (m; default: home): linearise, transform, augment, "
      "hold, Riccati. The weights are those of rate, position, integral and torque. Raises DesignError: the pose is "
      "out "
      "of reach or singular, a weight is negative.");
  m.def(
      "load_servo", [](const py::object& path) { return loadServo(py::str(path).cast<std::string>()).gain; },
      py::arg("path"), "The gain, (n, 3n), of a file of enamel design. Raises ConfigurationError.");

  py::class_<Push>(m, "Push", "What happened in a push.")
      .def_readonly(
          "ticks", &Push::ticks,
          "A structured array, a row a tick, with units of SI: state and measurement before the tick's torque "
          "acts. modes, statuses and guard_reasons have the names of the numbers.")
      .def_property_readonly(
          "metrics", [](const Push& self) { return dictOf(self.metrics); },
          "By their symbols, SI; None where a push does not have one.")
      .def_property_readonly(
          "verdict", [](const Push& self) { return toString(self.metrics.verdict); },
          "Whether the push has a first impact stiffness, or why not.")
      .def_readonly("stopped", &Push::stopped, "Why the guard stopped the renderer; None: it did not.");
  m.def(
      "push", &push, py::arg("device"), py::arg("renderer"), py::kw_only(), py::arg("scene") = nullptr,
      py::arg("scenario") = 1, py::arg("force") = 12.0, py::arg("preload") = 0.0, py::arg("noise") = 0.5,
      py::arg("start") = py::none(), py::arg("tip") = py::none(), py::arg("guard") = true,
      py::arg("max_force") = kUnlimited, py::arg("guide") = true, py::arg("arm") = false, py::arg("delay") = none,
      py::arg("encoders") = false, py::arg("rates") = "", py::arg("low_pass") = 100.0, py::arg("period") = 1e-3,
      py::arg("substeps") = 1, py::arg("duration") = 3.0, py::arg("seed") = 1, py::arg("run") = 0,
      py::arg("inside_tick") = false, py::arg("plant") = "closed-form", py::arg("model") = py::none(),
      "One push of a tool against a wall on the virtual device: z = 0, or the obstacle of a scene that is nearest to "
      "its start; as enamel push. Scenario 1: a step of `force` (N) at 1 s; 2: a hand moves in. `delay`: smallest and "
      "largest of the command, ticks; `model`: the Device that the loop takes `device` for. The same arguments give "
      "the "
      "same bits. Raises Error: a value outside its range, a device that left its workspace; what a PythonRenderer "
      "raises ends the push. The GIL is released.");

  py::class_<Study>(m, "Study", "The runs of a Monte Carlo study over a wall.")
      .def_property_readonly("runs", &runsOf,
                             "A structured array, a row a run: who it was (`renderer` is a number in `renderers`), and "
                             "the metrics by their symbols, SI, NaN where a run does not have one.")
      .def_property_readonly(
          "renderers",
          [](const Study& self) {
            std::vector<std::string> names;
            for (const StudyColumn& column : self.plan.columns) names.push_back(column.name);
            return names;
          },
          "Their names, by number.")
      .def_property_readonly(
          "walls", &wallsOf,
          "What holds over the wall for each scenario and renderer; \"lowest\" and \"highest\" are of "
          "the points' means, SI.")
      .def(
          "point",
          [](const Study& self, std::size_t number) {
            if (number >= self.plan.points()) throw py::index_error("the study has no such point");
            return queryPoint(self.plan, number);
          },
          py::arg("number"), "Query point by its number, (3,), m.");
  m.def("study", &study, py::arg("device"), py::arg("renderers"), py::kw_only(),
        py::arg("scenarios") = std::vector<int>{1, 2}, py::arg("grid") = 11, py::arg("half_width") = 0.025,
        py::arg("runs") = 20, py::arg("lowest_force") = 8.0, py::arg("highest_force") = 15.0, py::arg("preload") = 0.0,
        py::arg("noise") = 0.5, py::arg("delay") = none, py::arg("encoders") = false, py::arg("guard") = true,
        py::arg("period") = 1e-3, py::arg("seed") = 1, py::arg("inside_tick") = false, py::arg("plant") = "closed-form",
        py::arg("threads") = 0,
        "Monte Carlo over a wall: grid x grid points, `runs` a point, scenario by scenario. `renderers`: by name, a "
        "renderer or a pair of it and its own Device. The numbers do not depend on `threads` (0: all that there are). "
        "Raises Error: a value outside its range, a point that a device cannot reach. The GIL is released.");
  m.def(
      "judge", &judge, py::arg("device"), py::arg("renderer"), py::kw_only(), py::arg("runs") = 24,
      py::arg("delay") = none, py::arg("inertia_error") = 0.0, py::arg("period") = 1e-3, py::arg("seed") = 1,
      py::arg("threads") = 0,
      "How a renderer does on pushes, ramps and impacts at five points of a wall, with encoders rounded and forces "
      "within the motors': stiffness (N/m), shares of the physical limit, chatter (N m or N), bounce, ramp, impact and "
      "deepest (m), runs that were lost or have no stiffness. Raises Error. The GIL is released.");
  m.def("trials", &trials, py::arg("device"), py::arg("renderer"), py::kw_only(), py::arg("filter") = "",
        py::arg("runs") = 20, py::arg("delay") = none, py::arg("noise") = 0.5, py::arg("period") = 1e-3,
        py::arg("seed") = 1, py::arg("model") = py::none(), py::arg("threads") = 0,
        "What people do to a wall besides one push: step, ramp, impact, release, slide, corner, pulse, overload; those "
        "whose name contains `filter`. A list of figures, each the worst of its runs. Raises Error. The GIL is "
        "released.");

  py::class_<Recording>(m, "Recording", "A recording of haptic ticks.")
      .def(py::init(
               [](const py::object& path) { return std::make_unique<Recording>(py::str(path).cast<std::string>()); }),
           py::arg("path"),
           "Opens it. Raises ConfigurationError: no recording, of another version, or its header is damaged.")
      .def_property_readonly(
          "device", [](const Recording& self) { return self.device(); }, "That it was made on.")
      .def_property_readonly("scene", &Recording::scene, "What the tool could touch.")
      .def_property_readonly(
          "renderer", [](const Recording& self) { return self.header().renderer; }, "Its name.")
      .def_property_readonly(
          "parameters", [](const Recording& self) { return self.header().parameters; }, "Of the renderer.")
      .def_property_readonly(
          "period", [](const Recording& self) { return self.header().guard.period; }, "s.")
      .def("ticks", &Recording::ticks,
           "All ticks as a structured array, a row a tick, SI; position and rotation by the device's kinematics, NaN "
           "where it cannot be there. What was lost is missing: see `tick`. Raises Error: a chunk is damaged.")
      .def("replay", &Recording::replayed, py::arg("renderer"),
           "Runs another renderer, or the same, on what was measured, and compares all that it answers bit for bit: "
           "ticks "
           "compared and different, largest differences of the torques (N m or N). Raises Error: as replay().");
}

}  // namespace enamel::python
