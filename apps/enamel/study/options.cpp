#include "study/options.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <tuple>

#include "enamel/core/error.hpp"
#include "program/outputs.hpp"

namespace enamel::app {
namespace {

std::pair<int, int> parsePart(const std::string& text) {
  int part = 0, parts = 0, end = 0;
  if (std::sscanf(text.c_str(), "%d/%d%n", &part, &parts, &end) != 2 || end != static_cast<int>(text.size()) ||
      part < 1 || part > parts || parts > 100000)
    throw Error("--part is \"" + text + "\", must be I/N with I in 1 to N");
  return {part, parts};
}

void addRendererOptions(CLI::App& command, StudyOptions& options) {
  command
      .add_option(
          "--renderers", options.renderers,
          "separated by commas; passivity: impedance under a time-domain passivity controller; hold-scheduled: hold "
          "with a servo designed at every query point; tuned:NAME: a rival with the values of --tuned; impedance-edge: "
          "a spring at four times the rate, as stiff as eq. 16 allows; FILE.json: hold with this "
          "servo file; also names and paths of plugins")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--set", options.set, "parameter of the plugins that have it, KEY=VALUE; may be given again")
      ->allow_extra_args(false);
  command.add_option("--device", options.device, "device file (TOML)");
  command.add_option("--design-device", options.designDevice,
                     "device file that hold and the rivals are designed on; without it, --device");
  command
      .add_option("--device-damping", options.deviceDamping,
                  "mechanical damping of the TCP along z beyond the device file's, N s/m: B for every renderer, or\n"
                  "NAME=B,... for some; the default is the paper's baseline")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--gain", options.gain,
                     "file of enamel design: the servo of hold at every query point; without it, as designed at home");
  command.add_option("--tuned", options.tuned, "file of enamel design --rivals, for tuned:NAME");
  command.add_flag("--release", options.release,
                   "the hold ends when the wall would pull, as in enamel push; without it never, as in the paper");
}

void addPushOptions(CLI::App& command, StudyOptions& options) {
  command.add_option("--scenario", options.scenarios, "1: step of force; 2: a hand moves in; both: 1,2")
      ->delimiter(',')
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  command.add_option("--runs", options.runs, "a query point")->capture_default_str();
  command.add_option("--grid", options.grid, "query points a side of the 50 mm square")->capture_default_str();
  command.add_option("--scene", options.scene,
                     "scene file (TOML), pushed where its surface is nearest to its start: --grid 1; without it the "
                     "wall z = 0");
  command.add_option("--force", options.force, "LOW,HIGH: F_c is uniform between, N")
      ->delimiter(',')
      ->expected(2)
      ->capture_default_str();
  command.add_option("--preload", options.preload, "pressed with this until the step of scenario 1, with the noise, N")
      ->capture_default_str();
  command.add_option("--tip", options.tip_mm, kTipHelp)->delimiter(',')->expected(3);
  command.add_flag("--arm", options.arm, "scenario 1 pushes through the mass of an arm and a grip (kArm, hand.hpp)");
  command.add_option("--guard", options.guard, "off: every torque passes, and loops run to their end")
      ->transform(CLI::CheckedTransformer(std::map<std::string, bool>{{"on", true}, {"off", false}}))
      ->default_str("on");
}

}  // namespace

void addStudyOptions(CLI::App& command, const std::shared_ptr<StudyOptions>& options) {
  addRendererOptions(command, *options);
  addPushOptions(command, *options);
  command.add_option("--seed", options->seed, "of everything random")->capture_default_str();
  command.add_option("--threads", options->threads, "without it, one a core; the result does not depend on it");
  command.add_option_function<std::string>(
      "--part", [options](const std::string& text) { std::tie(options->part, options->parts) = parsePart(text); },
      "I/N: performs the I-th of N parts of the runs; the process that ends last joins them. Under Open MPI "
      "(mpirun -n N enamel ...) every process takes its own");
  command.add_flag("--resume", options->resume, "continue what is in the folder");
  addOverwrite(command, options->overwrite);
}

void takeRank(const CLI::App& command, StudyOptions& options) {
  const char *size = std::getenv("OMPI_COMM_WORLD_SIZE"), *rank = std::getenv("OMPI_COMM_WORLD_RANK");
  if (size != nullptr && rank != nullptr && command.count("--part") == 0)
    std::tie(options.part, options.parts) = parsePart(fmt::format("{}/{}", 1 + std::atoi(rank), size));
  if (options.overwrite && (options.resume || options.parts > 1))
    throw Error("--overwrite starts again: it excludes --resume and --part; remove " + options.output +
                " to start parts again");
}

}  // namespace enamel::app
