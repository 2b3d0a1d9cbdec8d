// Zip archives, the file format of units: writes them, and unpacks them into a temporary folder.
#pragma once

#include <string>
#include <vector>

namespace enamel::fmi {

struct ArchiveFile {
  std::string name;  ///< inside, with '/'
  std::string bytes;
};

/// Largest unpacked size of a unit, bytes.
inline constexpr std::size_t kLargestUnit = std::size_t{1} << 30;

/// Largest number of files and folders in a unit.
inline constexpr std::size_t kMostEntries = 10000;

/// Write an archive. Throws Error with the file and the cause.
void writeArchive(const std::string& path, const std::vector<ArchiveFile>& files);

/// An archive that is unpacked into a temporary folder; the destructor removes the folder.
class UnpackedArchive {
 public:
  /// Unpack an archive of at most `most` bytes. A backslash in a name is read as /. All names are checked before
  /// anything is unpacked. Throws Error with the file and the cause:
  /// - not an archive;
  /// - too many bytes, or more than kMostEntries;
  /// - a name that leads out of the folder, a link, or two names that differ in case only;
  /// - a file with another length than stated.
  explicit UnpackedArchive(const std::string& path, std::size_t most = kLargestUnit);
  ~UnpackedArchive();
  UnpackedArchive(const UnpackedArchive&) = delete;
  UnpackedArchive& operator=(const UnpackedArchive&) = delete;

  const std::string& folder() const noexcept { return folder_; }

 private:
  std::string folder_;
};

}  // namespace enamel::fmi
