#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "bench/measurement.hpp"
#include "commands.hpp"
#include "enamel/core/error.hpp"

namespace enamel::app {
namespace {

struct BenchOptions {
  std::string filter;
  double scale = 1.0;
};

std::string cell(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

void run(const BenchOptions& options) {
  const auto rows = bench::measureAll(options.filter, options.scale);
  if (rows.empty()) throw Error("no measurement matches --filter " + options.filter);
  fmt::print("{:<62} {:>10} {:>10} {:>10} {:>8} {:>8} {:>9}  {}\n", "per call", "median us", "p99 us", "p99.9 us",
             "goal us", "ratio*", "error", "error of");
  for (const auto& row : rows)
    fmt::print("{:<62} {:>10.4g} {:>10.4g} {:>10} {:>8} {:>8} {:>9.1e}  {}\n", row.group + ": " + row.name,
               row.median_us, row.p99_us, cell(row.p999_us, "{:.4g}"), cell(row.goal_us, "{:.4g}"),
               cell(row.reference_us / row.median_us, "{:.1f}"), row.error, row.errorOf);
  fmt::print(
      "* how many times faster than the conventional way, measured in the same run. Times are noisy on a shared\n"
      "  machine: trust the ratios. p99 is over batches of calls, for collision and solid over single calls.\n");
}

}  // namespace

void addBench(CLI::App& app) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand("bench", "Speed against error: one row a measurement, times in microseconds");
  command->add_option(
      "--filter", options->filter,
      "only rows whose name contains this text; a group first (device, control, tick, collision, solid, plant) "
      "measures only that one");
  command->add_option("--scale", options->scale, "multiplies the number of batches")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
