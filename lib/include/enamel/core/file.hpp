// Whole files: read with a limit, written whole or not at all.
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace enamel {

/// Most bytes of a file that is read as text, unless its reader knows better.
inline constexpr std::size_t kLargestTextFile = std::size_t{16} << 20;

/// Whole content of a file. Throws ConfigurationError: it cannot be opened or read; it is no plain file (a folder, a
/// pipe, a device) or larger than `most` bytes. Realtime: no.
std::string readFile(const std::string& path, std::size_t most = kLargestTextFile);

/// Refuses JSON and TOML that would cost their readers more than their length tells: brackets nested, or a dotted key of
/// parts, beyond 32; beyond 1000 values, more than one for every 4 bytes. Throws ConfigurationError with `file` and
/// the line. Realtime: no.
void checkNesting(std::string_view text, const std::string& file);

/// Text of a JSON file: readFile() and checkNesting(). Realtime: no.
std::string readJson(const std::string& path);

/// A file in the making. Until close() it stands under another name beside `path`, and without close() it goes away (a process that is killed
/// leaves it as PATH.NUMBERS.part):
/// whoever looks finds what was there before or all of the new. A link stays one. What is no plain file (a pipe,
/// /dev/stdout) is written as it comes.
class FileWriter {
 public:
  /// Throws Error with the file and the cause. Realtime: no.
  explicit FileWriter(const std::string& path);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// Throw Error with the file and the cause (is the disk full?): `path` is then as it was. Realtime: no.
  void write(std::string_view bytes);
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string path_, target_, beside_;  // beside_: empty where the file is written as it comes
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

/// Writes a whole file, as FileWriter does. Throws Error. Realtime: no.
void writeFile(const std::string& path, std::string_view bytes);

}  // namespace enamel
