// What the mains of all programs share.
#pragma once

#include <functional>
#include <string>

#include "enamel/core/error.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace enamel::app {

/// Ends a program with a status of its own; without a message, silently.
class Exit : public Error {
 public:
  Exit(int status, const std::string& message) : Error(message), status_(status) {}
  int status() const noexcept { return status_; }

 private:
  int status_;
};

/// Runs the body of a main and returns the status of the process: 0, that of an Exit, or 1 for any other exception and
/// for a standard output that could not be written; each is told in one line "NAME: reason". Streams that were closed
/// lead nowhere, so that no file that is opened takes their place; a limit of file sizes is an error of writing.
int runProgram(const std::string& name, const std::function<void()>& body) noexcept;

/// Tells an error as runProgram() does.
void tell(const std::string& name, const std::string& reason) noexcept;

/// Version, compiler, options and libraries of this build, in one line: what --version says behind the name.
const char* buildText() noexcept;

/// Makes an option take the names of the version before (core/old_names.hpp) for what it names, `kind`: the present
/// name replaces them before anything checks it, and a warning on standard error says so.
void takeOldNames(CLI::Option* option, const std::string& kind);

/// Parses a command line and runs its callbacks. Numbers are finite and decimal. Throws Exit with 2 where it cannot be
/// read; false where help or the version was asked for.
bool parse(CLI::App& app, const std::string& name, int argc, char** argv);

}  // namespace enamel::app
