#include <CLI/CLI.hpp>

#include "commands.hpp"
#include "program/program.hpp"
#include "study/options.hpp"

namespace enamel::app {

void addStudy(CLI::App& app) {
  auto options = std::make_shared<StudyOptions>();
  CLI::App* command = app.add_subcommand(
      "study",
      "Performs the paper's study: Monte Carlo over the wall z = 0 with every renderer, as tables, figures and a "
      "report.\nThe folder gets runs.csv (one line a run), points.csv, summary.json, study.json (all settings that the "
      "runs depend\non) and report.html. An interrupted study continues with --resume and ends with the same bytes.");
  addStudyOptions(*command, options);
  command->get_option("--device")->description("device file (TOML); default: the nominal device");
  takeOldNames(command->add_option("--plant", options->plant, kPlantHelp)
                   ->check(CLI::Validator(checkPlant, ""))
                   ->capture_default_str(),
               "plant");
  command
      ->add_option("--delay", options->delay,
                   "delay of the command, ticks: none, constant:D or random:A..B; position-control knows it")
      ->capture_default_str();
  command->add_flag("--encoders", options->encoders,
                    "round the joint angles to encoder counts and compute rates by differences");
  command->add_flag("--inside-tick", options->insideTick,
                    "every step of scenario 1 occurs at a random instant inside its tick, not at its beginning");
  CLI::Option* only =
      command->add_flag("--convergence{false}", options->whole, "measure only speed against error of the integration");
  command
      ->add_flag("--no-convergence{false}", options->convergence,
                 "skip this measurement: a study of few runs spends most of its time on it")
      ->excludes(only);
  command->add_option("--output", options->output, "folder for the results")->required();
  command->callback([options, command] {
    takeRank(*command, *options);
    runStudy(*options);
  });
}

}  // namespace enamel::app
