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
      .add_option("--renderers", options.renderers,
                  "renderers, separated by commas: those of enamel push; hold-scheduled: hold with a servo designed at "
                  "every query point; tuned:NAME: a rival with the values of --tuned; best-spring: the spring with the "
                  "largest K_d that loses no run, by a search with other random numbers (minutes); impedance-edge: a "
                  "spring at four "
                  "times the rate, as stiff as eq. 16 allows; FILE.json: hold with this servo file")
      ->delimiter(',')
      ->capture_default_str();
  command.add_option("--set", options.set, "parameter of all plugins that have it, KEY=VALUE; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--device", options.device, "device file (TOML)");
  command.add_option("--design-device", options.designDevice,
                     "device file for which hold and the rivals are designed; default: --device");
  command
      .add_option("--device-damping", options.deviceDamping,
                  "mechanical damping of the TCP along z, N s/m, added to that of the device file: B for every "
                  "renderer, or\nNAME=B,... for some; the default is the paper's baseline")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--gain", options.gain,
                     "file of enamel design with the servo of hold at every query point; default: designed at home");
  command.add_option("--tuned", options.tuned, "file of enamel design --rivals, for tuned:NAME");
  command.add_flag("--release", options.release,
                   "hold ends when the wall would pull, as in enamel push; default: it never ends, as in the paper");
}

void addPushOptions(CLI::App& command, StudyOptions& options) {
  command.add_option("--scenario", options.scenarios, "1: a step of force; 2: a hand moves into the wall; 1,2: both")
      ->delimiter(',')
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  command.add_option("--runs", options.runs, "runs at each query point")->capture_default_str();
  command.add_option("--grid", options.grid, "query points on each side of the square of 50 mm")->capture_default_str();
  command.add_option("--scene", options.scene,
                     "scene file (TOML), needs --grid 1; the push is where its surface is nearest to its start; "
                     "default: the wall z = 0");
  command.add_option("--force", options.force, "LOW,HIGH: range of F_c, which is distributed uniformly, N")
      ->delimiter(',')
      ->expected(2)
      ->capture_default_str();
  command.add_option("--noise", options.noise, "standard deviation of the person's force, N")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--preload", options.preload, "force before the step of scenario 1, with noise, N")
      ->capture_default_str();
  command.add_option("--tip", options.tip_mm, kTipHelp)->delimiter(',')->expected(3);
  command.add_flag("--arm", options.arm,
                   "push scenario 1 through the mass of an arm and a grip (kArm, lib/include/enamel/sim/hand.hpp)");
  command.add_flag("--finger-rest", options.rest,
                   "a finger 15 mm behind the tip rests on a tooth (kFingerRest, lib/include/enamel/sim/hand.hpp)");
  command.add_option("--guard", options.guard, "guard; off: every torque passes, and loops run to their end")
      ->transform(CLI::CheckedTransformer(std::map<std::string, bool>{{"on", true}, {"off", false}}))
      ->default_str("on");
}

}  // namespace

void addStudyOptions(CLI::App& command, const std::shared_ptr<StudyOptions>& options) {
  addRendererOptions(command, *options);
  addPushOptions(command, *options);
  command.add_option("--seed", options->seed, "seed of all random numbers")->capture_default_str();
  command.add_option("--threads", options->threads,
                     "number of threads; default: one a core; the result does not depend on it");
  command.add_option_function<std::string>(
      "--part", [options](const std::string& text) { std::tie(options->part, options->parts) = parsePart(text); },
      "I/N: perform part I of N of the runs; the process that finishes last joins them. Under Open MPI (mpirun -n N "
      "enamel ...) every process chooses its own part");
  command.add_flag("--resume", options->resume, "continue the study in the folder");
  addOverwrite(command, options->overwrite);
}

void takeRank(const CLI::App& command, StudyOptions& options) {
  const char *size = std::getenv("OMPI_COMM_WORLD_SIZE"), *rank = std::getenv("OMPI_COMM_WORLD_RANK");
  if (size != nullptr && rank != nullptr && command.count("--part") == 0)
    std::tie(options.part, options.parts) = parsePart(fmt::format("{}/{}", 1 + std::atoi(rank), size));
  if (options.overwrite && (options.resume || options.parts > 1))
    throw Error("--overwrite starts again and excludes --resume and --part; remove the folder " + options.output +
                " to start parts again");
}

std::vector<std::string> argumentsOf(const CLI::App& command) {
  std::vector<std::string> arguments;
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string name = "--" + option->get_lnames().front();
    if (name == "--output" || name == "--threads" || name == "--part" || name == "--resume" || name == "--overwrite")
      continue;
    const bool isFlag = option->get_items_expected_max() == 0, isList = option->get_delimiter() != '\0';
    for (const std::string& value : isFlag ? std::vector<std::string>{""} : option->results())
      if (isList && value != option->results().front()) {
        arguments.back() += option->get_delimiter() + value;
      } else {
        arguments.push_back(name);
        if (!isFlag) arguments.push_back(value);
      }
  }
  return arguments;
}

std::string shellText(const std::string& command, const std::vector<std::string>& arguments) {
  std::string text = "enamel " + command;
  for (const std::string& argument : arguments) {
    const bool isPlain = argument.find_first_not_of(
                             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                             "-_=:,./+") == std::string::npos;
    std::string quoted;
    for (const char c : argument) quoted += c == '\'' ? "'\\''" : std::string(1, c);
    text += ' ' + (isPlain && !argument.empty() ? argument : "'" + quoted + "'");
  }
  return text;
}

}  // namespace enamel::app
