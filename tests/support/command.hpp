// Runs the built `enamel` as a user would and returns its output.
#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "support/temporary_folder.hpp"

namespace enamel::test {

struct CommandResult {
  int status;
  std::string output;  // stdout and stderr
};

inline CommandResult runCommand(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) return {-1, "popen failed"};
  CommandResult result{0, ""};
  std::array<char, 4096> buffer;
  for (std::size_t n = 0; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    result.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

inline CommandResult run(const std::string& arguments) {
  return runCommand(std::string("'") + ENAMEL_TOOL + "' " + arguments);
}

}  // namespace enamel::test
