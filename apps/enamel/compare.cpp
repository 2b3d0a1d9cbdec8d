#include "compare/compare.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "commands.hpp"
#include "enamel/study/wall_trials.hpp"
#include "program/program.hpp"

namespace enamel::app {
namespace {

using Names = std::vector<std::string>;

// The paper's baselines have 4 N s/m of device damping.
Names baselineDamping(const Names& renderers) {
  Names damping;
  for (const char* name : {kImpedance, kEdge})
    if (std::count(renderers.begin(), renderers.end(), name) > 0) damping.push_back(std::string(name) + "=4");
  return damping;
}

// Set the default comparison: with a folder everything, without one a table that takes seconds.
void setDefaults(const CLI::App& command, CompareOptions& options) {
  StudyOptions& study = options.study;
  const bool folder = !study.output.empty();
  const auto unless = [&command](const char* name, auto& value, const auto& otherwise) {
    if (command.count(name) == 0) value = otherwise;
  };
  unless("--plants", options.plants, folder ? Names{kClosedForm, kImperfectStiff, kImperfect} : Names{kClosedForm});
  unless("--delays", options.delays,
         folder ? Names{"none", "constant:1", "constant:2", "constant:3", "random:0..3"} : Names{"none"});
  unless("--tasks", options.tasks,
         folder ? Names{kPush, "impact", "tap", "release", "slide", "corner"} : wallTrialNames());
  unless("--renderers", study.renderers,
         folder ? Names{kPositionControl, kHold, "tuned:hold", "tuned:hold-delay", "tuned:virtual-coupling",
                        "tuned:passivity", "tuned:passivity-memory", "tuned:impedance", kEdge, kImpedance}
                : Names{kPositionControl, kHold, kImpedance});
  unless("--runs", study.runs, std::count(options.tasks.begin(), options.tasks.end(), kPush) > 0 ? 10 : 20);
  unless("--device-damping", study.deviceDamping, baselineDamping(study.renderers));
}

}  // namespace

void addCompare(CLI::App& app) {
  auto options = std::make_shared<CompareOptions>();
  StudyOptions& study = options->study;
  study.grid = 3;
  study.preload = 1.0;
  study.encoders = study.insideTick = true;
  CLI::App* command = app.add_subcommand(
      "compare",
      "Compares renderers on plants, delays and tasks, with encoders and steps inside the tick. Without --output, it "
      "prints\na table of every task except push, one column a renderer. With --output, it also performs the task push "
      "and\nuses more renderers, plants and delays. compare.html ranks them, compare.csv and tasks.csv have the "
      "numbers, and\none folder for each plant and delay has the runs.");
  addStudyOptions(*command, std::shared_ptr<StudyOptions>(options, &study));
  command->get_option("--device")->required();
  for (const auto& [name, text] : {std::pair{"--renderers", "position-control,hold,impedance; with --output ten"},
                                   {"--runs", "20; 10 with the task push"},
                                   {"--device-damping", "impedance=4,impedance-edge=4"}})
    command->get_option(name)->default_str(text);
  takeOldNames(command->add_option("--plants", options->plants, "plants; multibody takes hours")
                   ->delimiter(',')
                   ->check(CLI::IsMember(plantNames()))
                   ->default_str("closed-form; with --output closed-form,imperfect-stiff,imperfect"),
               "plant");
  command->add_option("--delays", options->delays, "delays of the command, ticks: none, constant:D or random:A..B")
      ->delimiter(',')
      ->default_str("none; with --output none,constant:1,constant:2,constant:3,random:0..3");
  command
      ->add_option("--tasks", options->tasks,
                   "push (the scenarios of enamel study, needs --output), or parts of the names step, ramp, impact, "
                   "tap, release, slide, corner, pulse, overload")
      ->delimiter(',')
      ->default_str("all but push; with --output push,impact,tap,release,slide,corner");
  command->add_option("--stiffness", study.impedance.stiffness, "stiffness of impedance and passivity, N/m")
      ->capture_default_str();
  command->add_option("--damping", study.impedance.damping, "damping of impedance and passivity, N s/m")
      ->capture_default_str();
  command->add_option("--inertia", study.inertia, "inertia of the renderers' model divided by the plant's")
      ->capture_default_str();
  command->add_option("--output", study.output, "folder for the results");
  command->callback([options, command] {
    setDefaults(*command, *options);
    takeRank(*command, options->study);
    options->study.arguments = argumentsOf(*command);
    runCompare(*options);
  });
}

}  // namespace enamel::app
