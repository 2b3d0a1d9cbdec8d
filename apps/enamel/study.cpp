#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <tuple>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "study/options.hpp"

namespace enamel::app {
namespace {

std::pair<int, int> parsePart(const std::string& text) {
  int part = 0, parts = 0, end = 0;
  if (std::sscanf(text.c_str(), "%d/%d%n", &part, &parts, &end) != 2 || end != static_cast<int>(text.size()) ||
      part < 1 || part > parts || parts > 100000)
    throw Error("--part is \"" + text + "\", must be I/N with I in 1 to N");
  return {part, parts};
}

// What --judge takes where nothing else is said.
void prepareJudge(const CLI::App& command, StudyOptions& options) {
  const auto unless = [&command](const char* name, auto& value, auto otherwise) {
    if (command.count(name) == 0) value = otherwise;
  };
  unless("--grid", options.grid, 3);
  unless("--runs", options.runs, 10);
  unless("--preload", options.preload, 1.0);
  unless("--renderers", options.renderers,
         std::vector<std::string>{kPositionControl, kHold, "tuned:hold", "tuned:hold-delay", "tuned:virtual-coupling",
                                  "tuned:passivity", "tuned:passivity-memory", "tuned:impedance", kEdge, kImpedance});
  std::vector<std::string> damping;
  for (const char* name : {kImpedance, kEdge})
    if (std::count(options.renderers.begin(), options.renderers.end(), name) > 0)
      damping.push_back(std::string(name) + "=4");
  unless("--device-damping", options.deviceDamping, damping);
  options.encoders = options.insideTick = true;
  for (const char* name : {"--plant", "--delay"})
    if (command.count(name) > 0) throw Error(std::string(name) + " is not for --judge: " + name + "s is");
}

}  // namespace

void addStudy(CLI::App& app) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* command = app.add_subcommand(
      "study",
      "The paper's study: Monte Carlo over the wall z = 0 with every renderer, as tables, figures and a report.\n"
      "The folder gets runs.csv (a line a run), points.csv, summary.json, study.json (what the runs depend on) and\n"
      "report.html. An interrupted study goes on with --resume and ends with the same bytes.");
  command->add_option("--scenario", options->scenarios, "1: step of force; 2: a hand moves in; both: 1,2")
      ->delimiter(',')
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  command
      ->add_option(
          "--renderers", options->renderers,
          "separated by commas; passivity: impedance under a time-domain passivity controller; hold-scheduled: hold "
          "with a servo designed at every query point; tuned:LAW: a rival with the values of --laws; impedance-edge: a "
          "spring at four times the rate, as stiff as eq. 16 allows; also names and paths of plugins")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--set", options->set, "parameter of the plugins that have it, KEY=VALUE; may be given again")
      ->allow_extra_args(false);
  command->add_option("--runs", options->runs, "a query point")->capture_default_str();
  command->add_option("--grid", options->grid, "query points a side of the 50 mm square")->capture_default_str();
  command->add_option("--device", options->device, "device file (TOML); without it, the nominal device");
  command->add_option("--design-device", options->designDevice,
                      "device file that the renderers are designed on; without it, --device");
  command->add_option("--plant", options->plant, kPlantHelp)
      ->check(CLI::Validator(checkPlant, ""))
      ->capture_default_str();
  command
      ->add_option("--device-damping", options->deviceDamping,
                   "mechanical damping of the TCP along z beyond the device file's, N s/m: B for every renderer, or\n"
                   "NAME=B,... for some; the default is the paper's baseline")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str();
  command->add_option("--gain", options->gain,
                      "file of a servo for every query point: of enamel design --surface for position-control, of "
                      "enamel design for hold; without it, as found for the TAU and as designed at home");
  command->add_option("--laws", options->laws, "file of enamel design --rivals, for tuned:LAW");
  command
      ->add_option("--delay", options->delay,
                   "of the command, ticks: none, constant:D or random:A..B; position-control is told")
      ->capture_default_str();
  command->add_flag("--encoders", options->encoders, "round the joint angles to encoder counts, difference the rates");
  command->add_option("--scene", options->scene,
                      "scene file (TOML), pushed where its surface is nearest to its start: --grid 1; without it the "
                      "wall z = 0");
  command->add_option("--force", options->force, "LOW,HIGH: F_c is uniform between, N")
      ->delimiter(',')
      ->expected(2)
      ->capture_default_str();
  command
      ->add_option("--preload", options->preload, "pressed with this until the step of scenario 1, with the noise, N")
      ->capture_default_str();
  command->add_option("--tip", options->tip_mm, kTipHelp)->delimiter(',')->expected(3);
  command->add_flag("--arm", options->arm, "scenario 1 pushes through the mass of an arm and a grip (kArm, hand.hpp)");
  command->add_flag("--inside-tick", options->insideTick,
                    "every step of scenario 1 comes at a random instant inside its tick, not at its beginning");
  command->add_option("--guard", options->guard, "off: every torque passes, and loops are judged to their end")
      ->transform(CLI::CheckedTransformer(std::map<std::string, bool>{{"on", true}, {"off", false}}))
      ->default_str("on");
  command->add_flag("--release", options->release,
                    "the hold ends when the wall would pull, as in enamel push; without it never, as in the paper");
  command->add_option("--seed", options->seed, "of everything random")->capture_default_str();
  command->add_option("--threads", options->threads, "without it, one a core; the result does not depend on it");
  command->add_option_function<std::string>(
      "--part", [options](const std::string& text) { std::tie(options->part, options->parts) = parsePart(text); },
      "I/N: performs the I-th of N parts of the runs; the process that ends last joins them. Under Open MPI "
      "(mpirun -n N enamel study ...) every process takes its own");
  auto* judge = command->add_flag("--judge", options->judge,
                                  "every law and rival on every plant at every delay, with encoders, a preload of 1 N, "
                                  "steps inside the tick, on 3 x 3 "
                                  "points x 10 runs unless said otherwise: one page that ranks them");
  command
      ->add_option("--plants", options->plants,
                   "--judge: closed-form,real-stiff,real unless given; multibody takes hours")
      ->delimiter(',')
      ->check(CLI::IsMember(plantNames()))
      ->needs(judge);
  command
      ->add_option("--delays", options->delays,
                   "--judge: none,constant:1,constant:2,constant:3,random:0..3 unless given")
      ->delimiter(',')
      ->needs(judge);
  CLI::Option* only =
      command->add_flag("--convergence{false}", options->whole, "measure speed against error of the integration only");
  command
      ->add_flag("--no-convergence{false}", options->convergence,
                 "all but that: a study of few runs spends most of its time on it")
      ->excludes(only);
  command->add_flag("--resume", options->resume, "continue the study in the folder");
  command->add_option("--output", options->output, "folder for the results")->required();
  command->callback([options, command] {
    if (options->judge) prepareJudge(*command, *options);
    const char *size = std::getenv("OMPI_COMM_WORLD_SIZE"), *rank = std::getenv("OMPI_COMM_WORLD_RANK");
    if (size != nullptr && rank != nullptr && command->count("--part") == 0)
      std::tie(options->part, options->parts) = parsePart(fmt::format("{}/{}", 1 + std::atoi(rank), size));
    runStudy(*options);
  });
}

}  // namespace enamel::app
