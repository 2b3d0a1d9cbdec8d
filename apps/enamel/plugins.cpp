#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "child_process.hpp"
#include "commands.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/plugin/driver_conformance.hpp"
#include "enamel/session/open_device.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"
#ifdef ENAMEL_COUNTS_ALLOCATIONS
#include "allocation_counter.hpp"
#endif

namespace enamel::app {
namespace {

struct ListOptions {
  std::string folder = pluginFolder();
  double limit = 2.0;  // s
};

std::string describe(const EnamelDescription& d, const std::string& path, const char* kind, const char* option) {
  std::string text = fmt::format("{} {} ({}): {}\n  {}\n", d.name, d.version, kind, d.summary, path);
  for (std::size_t i = 0; i < d.parameter_count; ++i) {
    const EnamelParameter& p = d.parameters[i];
    text += fmt::format("  {}{}={}  {}\n", option, p.key, *p.value != 0 ? p.value : "...", p.meaning);
  }
  return text;
}

std::string describe(const std::string& file) {
  if (isDriver(file)) return describe(DriverLibrary::load(file)->description(), file, "driver", "?");
  return describe(PluginLibrary::load(file)->description(), file, "renderer", "--set ");
}

void list(const ListOptions& options) {
  const std::vector<std::string> files = pluginFiles(options.folder);
  for (const std::string& file : files) {
    const ChildResult result = runInChild(file + ": loading it", options.limit, [&file] { return describe(file); });
    fmt::print("{}", result.failure.empty() ? result.answer : "refused: " + result.failure + "\n");
  }
  if (files.empty()) fmt::print("no plugins in {}\n", options.folder);
}

struct CheckOptions {
  std::string file, device, address;
  std::vector<std::string> set;
  double limit = 20.0;  // s
};

void printCheck(const ConformanceResult& result) {
  const char* verdicts[] = {"passed", "FAILED", "not checked"};
  fmt::print("{:<12} {}{}{}\n", verdicts[static_cast<int>(result.verdict)], result.what,
             result.detail.empty() ? "" : ": ", result.detail);
  std::fflush(stdout);
}

// Print one line for each check.
bool keepsContract(const CheckOptions& options) {
  PluginSetup setup;
  setup.parameters = parseParameters(options.set);
  if (options.device.empty())
    setup.deviceText = nominalDeviceText();
  else
    setup.devicePath = options.device;
  ConformanceOptions conformance;
#ifdef ENAMEL_COUNTS_ALLOCATIONS
  conformance.allocationCount = &threadAllocationCount;
#endif
  return checkPlugin(PluginLibrary::load(options.file), setup, conformance, printCheck);
}

bool keepsDriverContract(const CheckOptions& options) {
  DriverConformanceOptions conformance;
  const bool isUrl = isDeviceUrl(options.file);
  DeviceUrl url = parseDeviceUrl(isUrl ? options.file : "driver://" + options.address);
  url.options.erase("device");  // the host has these two
  url.options.erase("delay");
  conformance.address = url.address;
  conformance.options = url.options;
  const auto driver = findDriver(isUrl ? url.scheme : options.file, pluginFolder());
  (void)connectDriver(driver, url.address, url.options);  // without the device, the contract cannot be checked
#ifdef ENAMEL_COUNTS_ALLOCATIONS
  conformance.allocationCount = &threadAllocationCount;
#endif
  return checkDriver(driver, conformance, printCheck);
}

void check(const CheckOptions& options, bool (*keeps)(const CheckOptions&)) {
  const ChildResult result = runInChild(options.file + ": the check that follows the last line above", options.limit,
                                        [&] { return keeps(options) ? "kept" : "broken"; });
  if (!result.failure.empty()) throw Error(result.failure);
  if (result.answer != "kept") throw Error(options.file + ": the plugin does not keep the contract");
  fmt::print("the plugin keeps the contract\n");
}

void addLimit(CLI::App& command, double& limit) {
  command
      .add_option(
          "--time-limit", limit,
          "limit of computing time, s; a plugin is stopped when it exceeds this, or after three times as long in total")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
}

}  // namespace

void addPlugins(CLI::App& app) {
  auto listing = std::make_shared<ListOptions>();
  CLI::App* plugins =
      app.add_subcommand("plugins",
                         "Lists the renderers and drivers of a folder, and the reasons why others were refused.\nEach "
                         "plugin is loaded in its own process. A plugin that throws, crashes or hangs is refused.");
  plugins->add_option("folder", listing->folder, "folder of plugins; default: the plugins of this program");
  addLimit(*plugins, listing->limit);
  plugins->callback([listing] { list(*listing); });

  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand("check-plugin",
                                         "Runs a plugin and checks that it keeps the contract: order of calls, reset, "
                                         "state, bad input, allocation, limits.\nThe exit status is 0 if it does.");
  command->add_option("file", options->file, "plugin (.so)")->required();
  command->add_option("--device", options->device, "device file (TOML); default: the nominal TAU");
  command->add_option("--set", options->set, "parameter of the plugin, KEY=VALUE")->allow_extra_args(false);
  addLimit(*command, options->limit);
  command->callback([options] { check(*options, keepsContract); });

  auto driver = std::make_shared<CheckOptions>();
  command = app.add_subcommand("check-driver",
                               "Runs a driver with a connected device and checks that it keeps the contract: order of "
                               "calls, samples, times, bad "
                               "efforts, allocation.\nAll efforts are zero. The exit status is 0 if it does.");
  command->add_option("driver", driver->file, "driver (.so), its name in the plugin folder, or the URL of a device")
      ->required();
  command->add_option("address", driver->address, "address and options of the device, as in its URL after ://");
  addLimit(*command, driver->limit);
  command->callback([driver] { check(*driver, keepsDriverContract); });
}

}  // namespace enamel::app
