// The subcommands of `enamel`, one file each. A command reports failure by an exception; main prints it in one line.
#pragma once

#include <string>

#include "enamel/core/error.hpp"

namespace CLI {
class App;
}

namespace enamel::app {

/// A person asked a command to stop: the exit status is that of a process that the signal ended.
class Interrupted : public Error {
 public:
  Interrupted(int exitStatus, const std::string& message) : Error(message), exitStatus_(exitStatus) {}
  int exitStatus() const noexcept { return exitStatus_; }

 private:
  int exitStatus_;
};

void addEvaluate(CLI::App& app);
void addDesign(CLI::App& app);
void addPush(CLI::App& app);
void addStudy(CLI::App& app);
void addBench(CLI::App& app);
void addMesh(CLI::App& app);
void addPlugins(CLI::App& app);

}  // namespace enamel::app
