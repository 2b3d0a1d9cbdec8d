#include <CLI/CLI.hpp>

#include "commands.hpp"
#include "old_commands.hpp"
#include "program/program.hpp"
#include "program/system.hpp"

int main(int argc, char** argv) {
  return enamel::app::runProgram("enamel", [&] {
    CLI::App app{
        "Enamel: stiff contact on haptic devices.\nUnits are SI unless a name says otherwise. Frame W: x right, y up, "
        "z from the wall to the user."};
    app.allow_windows_style_options(false);  // a path may begin with '/', also on Windows
    app.require_subcommand(1);
    enamel::app::addEvaluate(app);
    enamel::app::addDesign(app);
    enamel::app::addIdentify(app);
    enamel::app::addFriction(app);
    enamel::app::addPush(app);
    enamel::app::addReplay(app);
    enamel::app::addExport(app);
    enamel::app::addStudy(app);
    enamel::app::addCompare(app);
    enamel::app::addDevice(app);
    enamel::app::addDevices(app);
    enamel::app::addMesh(app);
    enamel::app::addSolid(app);
    enamel::app::addScene(app);
    enamel::app::addPlugins(app);
#ifdef ENAMEL_FMI
    enamel::app::addFmu(app);
#endif
    enamel::app::addBench(app);
    std::string warning;
    std::vector<std::string> arguments = enamel::app::presentCommand(enamel::app::argumentsOf(argc, argv), warning);
    if (!warning.empty()) enamel::app::tell("enamel: warning", warning);
    std::vector<char*> words{argv[0]};
    for (std::string& argument : arguments) words.push_back(argument.data());
    enamel::app::parse(app, "enamel", static_cast<int>(words.size()), words.data());
  });
}
