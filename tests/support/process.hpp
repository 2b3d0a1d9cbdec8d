// A program that runs concurrently with a test.
#pragma once

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <optional>
#include <string>

#include "support/catch.hpp"
#include "support/eventually.hpp"

namespace enamel::test {

/// A shell command that runs concurrently with the test, and ends with it at the latest.
class Process {
 public:
  explicit Process(const std::string& command) : pid_(fork()) {
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  ~Process() {
    if (isRunning()) kill(pid_, SIGKILL), waitpid(pid_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  bool isRunning() {
    int status = 0;
    if (!status_ && waitpid(pid_, &status, WNOHANG) == pid_)
      status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 256 + WTERMSIG(status);
    return !status_;
  }
  /// Return the exit status; 256 + the signal's number if a signal killed it.
  int wait() {
    REQUIRE(eventually([this] { return !isRunning(); }));
    return *status_;
  }
  void signal(int number) const { kill(pid_, number); }
  /// Return whether it has a handler for a signal.
  bool handles(int number) const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/status");
    for (std::string word; file >> word;)
      if (word == "SigCgt:" && file >> word) return (std::stoull(word, nullptr, 16) >> (number - 1) & 1) != 0;
    return false;
  }

 private:
  pid_t pid_;
  std::optional<int> status_;
};

}  // namespace enamel::test
