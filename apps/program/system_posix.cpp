#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "program/system.hpp"

namespace enamel::app {

std::vector<std::string> argumentsOf(int argc, char** argv) { return {argv + 1, argv + argc}; }

void prepareStreams() noexcept {
  int number = open("/dev/null", O_RDWR);
  while (number >= 0 && number <= STDERR_FILENO) number = open("/dev/null", O_RDWR);
  if (number >= 0) close(number);
  std::signal(SIGXFSZ, SIG_IGN);
}

std::string programFile() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).string();
}

bool isTerminal(int stream) noexcept { return isatty(stream) != 0; }

bool canWriteInto(const std::string& folder) { return access(folder.c_str(), W_OK | X_OK) == 0; }

std::string processNumber() { return std::to_string(getpid()); }

FolderLock::FolderLock(const std::string& folder, bool waits)
    : handle_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  const int number = static_cast<int>(handle_);
  if (number < 0) throw Error(folder + ": cannot open the folder: " + std::strerror(errno));
  if (flock(number, waits ? LOCK_EX : LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    close(number);
    throw Error(folder + ": another study writes into the folder");
  }
}

FolderLock::~FolderLock() { close(static_cast<int>(handle_)); }

}  // namespace enamel::app
