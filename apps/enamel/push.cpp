#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/runtime/recorder.hpp"
#include "plant_option.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"
#include "program/recorded.hpp"
#include "push_report.hpp"
#include "renderer_option.hpp"

namespace enamel::app {
namespace {

constexpr double kTouch = 2e-5;  // m: a smaller gap counts as contact

struct PushOptions {
  std::string device, scene, gain, output, record;
  std::vector<std::string> renderers = {kPositionControl};
  std::string delay = "none", plant = kClosedForm;
  bool guide = true, arm = false, rest = false, encoders = false, insideTick = false, json = false, overwrite = false;
  HoldOptions servo;
  std::string rates;
  std::vector<std::string> set;
  std::vector<double> tip_mm{0.0, 0.0, 0.0};
  double x_mm = 0.0, y_mm = 0.0, lowPass_Hz = 100.0, deviceDamping = 0.0;
  ImpedanceOptions impedance;
  PushSetup setup;
};

// Return the file's name; with several renderers, the renderer's name is added: run-impedance.csv.
std::string outputFor(const PushOptions& options, const std::string& file, const std::string& renderer) {
  if (options.renderers.size() == 1) return file;
  std::filesystem::path path = std::filesystem::u8path(file);
  path.replace_filename(std::filesystem::u8path(path.stem().u8string() + "-" + renderer + path.extension().u8string()));
  return path.u8string();
}

// Convert the options, and check everything that can be checked before a renderer runs.
PushSetup setupOf(const PushOptions& options) {
  PushSetup setup = options.setup;
  setup.start.position = Vec3(1e-3 * options.x_mm, 1e-3 * options.y_mm, 0.0);
  if (const Vec3 tip(options.tip_mm[0], options.tip_mm[1], options.tip_mm[2]); tip != Vec3::Zero())
    setToolTip(1e-3 * tip, setup);
  if (!options.scene.empty()) {
    const SceneFile file = loadScene(options.scene);
    for (const std::string& note : file.notes) fmt::print(stderr, "{}\n", note);
    setScene(file, setup);
  }
  setup.hand.guide = options.guide;
  if (options.arm) setup.hand.arm = kArm;
  if (options.rest) setup.hand.rest = kFingerRest;
  if (options.insideTick) setup.hand.instant = randomInstant(setup.seed, setup.run);
  setup.delay = parseDelay(options.delay);
  setup.encoders.quantised = options.encoders;
  setup.encoders.cutoff = options.lowPass_Hz;
  setup.encoders.rates = options.rates == "difference" ? RateSource::difference
                         : options.rates == "low-pass" ? RateSource::lowPass
                         : options.rates == "exact"    ? RateSource::exact
                         : options.encoders            ? RateSource::difference
                                                       : RateSource::exact;
  checkPush(setup);
  return setup;
}

std::vector<RendererSource> sourcesOf(const PushOptions& options) {
  std::vector<RendererSource> sources;
  const auto has = [&](const auto& condition) { return std::any_of(sources.begin(), sources.end(), condition); };
  for (const std::string& text : options.renderers) {
    const RendererSource source = findRenderer(text, pluginFolder());
    if (has([&](const RendererSource& s) { return s.name == source.name; }))
      throw Error("--renderer names " + source.name + " twice");
    sources.push_back(source);
  }
  if (!options.set.empty() && !has([](const RendererSource& s) { return s.plugin != nullptr; }))
    throw Error("--set is for plugins only, but --renderer does not name a plugin");
  std::vector<std::string> linked;
  for (const RendererSource& source : sources)
    if (!source.plugin) linked.push_back(source.name);
  checkGain(options.gain, linked, "--renderer");
  return sources;
}

// Return the parameters of a linked renderer under the names that the plugins use.
std::map<std::string, std::string> parametersOf(const PushOptions& options, const std::string& renderer,
                                                const Delay& delay) {
  const auto onOff = [](bool value) { return value ? "on" : "off"; };
  if (renderer == kImpedance || renderer == kPassivity)
    return {{"stiffness", fmt::format("{}", options.impedance.stiffness)},
            {"damping", fmt::format("{}", options.impedance.damping)}};
  if (renderer == kPositionControl)
    return {{"mode", "surface"},
            {"delay", std::to_string(delay.low)},
            {"delay-high", std::to_string(delay.high)},
            {"drive", drivesOf(options.plant)}};
  std::map<std::string, std::string> parameters = {
      {"mode", "hold"}, {"release", onOff(options.servo.release)}, {"anti-windup", onOff(options.servo.antiWindup)}};
  if (!options.gain.empty())
    parameters["gain"] = std::filesystem::absolute(std::filesystem::u8path(options.gain)).u8string();
  return parameters;
}

RecordingHeader headerOf(const PushOptions& options, const PushSetup& setup) {
  RecordingHeader header;
  header.deviceFile = std::filesystem::absolute(std::filesystem::u8path(options.device)).u8string();
  header.deviceText = readFile(options.device);
  if (!options.scene.empty()) {
    header.sceneFile = std::filesystem::absolute(std::filesystem::u8path(options.scene)).u8string();
    header.sceneText = readFile(options.scene);
  }
  header.start = setup.start;
  return header;
}

// Describes how the tool left the workspace: distance and speed, the last touch of the obstacle that it was pushed
// against, and the nearest obstacle at the end.
class WayOut {
 public:
  explicit WayOut(const PushSetup& setup) : setup_(setup) { last_.pose = setup.start; }

  void add(const TickRecord& tick) {
    last_ = tick;
    if (tick.nearest.obstacle < 0 || tick.nearest.gap > kTouch) return;
    if (pushed_ < 0) pushed_ = tick.nearest.obstacle;
    if (tick.nearest.obstacle == pushed_) touched_ = tick.time;
  }

  std::string text() const {
    const auto nameOf = [this](int obstacle) {
      return setup_.scene.obstacles()[static_cast<std::size_t>(obstacle)].name;
    };
    const Contact& nearest = last_.nearest;
    std::string text =
        fmt::format("{:.3g} mm from the start at {:.2g} m/s",
                    1e3 * (last_.pose.position - setup_.start.position).norm(), last_.twist.head<3>().norm());
    if (pushed_ >= 0 && touched_ < last_.time)
      text += fmt::format(", off {} since {:.4g} s", nameOf(pushed_), touched_);
    if (nearest.obstacle >= 0) text += fmt::format(", {:.2g} mm from {}", 1e3 * nearest.gap, nameOf(nearest.obstacle));
    return text;
  }

 private:
  const PushSetup& setup_;
  TickRecord last_;
  int pushed_ = -1;
  double touched_ = 0.0;  // s
};

// The setup that all renderers share.
struct PushTask {
  const PushOptions& options;
  PushSetup setup;
  std::shared_ptr<const Mechanism> device;  // of the file, with the plant's drives: servos are designed for it
  std::shared_ptr<const Mechanism> plant;   // the same with the damping of --device-damping
  MakePlant makePlant;
  PluginSetup plugin;
  double damping = 0.0;  // of the plant along the normal, N s/m
  double limit = 0.0;    // largest first-impact stiffness, N/m
  RecordingHeader header;

  std::unique_ptr<Plant> makeOne() const {
    return makePlant ? makePlant(setup.run)
                     : std::make_unique<ClosedFormPlant>(*plant, setup.integrator, setup.substeps);
  }
};

// Files written and metrics measured so far.
struct PushResults {
  std::vector<PushOutcome> outcomes;
  std::vector<std::string> files, recordings;
};

PushTask taskOf(const PushOptions& options) {
  DeviceParameters parameters = loadDevice(options.device);
  PushTask task{options, {}, makeMechanism(modelFor(options.plant, parameters)), {}, {}, {}, 0.0, 0.0, {}};
  addDamping(parameters, options.deviceDamping * Vec6::Unit(2));
  task.plant = makeMechanism(modelFor(options.plant, parameters));
  task.setup = setupOf(options);
  task.makePlant = makerOf(options.plant, parameters, task.setup);
  return task;
}

// Complete the parts of the task that need the checked options.
void completeTask(PushTask& task) {
  const PushOptions& options = task.options;
  task.plugin = {options.device, "", options.scene, "", parseParameters(options.set)};
  task.damping = dampingAlong(*task.plant, task.setup.start, task.setup.hand.normal);
  task.limit = largestStiffness(*task.plant, task.setup);
  if (options.record.empty()) return;
  const auto place = [](const std::string& file) {
    return std::filesystem::absolute(std::filesystem::u8path(file)).lexically_normal();
  };
  if (!options.output.empty() && place(options.output) == place(options.record))
    throw Error("--record and --output must be different files, both are " + options.record);
  task.header = headerOf(options, task.setup);
}

// Close a recording. Return its name and the number of lost ticks.
std::string closed(Recorder& recorder, const std::string& file) {
  const RecordingResult recorded = recorder.close();
  if (!recorded.problem.empty()) throw Error(fmt::format("{} ({} ticks are lost)", recorded.problem, recorded.lost));
  return file + (recorded.lost > 0 ? fmt::format(" ({} ticks are lost)", recorded.lost) : "");
}

// Return a hint if the motors cannot hold the push; empty if they can.
std::string overloadHint(const PushTask& task) {
  const HandModel& hand = task.setup.hand;
  Kinematics there;
  if (task.plant->reach(task.setup.start, Vec6::Zero(), false, there) != Status::ok) return "";
  const Vec3 grip = task.setup.start.position + task.setup.start.rotation * hand.grip;
  const double most = largestForce(there, task.plant->limits().effort, grip, hand.normal);
  if (std::max(hand.force, hand.preload) < most) return "";
  return fmt::format("; the motors cannot hold the push of {:.3g} N, their largest force is {:.3g} N: reduce --force{}",
                     std::max(hand.force, hand.preload), most, hand.preload < most ? "" : " and --preload");
}

// Throws Error: the reason why the push ended too early.
void pushWith(const RendererSource& source, PushTask& task, PushResults& results) {
  const PushOptions& options = task.options;
  const auto& [name, library] = source;
  const auto values = library ? task.plugin.parameters : parametersOf(options, name, task.setup.delay);
  const std::unique_ptr<Renderer> renderer =
      library ? makeRenderer(library, task.plugin) : makeLinked(name, values, task.device, task.setup.period);
  if (name == kImpedance && !library) {
    const std::string warning = dampingWarning(options.impedance, task.setup.period, task.damping);
    if (!warning.empty()) fmt::print(stderr, "enamel: warning: {}\n", warning);
  }
  std::optional<TickFile> file;
  if (!options.output.empty()) file.emplace(outputFor(options, options.output, name), *task.device);
  const std::string recording = options.record.empty() ? "" : outputFor(options, options.record, name);
  if (!recording.empty()) nameRenderer(name, library ? library->path() : "", values, task.setup.scene, task.header);
  std::optional<NewRecording> place;
  std::optional<Recorder> recorder;
  MetricsCollector collector(task.setup, task.limit, task.plant->limits().effort);
  WayOut wayOut(task.setup);
  const auto perTick = [&](const TickRecord& tick, const VirtualLoop& loop) {
    collector.add(tick);
    wayOut.add(tick);
    if (file) file->write(tick);
    if (recording.empty()) return;
    if (!recorder) {
      place.emplace(recording, options.overwrite);
      recorder.emplace(place->place(), task.header, loop.hapticTick());
    }
    recorder->makeRoom();
    recorder->add(tick.tick, loop.measurement(), loop.hapticTick(), loop.command(), tick.status);
  };
  const PushResult result = runPush(task.makeOne(), *task.plant, *renderer, task.setup, perTick);
  if (file) file->close();
  if (recorder) {
    const std::string text = closed(*recorder, recording);
    place->keep();
    results.recordings.push_back(text);
  }
  const double end = static_cast<double>(result.ticks) * task.setup.period;
  const PushMetrics metrics = collector.metrics();
  if (result.status != Status::ok && result.status != Status::stopped)
    throw Error(fmt::format("the device left its workspace at {:.6g} s ({}): its pose is {}{}", end, wayOut.text(),
                            toString(result.status), overloadHint(task)));
  results.outcomes.push_back({name, library == nullptr && (name == kHold || name == kImpedance), metrics});
  if (file) results.files.push_back(outputFor(options, options.output, name));
  if (result.status == Status::stopped)
    throw Error(fmt::format("stopped by the guard at {} s: {}{}", end, toString(result.guard), overloadHint(task)));
  if (metrics.verdict == FirstImpactVerdict::unstable)
    throw Error("the loop is unstable: the motors saturate, or the tool oscillates and does not stop");
}

void print(const PushTask& task, const PushResults& results) {
  const PushOptions& options = task.options;
  if (results.outcomes.empty()) return;
  if (options.json) {
    fmt::print("{}", jsonOf(results.outcomes));
    return;
  }
  const HandModel& hand = task.setup.hand;
  const Vec3 start_mm = 1e3 * task.setup.start.position;
  fmt::print(
      "{}: scenario {}, {} N after {} N at ({:.4g}, {:.4g}, {:.4g}) mm against ({:.3g}, {:.3g}, {:.3g}), noise {} N, "
      "guide {}, delay {}, seed {}\nplant of every renderer: {}, mechanical damping {:.4g} N s/m along the "
      "normal{}\n",
      task.device->name(), hand.scenario, hand.force, hand.preload, start_mm.x(), start_mm.y(), start_mm.z(),
      hand.normal.x(), hand.normal.y(), hand.normal.z(), hand.noise, options.guide ? "on" : "off", options.delay,
      task.setup.seed, options.plant, task.damping, options.gain.empty() ? "" : "; servo of hold: " + options.gain);
  fmt::print("{}", tableOf(results.outcomes, hand.scenario));
  for (const std::string& file : results.files) fmt::print("every tick: {}\n", file);
  for (const std::string& file : results.recordings) fmt::print("recording: {}\n", file);
}

void run(const PushOptions& options) {
  PushTask task = taskOf(options);
  const std::vector<RendererSource> sources = sourcesOf(options);
  for (const RendererSource& source : sources)
    for (const std::string& file : {options.output, options.record})
      if (!file.empty()) requireFree(outputFor(options, file, source.name), options.overwrite);
  completeTask(task);
  PushResults results;
  std::string failures;
  for (const RendererSource& source : sources) {
    try {
      pushWith(source, task, results);
    } catch (const std::exception& error) {  // print the results of the other renderers nevertheless
      failures += fmt::format("{}{}: {}", failures.empty() ? "" : "; ", source.name, error.what());
    }
  }
  print(task, results);
  if (!failures.empty()) {
    std::fflush(stdout);
    throw Error(failures);
  }
}

// Add an option with the values "on" and "off".
void addSwitch(CLI::App& command, const std::string& name, bool& value, const std::string& text) {
  command.add_option(name, value, text)
      ->transform(CLI::CheckedTransformer(std::map<std::string, bool>{{"on", true}, {"off", false}}))
      ->default_str(value ? "on" : "off");
}

void addRendererOptions(CLI::App& command, PushOptions& options) {
  command.add_option("--device", options.device, "device file (TOML)")->required();
  command
      .add_option("--renderer", options.renderers,
                  "renderers, separated by commas: position-control (the contact-space servo), hold (the paper's "
                  "servo), impedance, passivity (impedance with time-domain passivity control), or the name (see "
                  "enamel plugins) or path of a plugin")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--set", options.set, "parameter of the plugin, KEY=VALUE")->allow_extra_args(false);
  command.add_option("--gain", options.gain, "file of enamel design with the servo of hold; default: designed at home");
  addSwitch(command, "--release", options.servo.release,
            "hold ends when the wall would pull; off: it never ends, as in the paper");
  addSwitch(command, "--anti-windup", options.servo.antiWindup,
            "the integrators of hold stop while a motor is saturated");
  command.add_option("--stiffness", options.impedance.stiffness, "stiffness of the impedance wall, N/m")
      ->capture_default_str();
  command.add_option("--damping", options.impedance.damping, "damping of the impedance wall, N s/m")
      ->capture_default_str();
  command
      .add_option("--device-damping", options.deviceDamping,
                  "damping of the TCP along z, N s/m, added to that of the device file on the plant of every renderer "
                  "(4 for the paper's spring)")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  takeOldNames(command.add_option("--plant", options.plant, kPlantHelp)
                   ->check(CLI::Validator(checkPlant, ""))
                   ->capture_default_str(),
               "plant");
}

void addPersonOptions(CLI::App& command, PushOptions& options) {
  command
      .add_option("--scenario", options.setup.hand.scenario, "1: a step of force at 1 s; 2: a hand moves into the wall")
      ->capture_default_str();
  auto* scene = command.add_option("--scene", options.scene, "scene file (TOML); default: the wall z = 0");
  for (const auto& [name, value] : {std::pair{"--x", &options.x_mm}, {"--y", &options.y_mm}})
    command.add_option(name, *value, "coordinate of the query point on the wall z = 0, mm")
        ->capture_default_str()
        ->excludes(scene);
  command.add_option("--tip", options.tip_mm, kTipHelp)->delimiter(',')->expected(3)->excludes(scene);
  command.add_option("--force", options.setup.hand.force, "force of the push F_c, N")->capture_default_str();
  command.add_option("--preload", options.setup.hand.preload, "force before the step of scenario 1, with noise, N")
      ->capture_default_str();
  command.add_flag("--inside-tick", options.insideTick,
                   "the step occurs at a random instant inside its tick, not at its beginning");
  command.add_flag("--arm", options.arm,
                   "push scenario 1 through the mass of an arm and a grip (kArm, lib/include/enamel/sim/hand.hpp)");
  command.add_flag("--finger-rest", options.rest,
                   "a finger 15 mm behind the tip rests on a tooth (kFingerRest, lib/include/enamel/sim/hand.hpp)");
  command.add_option("--noise", options.setup.hand.noise, "standard deviation of the person's force, N")
      ->capture_default_str();
}

void addLoopOptions(CLI::App& command, PushOptions& options) {
  addSwitch(command, "--guard", options.setup.guarded,
            "guard; off: every torque passes, and loops are judged to their end");
  command
      .add_option("--max-force", options.setup.force,
                  "largest force of a renderer on the tool, limited by the guard, N")
      ->default_str("no limit");
  addSwitch(command, "--guide", options.guide, "a hand holds x, y and the orientation softly");
  command
      .add_option("--delay", options.delay,
                  "delay of the command, ticks: none, constant:D or random:A..B; position-control knows it")
      ->capture_default_str();
  command.add_flag("--encoders", options.encoders, "round the joint angles to encoder counts");
  command
      .add_option("--rates", options.rates,
                  "joint rates: exact, difference (of the measured angles over a tick) or low-pass (of the "
                  "difference); default: difference with --encoders, else exact")
      ->check(CLI::IsMember({"exact", "difference", "low-pass"}))
      ->default_str("");
  command.add_option("--low-pass", options.lowPass_Hz, "cutoff frequency of --rates low-pass, Hz")
      ->capture_default_str();
  command.add_option("--duration", options.setup.duration, "duration, s")->capture_default_str();
  command.add_option("--seed", options.setup.seed, "seed of all random numbers")->capture_default_str();
  command.add_option("--substeps", options.setup.substeps, "integration steps of a tick")->capture_default_str();
}

}  // namespace

void addPush(CLI::App& app) {
  auto options = std::make_shared<PushOptions>();
  CLI::App* command = app.add_subcommand(
      "push",
      "Simulates one push of a tool against a wall on the virtual device. The wall is z = 0, or the obstacle of a "
      "scene file\nthat is nearest to its start. The person pushes against the surface's normal.\nCSV: one line a "
      "tick, the state before the tick's torque acts; the first line names columns and units.");
  addRendererOptions(*command, *options);
  addPersonOptions(*command, *options);
  addLoopOptions(*command, *options);
  command->add_option("--output", options->output, "file for every tick (CSV)");
  command->add_option("--record", options->record, "file for the recording, for enamel replay and enamel export");
  command->add_flag("--json", options->json, "print the metrics as JSON");
  addOverwrite(*command, options->overwrite);
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
