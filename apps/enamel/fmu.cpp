#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/guard.hpp"
#include "plant_option.hpp"
#include "plugins/fmi/export.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"

namespace enamel::app {
namespace {

struct FmuOptions {
  std::string device, scene, renderer, plant = kClosedForm, output;
  std::vector<std::string> set;
  int substeps = 1;
  double period = 1e-3, force = kUnlimited;
  bool guard = true, overwrite = false;
  std::uint64_t seed = 1;
};

void run(const FmuOptions& options) {
  fmi::ExportSetup setup;
  setup.deviceFile = options.device;
  setup.sceneFile = options.scene;
  fmi::UnitConfiguration& unit = setup.unit;
  unit.period = options.period;
  unit.substeps = options.substeps;
  unit.seed = options.seed;
  unit.guarded = options.guard;
  unit.force = std::isfinite(options.force) ? options.force : 0.0;
  const DeviceParameters parameters = loadDevice(options.device);
  std::string binary = "enamel_fmi_unit.so";
  if (options.renderer.empty()) {
    if (!options.scene.empty() || !options.set.empty()) throw Error("--scene and --set need --renderer");
    if (options.substeps < 1 || options.substeps > 1000)
      throw Error(fmt::format("--substeps is {}, must be in 1 to 1000", options.substeps));
    unit.plant = options.plant;
    VirtualDeviceSetup ticks;
    ticks.seed = options.seed;
    if (const MakePlant make = makerOf(options.plant, parameters, ticks))
      (void)make(0);  // fail now rather than in the exported unit
    if (options.plant == kMultibody) binary = "enamel_fmi_unit_multibody.so";
  } else {
    if (findRenderer(options.renderer, pluginFolder()).plugin)
      throw Error("--renderer " + options.renderer +
                  " is a plugin, must be position-control, hold, impedance or passivity");
    unit.renderer = options.renderer;
    unit.plant = options.plant;
    unit.parameters = parseParameters(options.set);
    const auto model = makeMechanism(modelFor(options.plant, parameters));
    (void)makeLinked(unit.renderer, unit.parameters, model, unit.period);
    (void)guardFor(*model, unit.period);
  }
  setup.binary = (std::filesystem::u8path(pluginFolder()).parent_path() / "fmi" / binary).u8string();
  fmi::writeUnit(options.output, setup);
  fmt::print("{}: {} of {}, {} s a step\n", options.output,
             options.renderer.empty() ? "plant " + options.plant : "renderer " + options.renderer, nameOf(parameters),
             options.period);
}

}  // namespace

void addFmu(CLI::App& app) {
  auto options = std::make_shared<FmuOptions>();
  CLI::App* command =
      app.add_subcommand("fmu",
                         "Writes a unit of FMI 3.0 for co-simulation: a device in motion, or with --renderer a haptic "
                         "tick (contacts, renderer, guard).\nIts variables: plugins/fmi/README.md.");
  command->add_option("--device", options->device, "device file (TOML)")->required();
  command->add_option("--output", options->output, "file for the unit, *.fmu")->required();
  takeOldNames(command
                   ->add_option("--plant", options->plant,
                                std::string(kPlantHelp) + "; with --renderer, the plant for which the renderer is made")
                   ->check(CLI::IsMember(plantNames()))
                   ->capture_default_str(),
               "plant");
  command->add_option("--renderer", options->renderer,
                      "position-control, hold, impedance or passivity; without it, the unit is a plant");
  command->add_option("--scene", options->scene,
                      "scene file (TOML) of the renderer; default: the wall z = 0 and a point");
  command->add_option("--set", options->set, "parameter of the renderer, KEY=VALUE, with the names of its plugin")
      ->allow_extra_args(false);
  command->add_option("--period", options->period, "period of the ticks, s")->capture_default_str();
  command->add_option("--substeps", options->substeps, "integration steps of a plant in each step of the unit")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed that selects an imperfect plant within the tolerances")
      ->capture_default_str();
  command->add_option("--max-force", options->force, "largest force of a renderer on the tool, limited by its guard, N")
      ->default_str("no limit");
  const std::map<std::string, bool> onOff = {{"on", true}, {"off", false}};
  command->add_option("--guard", options->guard, "guard of a renderer; off: every torque passes")
      ->transform(CLI::CheckedTransformer(onOff))
      ->default_str("on");
  addOverwrite(*command, options->overwrite, {"--output"});
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
