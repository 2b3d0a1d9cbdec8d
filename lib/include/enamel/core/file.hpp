// Reading of whole files with a size limit, and atomic writing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace enamel {

/// Default limit of the size of a text file, bytes.
inline constexpr std::size_t kLargestTextFile = std::size_t{16} << 20;

/// Return the whole content of a file. Realtime: no. Throws ConfigurationError if the file cannot be opened or read,
/// is not a regular file (a folder, a pipe, a device), or is larger than `most` bytes. Throws it also if the length
/// changes during the read.
std::string readFile(const std::string& path, std::size_t most = kLargestTextFile);

/// Reject JSON and TOML that need far more memory than their length suggests. Realtime: no.
/// Throws ConfigurationError with `file` for:
/// - more than 32 levels of nested brackets (also with the line);
/// - a dotted key of more than 32 parts (also with the line);
/// - more than 1000 values, if they are more than one for every 4 bytes.
void checkNesting(std::string_view text, const std::string& file);

/// Return the text of a JSON file after readFile() and checkNesting(). Realtime: no.
std::string readJson(const std::string& path);

/// Return the CRC-32 (IEEE 802.3) of `bytes`. `before` is the CRC-32 of the preceding bytes. Realtime: yes.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0) noexcept;

/// Writes a file atomically through a temporary file in the same folder. A reader finds the old content or all of the
/// new content. close() puts the new file in place. Without close() the temporary file is deleted; a process that is
/// killed leaves it as PATH.NUMBERS.part. Symbolic links are preserved. A path that is not a regular file (a pipe,
/// /dev/stdout) is written directly.
class FileWriter {
 public:
  /// Open the file. Throws Error with the file and the cause. Realtime: no.
  explicit FileWriter(const std::string& path);
  ~FileWriter();
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  /// Write bytes; finish the file. Throw Error with the file and the cause, such as a full disk. A regular file at
  /// `path` is then unchanged. Realtime: no.
  void write(std::string_view bytes);
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string path_, target_, beside_;  // beside_: the temporary file; empty if the file is written directly
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
};

/// Write a whole file with FileWriter. Throws Error. Realtime: no.
void writeFile(const std::string& path, std::string_view bytes);

}  // namespace enamel
