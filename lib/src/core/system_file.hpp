// Files by descriptor, with paths in UTF-8: system_file_posix.cpp, system_file_windows.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace enamel::system {

enum class FileKind { missing, regular, folder, other };  // other: a pipe or a device

struct FileStatus {
  FileKind kind = FileKind::missing;  // also if it is unknown: errno is ENOENT only if the file is missing
  std::uint64_t size = 0;             // bytes
  unsigned mode = 0;                  // permissions
};

FileStatus statusOf(const std::string& path);
FileStatus statusOf(int file);
bool isWritable(const std::string& path);

// These functions return -1 or false on failure, and errno says why. Programs that are started do not inherit the
// descriptors.

int openToRead(const std::string& path);    // does not wait for the writer of a pipe
int openToAppend(const std::string& path);  // makes the file; does not wait for the reader of a pipe
int openNew(const std::string& path);       // fails if the file exists
int openPipe(const std::string& path);      // an existing pipe or device, for writing
int copyOfStandardOutput();
std::FILE* streamOf(int file, const char* mode);  // owns the descriptor

std::int64_t readSome(int file, void* bytes, std::size_t size);
std::int64_t readAt(int file, std::uint64_t offset, void* bytes, std::size_t size);
std::int64_t writeSome(int file, const void* bytes, std::size_t size);
bool setSize(int file, std::uint64_t size);
bool setMode(int file, unsigned mode);
bool lock(int file);  // for this descriptor only, until it is closed; does not wait
bool close(int file);

bool replace(const std::string& from, const std::string& to);  // atomically; `to` may exist
bool remove(const std::string& path);

}  // namespace enamel::system
