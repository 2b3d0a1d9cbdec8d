#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_design.hpp"
#include "enamel/study/wall_trials.hpp"
#include "program/plugin_folder.hpp"
#include "renderer_option.hpp"

namespace enamel::app {
namespace {

struct TrialsOptions {
  std::string device, filter;
  std::vector<std::string> renderers = {kPositionControl, kHold, kImpedance}, gains, set;
  std::string delay = "none";
  double deviceDamping = 0.0, inertia = 1.0;
  ImpedanceOptions impedance;
  int threads = 0;
  WallTrialSetup setup;
};

struct Column {
  std::string name;
  std::function<std::unique_ptr<Renderer>()> renderer;
};

// A linked renderer, with a servo file or (where `gain` is "") as it comes.
Column linkedColumn(const TrialsOptions& options, const std::string& name, const std::string& gain) {
  const WallTrialSetup& setup = options.setup;
  const std::string title = gain.empty() ? name : std::filesystem::path(gain).stem().string();
  if (name == kPositionControl) {
    const SurfaceServoOptions servo = surfaceServo(gain, *setup.model, setup.period, setup.delay.low, setup.delay.high);
    return {title, [servo] { return std::make_unique<SurfaceServoRenderer>(servo); }};
  }
  if (name == kHold) {
    const ServoGain K = gain.empty() ? ServoGain(designServo(setup.model, Pose{}, setup.period).K)
                                     : loadGain(gain, setup.model->joints(), setup.period);
    return {title, [K, period = setup.period] {
              return std::make_unique<PositionControlRenderer>(K, period, PositionControlOptions{});
            }};
  }
  return {title, [name, wall = options.impedance]() -> std::unique_ptr<Renderer> {
            auto renderer = std::make_unique<ImpedanceRenderer>(wall);
            if (name == kPassivity) return std::make_unique<PassivityRenderer>(std::move(renderer));
            return renderer;
          }};
}

std::vector<Column> columnsOf(const TrialsOptions& options) {
  std::vector<Column> columns;
  bool plugins = false;
  for (const std::string& text : options.renderers) {
    const RendererSource source = findRenderer(text, pluginFolder());
    if (source.plugin) {
      const PluginSetup plugin{options.device, "", "", "", parseParameters(options.set)};
      columns.push_back({source.name, [library = source.plugin, plugin] { return makeRenderer(library, plugin); }});
      plugins = true;
    } else {
      columns.push_back(linkedColumn(options, source.name, ""));
    }
  }
  if (!options.set.empty() && !plugins) throw Error("--set is for plugins, and --renderers names none");
  for (const std::string& gain : options.gains) columns.push_back(linkedColumn(options, rendererOf(gain), gain));
  for (const Column& column : columns) (void)column.renderer();  // refuses here what a run would refuse
  return columns;
}

void run(TrialsOptions options) {
  DeviceParameters parameters = loadDevice(options.device);
  options.setup.model = withInertia(makeMechanism(parameters), options.inertia);
  addDamping(parameters, options.deviceDamping * Vec6::Unit(2));
  options.setup.plant = makeMechanism(parameters);
  options.setup.delay = parseDelay(options.delay);
  const std::vector<Column> columns = columnsOf(options);
  const int threads = options.threads > 0 ? options.threads : availableThreads();

  std::vector<std::vector<WallFigure>> figures;
  for (const Column& column : columns) {
    options.setup.renderer = column.renderer;
    figures.push_back(runWallTrials(options.setup, options.filter, threads));
  }
  if (figures.front().empty()) throw Error("no trial matches --filter " + options.filter);

  fmt::print("{}: delay {}, the worst of {} runs; noise {:.3g} N, forces {:.3g} of what the names say\n",
             options.setup.plant->name(), options.delay, options.setup.runs,
             options.setup.noise * forceShare(*options.setup.plant), forceShare(*options.setup.plant));
  fmt::print("{:<16} {:<28} {:<4}", "", "", "");
  for (const Column& column : columns) fmt::print(" {:>18}", column.name);
  fmt::print("\n");
  for (std::size_t row = 0; row < figures.front().size(); ++row) {
    const WallFigure& named = figures.front()[row];
    fmt::print("{:<16} {:<28} {:<4}", named.trial, named.figure, named.unit);
    for (const std::vector<WallFigure>& column : figures) {
      const WallFigure& f = column[row];
      const std::string value = std::isnan(f.value) ? "-" : fmt::format("{:.3g}", f.value);
      fmt::print(" {:>18}", f.lost > 0 ? fmt::format("{} ({} lost)", value, f.lost) : value);
    }
    fmt::print("\n");
  }
}

}  // namespace

void addTrials(CLI::App& app) {
  auto options = std::make_shared<TrialsOptions>();
  CLI::App* command = app.add_subcommand(
      "trials",
      "What people do to a wall besides the study's push, on the virtual device with encoders: steps, ramps, impacts,\n"
      "letting go, sliding, more than the motors can hold. A column a renderer.");
  command->add_option("--device", options->device, "device file (TOML)")->required();
  command
      ->add_option("--renderers", options->renderers,
                   "separated by commas: position-control, hold, impedance, passivity, names and paths of plugins")
      ->delimiter(',')
      ->capture_default_str();
  command
      ->add_option("--gain", options->gains,
                   "files of servos, separated by commas: a further column each, position-control's or hold's")
      ->delimiter(',');
  command->add_option("--set", options->set, "parameter of the plugins, KEY=VALUE")->allow_extra_args(false);
  command->add_option("--stiffness", options->impedance.stiffness, "of the impedance wall, N/m")->capture_default_str();
  command->add_option("--damping", options->impedance.damping, "of the impedance wall, N s/m")->capture_default_str();
  command
      ->add_option("--device-damping", options->deviceDamping,
                   "of the TCP along z, N s/m, beside what the device file gives, for every renderer")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
  command
      ->add_option("--delay", options->delay,
                   "of the command, ticks: none, constant:D or random:A..B; position-control is told")
      ->capture_default_str();
  command->add_option("--inertia", options->inertia, "of the renderers' model, as a share of the plant's")
      ->capture_default_str();
  command->add_option("--filter", options->filter, "only trials whose name contains this text");
  command->add_option("--runs", options->setup.runs, "a trial")->capture_default_str();
  command->add_option("--noise", options->setup.noise, "standard deviation of the person's force, N")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command->add_option("--seed", options->setup.seed, "of everything random")->capture_default_str();
  command->add_option("--threads", options->threads, "without it, one a core; the result does not depend on it");
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
