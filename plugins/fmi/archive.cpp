#include "archive.hpp"

#include <stdlib.h>  // mkdtemp is not in <cstdlib>
#include <zip.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "enamel/core/error.hpp"

namespace enamel::fmi {
namespace {

using Archive = std::unique_ptr<zip_t, void (*)(zip_t*)>;

Archive openArchive(const std::string& path, int flags) {
  int code = 0;
  Archive archive(zip_open(path.c_str(), flags, &code), [](zip_t* a) { zip_discard(a); });
  if (archive == nullptr) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    throw Error(path + ": is no archive that can be opened: " + reason);
  }
  return archive;
}

bool staysInside(const std::filesystem::path& name) {
  if (name.empty() || name.is_absolute()) return false;
  for (const auto& part : name)
    if (part == "..") return false;
  return true;
}

void unpack(zip_t* archive, const std::string& path, const std::filesystem::path& folder) {
  std::size_t left = kLargestUnit;
  std::string buffer(1 << 16, '\0');
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    const char* const given = zip_get_name(archive, static_cast<zip_uint64_t>(i), 0);
    const std::string name = given != nullptr ? given : "";
    if (!staysInside(name)) throw Error(path + ": holds \"" + name + "\", which leads out of it");
    const std::filesystem::path target = folder / name;
    if (name.back() == '/') {
      std::filesystem::create_directories(target);
      continue;
    }
    std::filesystem::create_directories(target.parent_path());
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> entry(
        zip_fopen_index(archive, static_cast<zip_uint64_t>(i), 0), &zip_fclose);
    std::ofstream file(target, std::ios::binary);
    zip_int64_t read = entry != nullptr ? 0 : -1;
    while (entry != nullptr && (read = zip_fread(entry.get(), buffer.data(), buffer.size())) > 0) {
      if (static_cast<std::size_t>(read) > left) throw Error(path + ": holds more than 1 GiB");
      left -= static_cast<std::size_t>(read);
      file.write(buffer.data(), read);
    }
    if (read < 0) throw Error(path + ": " + name + " is damaged");
    if (!file.flush())
      throw Error(path + ": cannot unpack " + name + " to " + target.string() + " (is the disk full?)");
  }
}

}  // namespace

void writeArchive(const std::string& path, const std::vector<ArchiveFile>& files) {
  Archive archive = openArchive(path, ZIP_CREATE | ZIP_TRUNCATE);
  for (const ArchiveFile& file : files) {
    zip_source_t* const source = zip_source_buffer(archive.get(), file.bytes.data(), file.bytes.size(), 0);
    const zip_int64_t entry =
        source != nullptr ? zip_file_add(archive.get(), file.name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (entry < 0) {
      zip_source_free(source);
      throw Error(path + ": cannot add " + file.name + ": " + zip_strerror(archive.get()));
    }
    // As small as the quickest level makes it, within a few percent; the same unit has the same bytes.
    zip_set_file_compression(archive.get(), static_cast<zip_uint64_t>(entry), ZIP_CM_DEFLATE, 1);
    zip_file_set_dostime(archive.get(), static_cast<zip_uint64_t>(entry), 0, 0x21, 0);
  }
  if (zip_close(archive.get()) != 0) throw Error(path + ": cannot be written: " + zip_strerror(archive.get()));
  (void)archive.release();
}

UnpackedArchive::UnpackedArchive(const std::string& path) {
  const Archive archive = openArchive(path, ZIP_RDONLY);
  std::string pattern = (std::filesystem::temp_directory_path() / "enamel-unit-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw Error(path + ": cannot be unpacked to " + pattern);
  folder_ = pattern;
  try {
    unpack(archive.get(), path, folder_);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
    throw;
  }
}

UnpackedArchive::~UnpackedArchive() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace enamel::fmi
