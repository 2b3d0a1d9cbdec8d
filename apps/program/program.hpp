// Shared by the main functions of all programs.
#pragma once

#include <functional>
#include <string>

#include "enamel/core/error.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace enamel::app {

/// Ends a program with a given status; silently if the message is empty.
class Exit : public Error {
 public:
  Exit(int status, const std::string& message) : Error(message), status_(status) {}
  int status() const noexcept { return status_; }

 private:
  int status_;
};

/// Run the body of a main function and return the status of the process: 0, the status of an Exit, or 1. Status 1 means
/// another exception, or that the standard output could not be written. Each error is printed as one line "NAME:
/// reason". Closed standard streams are opened on /dev/null, so that no other file gets their number. Exceeding a file
/// size limit is a write error.
int runProgram(const std::string& name, const std::function<void()>& body) noexcept;

/// Print an error as runProgram() does.
void tell(const std::string& name, const std::string& reason) noexcept;

/// Return version, compiler, options and libraries of this build in one line: the text of --version after the name.
const char* buildText() noexcept;

/// Let an option accept the names of the previous version (core/old_names.hpp) for its `kind`. The present name
/// replaces an old one before any check, with a warning on stderr.
void takeOldNames(CLI::Option* option, const std::string& kind);

/// Parse a command line and run its callbacks. Numbers must be finite and decimal. Return false after --help or
/// --version. Throws Exit with status 2: an invalid command line.
bool parse(CLI::App& app, const std::string& name, int argc, char** argv);

}  // namespace enamel::app
