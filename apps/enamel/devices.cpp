#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "child_process.hpp"
#include "commands.hpp"
#include "enamel/plugin/driver_host.hpp"
#include "enamel/session/open_device.hpp"
#include "program/plugin_folder.hpp"

namespace enamel::app {
namespace {

constexpr double kLongestList = 5.0;  // s, of computing time, for a driver that looks for its devices

// Return the lines of a driver; empty for a renderer.
std::string devicesOf(const std::string& file) {
  if (!isDriver(file)) return "";
  const auto driver = DriverLibrary::load(file);
  const EnamelDescription& d = driver->description();
  std::string text = fmt::format("{}://\n  {}\n", d.name, d.summary);
  try {
    for (const DriverListing& row : listDriver(*driver))
      text += fmt::format("  connected: {}://{}  {}\n", d.name, row.address, row.text);
  } catch (const PluginError& none) {
    text += fmt::format("  none is connected: {}\n", none.what());
  }
  return text;
}

void listDevices() {
  for (const DeviceForm& built : builtInDevices()) fmt::print("{}\n  {}\n", built.form, built.summary);
  std::error_code ignored;
  const std::string folder = pluginFolder();
  if (!std::filesystem::is_directory(std::filesystem::u8path(folder), ignored)) return;
  for (const std::string& file : pluginFiles(folder)) {
    // A driver or a library of its vendor may crash or hang.
    const ChildResult result =
        runInChild(file + ": looking for its devices", kLongestList, [&file] { return devicesOf(file); });
    fmt::print("{}", result.failure.empty() ? result.answer : "refused: " + result.failure + "\n");
  }
}

}  // namespace

void addDevices(CLI::App& app) {
  app.add_subcommand("devices", "Lists the devices that can be opened, by URL, and the reasons why others cannot.")
      ->callback(listDevices);
}

}  // namespace enamel::app
