#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#include <windows.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <filesystem>

#include "core/system_file.hpp"

namespace enamel::system {
namespace {

std::wstring wide(const std::string& path) { return std::filesystem::u8path(path).wstring(); }

// Set errno from the last error of Windows.
void keepError() {
  switch (GetLastError()) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_INVALID_NAME: errno = ENOENT; break;
    case ERROR_ACCESS_DENIED:
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION: errno = EACCES; break;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS: errno = EEXIST; break;
    case ERROR_DISK_FULL: errno = ENOSPC; break;
    case ERROR_BROKEN_PIPE:
    case ERROR_NO_DATA: errno = EPIPE; break;
    default: errno = EIO;
  }
}

HANDLE handleOf(int file) { return reinterpret_cast<HANDLE>(_get_osfhandle(file)); }

// With FILE_SHARE_DELETE a file that somebody reads can be replaced, as on other systems.
int openAs(const std::string& path, DWORD access, DWORD disposition, int flags) {
  const HANDLE handle = CreateFileW(wide(path).c_str(), access, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE,
                                    nullptr, disposition, FILE_ATTRIBUTE_NORMAL, nullptr);
  if (handle == INVALID_HANDLE_VALUE) {
    keepError();
    const int error = errno;
    errno = statusOf(path).kind == FileKind::folder ? EISDIR : error;
    return -1;
  }
  const int file = _open_osfhandle(reinterpret_cast<std::intptr_t>(handle), flags | _O_BINARY | _O_NOINHERIT);
  if (file < 0) CloseHandle(handle);
  return file;
}

FileStatus statusOf(const struct _stat64& status) {
  const int kind = status.st_mode & _S_IFMT;
  return {kind == _S_IFREG   ? FileKind::regular
          : kind == _S_IFDIR ? FileKind::folder
                             : FileKind::other,
          static_cast<std::uint64_t>(status.st_size), status.st_mode & 0777u};
}

// A place that no file has: the lock does not hinder those who read.
OVERLAPPED place(std::uint64_t offset) {
  OVERLAPPED at{};
  at.Offset = static_cast<DWORD>(offset);
  at.OffsetHigh = static_cast<DWORD>(offset >> 32);
  return at;
}

}  // namespace

FileStatus statusOf(const std::string& path) {
  struct _stat64 status {};
  std::filesystem::path place = std::filesystem::u8path(path);
  if (!place.has_filename() && place.has_relative_path()) place = place.parent_path();  // "folder/"
  return _wstat64(place.c_str(), &status) == 0 ? statusOf(status) : FileStatus{};
}

FileStatus statusOf(int file) {
  struct _stat64 status {};
  return _fstat64(file, &status) == 0 ? statusOf(status) : FileStatus{};
}

bool isWritable(const std::string& path) { return _waccess(wide(path).c_str(), 2) == 0; }

int openToRead(const std::string& path) { return openAs(path, GENERIC_READ, OPEN_EXISTING, _O_RDONLY); }

int openToAppend(const std::string& path) {
  // GENERIC_WRITE too: setSize() needs it.
  return openAs(path, GENERIC_WRITE | FILE_APPEND_DATA, OPEN_ALWAYS, _O_WRONLY | _O_APPEND);
}

int openNew(const std::string& path) { return openAs(path, GENERIC_WRITE, CREATE_NEW, _O_WRONLY); }

int openPipe(const std::string& path) { return openAs(path, GENERIC_WRITE, OPEN_EXISTING, _O_WRONLY); }

int copyOfStandardOutput() {
  const int file = _dup(_fileno(stdout));
  if (file >= 0) _setmode(file, _O_BINARY);
  return file;
}

std::FILE* streamOf(int file, const char* mode) { return file >= 0 ? _fdopen(file, mode) : nullptr; }

std::int64_t readSome(int file, void* bytes, std::size_t size) {
  return _read(file, bytes, static_cast<unsigned>(std::min<std::size_t>(size, INT_MAX)));
}

std::int64_t readAt(int file, std::uint64_t offset, void* bytes, std::size_t size) {
  OVERLAPPED at = place(offset);
  DWORD done = 0;
  if (ReadFile(handleOf(file), bytes, static_cast<DWORD>(std::min<std::size_t>(size, INT_MAX)), &done, &at))
    return done;
  if (GetLastError() == ERROR_HANDLE_EOF) return 0;
  keepError();
  return -1;
}

std::int64_t writeSome(int file, const void* bytes, std::size_t size) {
  return _write(file, bytes, static_cast<unsigned>(std::min<std::size_t>(size, INT_MAX)));
}

bool setSize(int file, std::uint64_t size) {
  const errno_t error = _chsize_s(file, static_cast<std::int64_t>(size));
  if (error != 0) errno = error;
  return error == 0;
}

bool setMode(int, unsigned) { return true; }  // the folder decides about access

bool lock(int file) {
  OVERLAPPED at = place(std::uint64_t{1} << 62);
  if (LockFileEx(handleOf(file), LOCKFILE_EXCLUSIVE_LOCK | LOCKFILE_FAIL_IMMEDIATELY, 0, 1, 0, &at)) return true;
  keepError();
  return false;
}

// The C library ends the process for an invalid descriptor.
bool close(int file) { return file >= 0 && _close(file) == 0; }

bool replace(const std::string& from, const std::string& to) {
  constexpr int kTries = 100;
  constexpr DWORD kPause = 10;  // ms: somebody, often a virus scanner, holds a new file for a moment
  const std::wstring source = wide(from), target = wide(to);
  for (int i = 0; i < kTries; ++i) {
    if (MoveFileExW(source.c_str(), target.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH)) return true;
    if (GetLastError() != ERROR_ACCESS_DENIED && GetLastError() != ERROR_SHARING_VIOLATION) break;
    Sleep(kPause);
  }
  keepError();
  return false;
}

bool remove(const std::string& path) { return _wunlink(wide(path).c_str()) == 0; }

}  // namespace enamel::system
