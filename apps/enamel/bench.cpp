#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <fstream>
#include <memory>
#include <thread>

#include "bench/measurement.hpp"
#include "commands.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "program/outputs.hpp"
#include "program/program.hpp"

namespace enamel::app {
namespace {

struct BenchOptions {
  std::string filter, report;
  double scale = 1.0;
  bool overwrite = false;
};

std::string cell(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

// Return the processor's name from Linux.
std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "a processor without a name";
}

// Return a page in Markdown with one table for each group.
std::string pageOf(const std::vector<bench::Measurement>& rows) {
  constexpr const char* kLevels[] = {"baseline", "AVX2", "AVX-512"};
  std::string page = fmt::format(
      "# What Enamel costs: speed against error\n\n{}, {} threads, loops for {}; enamel {}.\n\nTimes of one call, us. "
      "*faster*: the speed relative to the conventional method, or to the reference of the same row, in the same run. "
      "On a shared machine, times change from minute to minute: compare the ratios. p99 is over batches of calls; for "
      "collision, scene, session and solid it is over single calls.\n",
      processor(), std::thread::hardware_concurrency(), kLevels[static_cast<int>(simdLevel())], buildText());
  std::string group;
  for (const auto& row : rows) {
    if (row.group != group)
      page += fmt::format("\n## {}\n| | median | p99 | p99.9 | faster | error | of |\n|---|---|---|---|---|---|---|\n",
                          row.group);
    group = row.group;
    page += fmt::format("| {} | {:.4g} | {:.4g} | {} | {} | {:.1e} | {} |\n", row.name, row.median_us, row.p99_us,
                        cell(row.p999_us, "{:.4g}"), cell(row.reference_us / row.median_us, "{:.1f}"), row.error,
                        row.errorOf);
  }
  return page;
}

void run(const BenchOptions& options) {
  const auto rows = bench::measureAll(options.filter, options.scale);
  if (rows.empty()) throw Error("no measurement matches --filter " + options.filter);
  if (!options.report.empty()) writeFile(options.report, pageOf(rows));
  fmt::print("{:<62} {:>10} {:>10} {:>10} {:>8} {:>8} {:>9}  {}\n", "per call", "median us", "p99 us", "p99.9 us",
             "goal us", "ratio*", "error", "error of");
  for (const auto& row : rows)
    fmt::print("{:<62} {:>10.4g} {:>10.4g} {:>10} {:>8} {:>8} {:>9.1e}  {}\n", row.group + ": " + row.name,
               row.median_us, row.p99_us, cell(row.p999_us, "{:.4g}"), cell(row.goal_us, "{:.4g}"),
               cell(row.reference_us / row.median_us, "{:.1f}"), row.error, row.errorOf);
  fmt::print(
      "* speed relative to the conventional method, measured in the same run. Times are noisy on a shared machine:\n  "
      "compare the ratios. p99 is over batches of calls; for collision, scene, session and solid it is over single "
      "calls.\n");
}

}  // namespace

void addBench(CLI::App& app) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command =
      app.add_subcommand("bench", "Measures speed against error: one row a measurement, times in microseconds");
  command->add_option("--filter", options->filter,
                      "measures only rows whose name contains this text; if the text begins with a group (device, "
                      "control, tick, collision, scene, session, solid, plant), only rows of that group");
  command->add_option("--report", options->report,
                      "file for the table as a page in Markdown, which also names the machine");
  command->add_option("--scale", options->scale, "factor of the number of batches")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  addOverwrite(*command, options->overwrite, {"--report"});
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
