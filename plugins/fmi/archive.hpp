// Zip archives, which units are: written whole, unpacked into a folder that goes away.
#pragma once

#include <string>
#include <vector>

namespace enamel::fmi {

struct ArchiveFile {
  std::string name;  ///< inside, with '/'
  std::string bytes;
};

/// Most bytes of a unit, unpacked.
inline constexpr std::size_t kLargestUnit = std::size_t{1} << 30;

/// Most files and folders of a unit.
inline constexpr std::size_t kMostEntries = 10000;

/// Writes an archive. Throws Error with the file and the cause.
void writeArchive(const std::string& path, const std::vector<ArchiveFile>& files);

/// An archive, unpacked below the folder of temporary files while this lives.
class UnpackedArchive {
 public:
  /// Unpack an archive of at most `most` bytes; \ in a name is read as /. Throws Error with the file and the cause: no
  /// archive, more bytes or kMostEntries, a name that leads out of it, a link, two names that differ in case only, a
  /// file that is not as long as it says. All names are checked before anything is unpacked.
  explicit UnpackedArchive(const std::string& path, std::size_t most = kLargestUnit);
  ~UnpackedArchive();
  UnpackedArchive(const UnpackedArchive&) = delete;
  UnpackedArchive& operator=(const UnpackedArchive&) = delete;

  const std::string& folder() const noexcept { return folder_; }

 private:
  std::string folder_;
};

}  // namespace enamel::fmi
