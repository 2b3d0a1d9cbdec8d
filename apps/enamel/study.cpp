#include "study/study.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <utility>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "json_matrices.hpp"
#include "program/program.hpp"

namespace enamel::app {
namespace {

void addOptions(CLI::App& command, const std::shared_ptr<StudyOptions>& options) {
  addStudyOptions(command, options);
  CLI::Option* const force = command.get_option("--force");
  force
      ->description(force->get_description() +
                    "; default: 8,15 as in the paper, and then in the folder dental 0.1,4.9 with --noise 0.1")
      ->default_str("");
  command.get_option("--device")->description("device file (TOML); default: the nominal device");
  takeOldNames(command.add_option("--plant", options->plant, kPlantHelp)
                   ->check(CLI::Validator(checkPlant, ""))
                   ->capture_default_str(),
               "plant");
  command
      .add_option("--delay", options->delay,
                  "delay of the command, ticks: none, constant:D or random:A..B; position-control knows it")
      ->capture_default_str();
  command.add_flag("--encoders", options->encoders,
                   "round the joint angles to encoder counts and compute rates by differences");
  command.add_flag("--inside-tick", options->insideTick,
                   "every step of scenario 1 occurs at a random instant inside its tick, not at its beginning");
  CLI::Option* only =
      command.add_flag("--convergence{false}", options->whole, "measure only speed against error of the integration");
  command
      .add_flag("--no-convergence{false}", options->convergence,
                "skip this measurement: a study of few runs spends most of its time on it")
      ->excludes(only);
}

// Return the options of the study in a folder.
StudyOptions optionsIn(const std::string& folder) {
  CLI::App command;
  auto options = std::make_shared<StudyOptions>();
  addOptions(command, options);
  const std::string path = folder + '/' + kCommandFile;
  try {
    auto arguments = parseJson(path).get<std::vector<std::string>>();
    std::reverse(arguments.begin(), arguments.end());  // as CLI::App::parse() expects them
    command.parse(arguments);
  } catch (const nlohmann::json::exception&) {
    throw Error(path + ": must be a list of texts");
  } catch (const CLI::ParseError& error) {
    throw Error(path + ": " + error.what());
  }
  options->output = folder;
  return *options;
}

// Perform the same study with the forces of crown preparations, and about the same relative noise (apps/STUDY.md), in
// a folder below.
void runDental(StudyOptions options) {
  fmt::print("\nwith the forces of crown preparations, 0.1 to 4.9 N\n");
  options.force = {0.1, 4.9};
  options.noise = 0.1;
  options.convergence = false;
  options.output += "/dental";
  for (const char* argument : {"--force", "0.1,4.9", "--noise", "0.1"}) options.arguments.emplace_back(argument);
  runStudy(std::move(options));
}

}  // namespace

void addStudy(CLI::App& app) {
  auto options = std::make_shared<StudyOptions>();
  auto verified = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "study",
      "Performs the paper's study: Monte Carlo over the wall z = 0 with every renderer, as tables, figures and a "
      "report.\nThe folder gets runs.csv (one line a run), points.csv, summary.json, study.json (all settings that the "
      "runs depend\non) and report.html. An interrupted study continues with --resume and ends with the same bytes.");
  addOptions(*command, options);
  CLI::Option* output = command->add_option("--output", options->output, "folder for the results");
  command
      ->add_option("--verify", *verified,
                   "folder of a finished study: repeat a sample of its runs with the same files and compare all bits")
      ->excludes(output);
  command->callback([options, verified, command] {
    if (!verified->empty()) return verifyStudy(optionsIn(*verified));
    if (options->output.empty()) throw Exit(2, "--output is required");
    takeRank(*command, *options);
    options->arguments = argumentsOf(*command);
    runStudy(*options);
    if (options->whole && command->count("--force") + command->count("--noise") == 0) runDental(*options);
  });
}

}  // namespace enamel::app
