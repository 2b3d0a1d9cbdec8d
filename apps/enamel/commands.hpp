// The subcommands of `enamel`, one file each. A command reports failure by an exception; see runProgram().
#pragma once

namespace CLI {
class App;
}

namespace enamel::app {

void addEvaluate(CLI::App& app);
void addDesign(CLI::App& app);
void addIdentify(CLI::App& app);
void addFriction(CLI::App& app);
void addPush(CLI::App& app);
void addReplay(CLI::App& app);
void addExport(CLI::App& app);
void addStudy(CLI::App& app);
void addCompare(CLI::App& app);
void addDevice(CLI::App& app);
void addDevices(CLI::App& app);
void addBench(CLI::App& app);
void addMesh(CLI::App& app);
void addSolid(CLI::App& app);
void addScene(CLI::App& app);
void addPlugins(CLI::App& app);
void addFmu(CLI::App& app);  // only in a build with FMI

}  // namespace enamel::app
