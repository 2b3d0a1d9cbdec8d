#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "core/system_file.hpp"

namespace enamel::system {
namespace {

FileStatus statusOf(const struct stat& status) {
  const FileKind kind = S_ISREG(status.st_mode)   ? FileKind::regular
                        : S_ISDIR(status.st_mode) ? FileKind::folder
                                                  : FileKind::other;
  return {kind, static_cast<std::uint64_t>(status.st_size), status.st_mode & 07777u};
}

// Repeat a call that a signal interrupted.
template <typename Call>
auto retried(const Call& call) {
  decltype(call()) result;
  do result = call();
  while (result < 0 && errno == EINTR);
  return result;
}

}  // namespace

FileStatus statusOf(const std::string& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? statusOf(status) : FileStatus{};
}

FileStatus statusOf(int file) {
  struct stat status {};
  return fstat(file, &status) == 0 ? statusOf(status) : FileStatus{};
}

bool isWritable(const std::string& path) { return access(path.c_str(), W_OK) == 0; }

int openToRead(const std::string& path) { return open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY); }

int openToAppend(const std::string& path) {
  return open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK, 0666);
}

int openNew(const std::string& path) { return open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); }

int openPipe(const std::string& path) { return open(path.c_str(), O_WRONLY | O_CLOEXEC); }

int copyOfStandardOutput() { return dup(STDOUT_FILENO); }

std::FILE* streamOf(int file, const char* mode) { return fdopen(file, mode); }

std::int64_t readSome(int file, void* bytes, std::size_t size) {
  return retried([&] { return ::read(file, bytes, size); });
}

std::int64_t readAt(int file, std::uint64_t offset, void* bytes, std::size_t size) {
  return retried([&] { return ::pread(file, bytes, size, static_cast<off_t>(offset)); });
}

std::int64_t writeSome(int file, const void* bytes, std::size_t size) { return ::write(file, bytes, size); }

bool setSize(int file, std::uint64_t size) { return ftruncate(file, static_cast<off_t>(size)) == 0; }

bool setMode(int file, unsigned mode) { return fchmod(file, mode) == 0; }

bool lock(int file) { return flock(file, LOCK_EX | LOCK_NB) == 0; }

bool close(int file) { return ::close(file) == 0; }

bool replace(const std::string& from, const std::string& to) { return std::rename(from.c_str(), to.c_str()) == 0; }

bool remove(const std::string& path) { return unlink(path.c_str()) == 0; }

}  // namespace enamel::system
