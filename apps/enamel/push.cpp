#include <fmt/core.h>
#include <fmt/os.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "plugin_folder.hpp"
#include "renderers.hpp"

namespace enamel::app {
namespace {

struct PushOptions {
  std::string device, scene, output;
  std::vector<std::string> renderers = {kPositionControl};
  std::string mode = "hold", delay = "none";
  bool release = true, guide = true, encoders = false, antiWindup = false, json = false;
  std::string rates;
  std::vector<std::string> set;
  double x_mm = 0.0, y_mm = 0.0, lowPass_Hz = 100.0;
  ImpedanceOptions impedance{6000.0, 0.0, 4.0};
  PushSetup setup;
};

class CsvFile {
 public:
  explicit CsvFile(const std::string& path) : path_(path), file_(std::fopen(path.c_str(), "w"), &std::fclose) {
    if (!file_) throw Error(path + ": cannot write the file");
    fmt::print(file_.get(),
               "t [s],x [m],y [m],z [m],alpha [rad],beta [rad],gamma [rad],vx [m/s],vy [m/s],vz [m/s],wx [rad/s],"
               "wy [rad/s],wz [rad/s],gap [m],person fx [N],person fy [N],person fz [N],rendered fx [N],rendered fy "
               "[N],rendered fz [N],"
               "wall force [N],q1 [rad],q2 [rad],q3 [rad],q4 [rad],q5 [rad],q6 [rad],tau1 [N m],tau2 [N m],tau3 [N m],"
               "tau4 [N m],tau5 [N m],tau6 [N m],mode,saturated,status\n");
  }

  void write(const TickRecord& t) {
    line_ = fmt::format("{}", t.time);
    const Vec3 euler = eulerFromRotation(t.pose.rotation);
    append(t.pose.position.data(), 3);
    append(euler.data(), 3);
    append(t.twist.data(), 6);
    append(&t.nearest.gap, 1);
    append(t.person.data(), 3);
    append(t.rendered.data(), 3);
    append(&t.normalForce, 1);
    append(t.q.data(), 6);
    append(t.torque.data(), 6);
    fmt::print(file_.get(), "{},{},{},{}\n", line_, toString(t.mode), t.saturated ? 1 : 0, toString(t.status));
  }

  void close() {
    const bool failed = std::ferror(file_.get()) != 0;
    if (std::fclose(file_.release()) != 0 || failed) throw Error(path_ + ": cannot write the file (is the disk full?)");
  }

 private:
  void append(const double* values, int count) {
    for (int i = 0; i < count; ++i) fmt::format_to(std::back_inserter(line_), ",{}", values[i]);
  }

  std::string path_, line_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

// One metric: its name, unit, how to read it, and the paper's figure for each renderer at any query point.
struct Row {
  const char* name;
  const char* unit;
  double scale;
  std::optional<double> (*value)(const PushMetrics&);
  const char* paperServo;
  const char* paperImpedance;
};

const Row kRows[] = {
    {"first impact depth D_z1", "mm", 1e3, [](const PushMetrics& m) { return m.firstDepth; }, "-", "-"},
    {"first impact stiffness K_z1", "kN/m", 1e-3, [](const PushMetrics& m) { return m.firstStiffness; }, "lowest 17.2",
     "highest 3.11"},
    {"steady depth D_zs (signed mean)", "mm", 1e3, [](const PushMetrics& m) { return std::optional(m.steadyDepth); },
     "-", "-"},
    {"steady compliance C_zs", "mm/N", 1e3, [](const PushMetrics& m) { return std::optional(m.steadyCompliance); },
     "highest 0.0108", "lowest 0.162"},
    {"rms depth", "mm", 1e3, [](const PushMetrics& m) { return std::optional(m.rmsDepth); }, "-", "-"},
    {"95 % depth", "mm", 1e3, [](const PushMetrics& m) { return std::optional(m.depth95); }, "-", "-"},
    {"largest depth", "mm", 1e3, [](const PushMetrics& m) { return std::optional(m.largestDepth); }, "below 1", "-"},
    {"chatter (torque std, last second)", "N m", 1.0, [](const PushMetrics& m) { return std::optional(m.chatter); },
     "-", "-"},
    {"saturated ticks", "%", 100.0, [](const PushMetrics& m) { return std::optional(m.saturatedShare); }, "-", "-"},
    {"tangential force (rms)", "N", 1.0, [](const PushMetrics& m) { return std::optional(m.tangentialForce); }, "-",
     "-"},
    {"work on the tool", "J", 1.0, [](const PushMetrics& m) { return std::optional(m.work); }, "-", "-"},
    {"drift across the normal", "mm", 1e3, [](const PushMetrics& m) { return std::optional(m.drift); }, "-", "-"},
};

std::string cell(const std::optional<double>& value, double scale) {
  return value ? fmt::format("{:.4g}", *value * scale) : "none";
}

void printTable(const std::vector<std::string>& names, const std::vector<PushMetrics>& metrics, int scenario) {
  fmt::print("{:<42}", "");
  for (const std::string& name : names) fmt::print("{:>18}{:>18}", name, scenario == 1 ? "(paper*)" : "");
  fmt::print("\n");
  for (const Row& row : kRows) {
    fmt::print("{:<42}", fmt::format("{} [{}]", row.name, row.unit));
    for (std::size_t i = 0; i < names.size(); ++i)
      fmt::print("{:>18}{:>18}", cell(row.value(metrics[i]), row.scale),
                 scenario != 1            ? ""
                 : names[i] == kImpedance ? row.paperImpedance
                                          : row.paperServo);
    fmt::print("\n");
  }
  if (scenario == 1) fmt::print("* extremes over the paper's 121 query points on its own device: compare magnitudes\n");
}

// run.csv, or run-impedance.csv where several renderers write beside each other.
std::string outputFor(const PushOptions& options, const std::string& renderer) {
  if (options.renderers.size() == 1) return options.output;
  std::filesystem::path path(options.output);
  path.replace_filename(path.stem().string() + "-" + renderer + path.extension().string());
  return path.string();
}

void run(PushOptions options) {
  const TauParameters device = loadTau(options.device);
  const TauModel model = makeModel(device);
  PushSetup& setup = options.setup;
  setup.start.position = Vec3(1e-3 * options.x_mm, 1e-3 * options.y_mm, 0.0);
  if (!options.scene.empty()) {
    SceneFile file = loadScene(options.scene);
    setup.scene = std::move(file.scene);
    setup.tool = file.tool;
    setup.start.position = file.start;
    // To the surface: steps of the distance, which become small as fast as the surface allows.
    Contact nearest = nearestContact(setup.scene, setup.tool, setup.start, nullptr);
    for (int step = 0; step < 100 && std::abs(nearest.gap) > 1e-12; ++step) {
      setup.start.position -= nearest.gap * nearest.normal;
      nearest = nearestContact(setup.scene, setup.tool, setup.start, nullptr);
    }
    setup.person.normal = nearest.normal;
  }
  setup.person.guide = options.guide;
  setup.delay = parseDelay(options.delay);
  setup.encoders.quantised = options.encoders;
  setup.encoders.cutoff = options.lowPass_Hz;
  setup.encoders.rates = options.rates == "difference" ? RateSource::difference
                         : options.rates == "low-pass" ? RateSource::lowPass
                         : options.rates == "exact"    ? RateSource::exact
                         : options.encoders            ? RateSource::difference
                                                       : RateSource::exact;
  checkPush(setup);
  const DampingBound bound = dampingBound(options.impedance, setup.period);

  std::vector<RendererSource> sources;
  for (std::string& name : options.renderers) {
    sources.push_back(findRenderer(name));
    name = sources.back().name;
    if (std::count(options.renderers.begin(), options.renderers.end(), name) > 1)
      throw Error("--renderer names " + name + " twice");
  }
  const PluginSetup plugin{options.device, "", options.scene, "", parseParameters(options.set)};
  if (!plugin.parameters.empty() &&
      std::none_of(sources.begin(), sources.end(), [](const auto& s) { return s.plugin; }))
    throw Error("--set is for plugins, and --renderer names none");

  std::vector<PushMetrics> metrics;
  nlohmann::ordered_json json;
  for (const RendererSource& source : sources) {
    const std::string& name = source.name;
    const TauModel plant = plantFor(name, device, options.impedance);
    PositionControlOptions servo;
    servo.release = options.release;
    servo.antiWindup = options.antiWindup;
    const std::unique_ptr<Renderer> renderer = source.plugin
                                                   ? makeRenderer(source.plugin, plugin)
                                                   : makeRenderer(name, model, setup.period, servo, options.impedance);
    std::optional<CsvFile> csv;
    if (!options.output.empty()) csv.emplace(outputFor(options, name));
    MetricsCollector collector(setup);
    const PushResult result = runPush(plant, *renderer, setup, [&](const TickRecord& tick) {
      collector.add(tick);
      if (csv) csv->write(tick);
    });
    if (csv) csv->close();
    if (result.status != Status::ok)
      throw Error(fmt::format("{}: the device left its workspace at {} s: its pose is {}", name,
                              static_cast<double>(result.ticks) * setup.period, toString(result.status)));
    metrics.push_back(collector.metrics());
    json[name] = toJson(metrics.back());
    if (name == kImpedance && !bound.met)
      fmt::print(stderr,
                 "enamel: warning: a stiffness of {} N/m and a damping of {} N s/m need more than {} N s/m of device "
                 "damping at {} s (eq. 16), there are {}\n",
                 options.impedance.stiffness, options.impedance.damping, bound.required, setup.period, bound.available);
  }
  if (options.json) {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  const Vec3 start_mm = 1e3 * setup.start.position;
  fmt::print(
      "{}: scenario {}, {} N at ({:.4g}, {:.4g}, {:.4g}) mm against ({:.3g}, {:.3g}, {:.3g}), noise {} N, "
      "guide {}, delay {}, seed {}\n",
      device.name, setup.person.scenario, setup.person.force, start_mm.x(), start_mm.y(), start_mm.z(),
      setup.person.normal.x(), setup.person.normal.y(), setup.person.normal.z(), setup.person.noise,
      options.guide ? "on" : "off", options.delay, setup.seed);
  printTable(options.renderers, metrics, setup.person.scenario);
  if (!options.output.empty())
    for (const std::string& name : options.renderers) fmt::print("every tick: {}\n", outputFor(options, name));
}

}  // namespace

void addPush(CLI::App& app) {
  auto options = std::make_shared<PushOptions>();
  CLI::App* command = app.add_subcommand(
      "push",
      "One push of a tool against a wall, on the virtual device: z = 0, or the obstacle of a scene file that is "
      "nearest to\n"
      "its start. The person pushes against the surface's normal.\n"
      "CSV: one line a tick, the state before the tick's torque acts; the first line names columns and units.");
  const std::map<std::string, bool> onOff = {{"on", true}, {"off", false}};
  const auto flag = [&](const std::string& name, bool& value, const std::string& text) {
    command->add_option(name, value, text)
        ->transform(CLI::CheckedTransformer(onOff))
        ->default_str(value ? "on" : "off");
  };
  command->add_option("--device", options->device, "device file (TOML)")->required();
  command
      ->add_option("--renderer", options->renderers,
                   "position-control, impedance, the name of a plugin (see enamel plugins) or its path; several are "
                   "separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--set", options->set, "parameter of the plugin, KEY=VALUE");
  command->add_option("--mode", options->mode, "of position-control: hold (sticks to the point of touch)")
      ->check(CLI::IsMember({"hold"}))
      ->capture_default_str();
  flag("--release", options->release, "on: the hold ends when the wall would pull; off: never, as in the paper");
  flag("--anti-windup", options->antiWindup, "on: the integrators stop while a motor is saturated");
  command->add_option("--stiffness", options->impedance.stiffness, "of the impedance wall, N/m")->capture_default_str();
  command->add_option("--damping", options->impedance.damping, "of the impedance wall, N s/m")->capture_default_str();
  command
      ->add_option("--device-damping", options->impedance.deviceDamping,
                   "mechanical damping of the TCP along z under the impedance wall, N s/m")
      ->capture_default_str();
  command->add_option("--scenario", options->setup.person.scenario, "1: step of force at 1 s; 2: a hand moves in")
      ->capture_default_str();
  auto* scene = command->add_option("--scene", options->scene, "scene file (TOML); without it the wall z = 0");
  for (const auto& [name, value] : {std::pair{"--x", &options->x_mm}, {"--y", &options->y_mm}})
    command->add_option(name, *value, "of the query point on the wall z = 0, mm")
        ->capture_default_str()
        ->excludes(scene);
  command->add_option("--force", options->setup.person.force, "F_c, N")->capture_default_str();
  command->add_option("--noise", options->setup.person.noise, "standard deviation of the person's force, N")
      ->capture_default_str();
  flag("--guide", options->guide, "on: a hand holds x, y and the orientation softly");
  command->add_option("--delay", options->delay, "of the command, ticks: none, constant:D or random:A..B")
      ->capture_default_str();
  command->add_flag("--encoders", options->encoders, "round the joint angles to encoder counts");
  command
      ->add_option(
          "--rates", options->rates,
          "joint rates: exact, difference (of the measured angles over a tick) or low-pass (of the difference); "
          "difference with --encoders, else exact")
      ->check(CLI::IsMember({"exact", "difference", "low-pass"}))
      ->default_str("");
  command->add_option("--low-pass", options->lowPass_Hz, "cutoff of --rates low-pass, Hz")->capture_default_str();
  command->add_option("--duration", options->setup.duration, "s")->capture_default_str();
  command->add_option("--seed", options->setup.seed, "of everything random")->capture_default_str();
  command->add_option("--substeps", options->setup.substeps, "integration steps a tick")->capture_default_str();
  command->add_option("--output", options->output, "CSV file");
  command->add_flag("--json", options->json, "print the metrics as JSON");
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
