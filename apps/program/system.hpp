// Functions of the operating system for programs: system_posix.cpp, system_windows.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace enamel::app {

/// Return the arguments of main() after the first one, in UTF-8.
std::vector<std::string> argumentsOf(int argc, char** argv);

/// Open closed standard streams on /dev/null, so that no other file gets their number. Make an exceeded file size limit
/// a write error. On Windows: text is UTF-8, and lines end as in files.
void prepareStreams() noexcept;

/// Return the file of this program; empty if it is unknown.
std::string programFile();

bool isTerminal(int stream) noexcept;          // 1: standard output, 2: standard error
bool canWriteInto(const std::string& folder);  // else errno says why
std::string processNumber();

/// Keeps other processes out of a folder while it exists.
class FolderLock {
 public:
  /// `waits`: wait for others to finish; otherwise their presence is an error. Throws Error.
  FolderLock(const std::string& folder, bool waits);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::intptr_t handle_;
};

}  // namespace enamel::app
