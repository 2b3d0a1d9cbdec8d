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

/// Writes an archive. Throws Error with the file and the cause.
void writeArchive(const std::string& path, const std::vector<ArchiveFile>& files);

/// An archive, unpacked below the folder of temporary files while this lives.
class UnpackedArchive {
 public:
  /// Throws Error with the file and the cause: no archive, more than kLargestUnit, a name that leads out of it.
  explicit UnpackedArchive(const std::string& path);
  ~UnpackedArchive();
  UnpackedArchive(const UnpackedArchive&) = delete;
  UnpackedArchive& operator=(const UnpackedArchive&) = delete;

  const std::string& folder() const noexcept { return folder_; }

 private:
  std::string folder_;
};

}  // namespace enamel::fmi
