#include <fmt/core.h>

#include <CLI/CLI.hpp>

#include "commands.hpp"
#include "enamel/session/open_device.hpp"

namespace enamel::app {
namespace {

void list() {
  for (const DeviceListing& row : listDevices()) fmt::print("{}\n  {}\n", row.url, row.summary);
}

}  // namespace

void addDevices(CLI::App& app) {
  app.add_subcommand("devices", "Lists the devices that can be opened, by URL, and the reasons why others cannot.")
      ->callback(list);
}

}  // namespace enamel::app
