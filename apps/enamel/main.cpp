#include <CLI/CLI.hpp>

#include "commands.hpp"
#include "program/program.hpp"

int main(int argc, char** argv) {
  return enamel::app::runProgram("enamel", [&] {
    CLI::App app{
        "Enamel: stiff contact on haptic devices.\n"
        "Units are SI unless a name says otherwise; frames: W has x right, y up, z from the wall to the user."};
    app.require_subcommand(1);
    enamel::app::addEvaluate(app);
    enamel::app::addDesign(app);
    enamel::app::addPush(app);
    enamel::app::addReplay(app);
    enamel::app::addExport(app);
    enamel::app::addStudy(app);
    enamel::app::addTrials(app);
    enamel::app::addDevice(app);
    enamel::app::addMesh(app);
    enamel::app::addScene(app);
    enamel::app::addPlugins(app);
#ifdef ENAMEL_FMI
    enamel::app::addFmu(app);
#endif
    enamel::app::addBench(app);
    enamel::app::parse(app, "enamel", argc, argv);
  });
}
