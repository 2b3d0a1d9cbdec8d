#include "archive.hpp"

#include <stdlib.h>  // mkdtemp is not in <cstdlib>
#include <sys/stat.h>
#include <zip.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
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
    throw Error(path + ": cannot open the archive: " + reason);
  }
  return archive;
}

// A file or folder to unpack.
struct Entry {
  zip_uint64_t index = 0;
  std::string name;  // with '/'; the name of a folder ends with it
  std::uint64_t size = 0;
};

bool staysInside(const std::string& name) {
  if (name.empty() || name.front() == '/' || (name.size() > 1 && name[1] == ':')) return false;  // a drive such as C:
  for (const auto& part : std::filesystem::path(name))
    if (part == "..") return false;
  return true;
}

Entry entryOf(zip_t* archive, zip_uint64_t index, const std::string& path) {
  zip_stat_t about;
  zip_stat_init(&about);
  const char* const given = zip_get_name(archive, index, 0);
  if (given == nullptr || zip_stat_index(archive, index, 0, &about) != 0 || (about.valid & ZIP_STAT_SIZE) == 0)
    throw Error(path + ": its entry " + std::to_string(index) + " is damaged: " + zip_strerror(archive));
  Entry entry{index, given, about.size};
  std::replace(entry.name.begin(), entry.name.end(), '\\', '/');  // some packers on Windows write backslashes
  if (!staysInside(entry.name)) throw Error(path + ": holds \"" + given + "\", a path outside of the archive");
  if (entry.name.back() == '/' && entry.size > 0) throw Error(path + ": holds \"" + given + "\", a folder with data");
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  zip_file_get_external_attributes(archive, index, 0, &system, &attributes);
  const mode_t kind = (attributes >> 16) & S_IFMT;  // 0: unknown
  if (kind != 0 && kind != S_IFREG && kind != S_IFDIR)
    throw Error(path + ": holds \"" + given + "\", which is a link or a device");
  return entry;
}

// Return all entries, after checking all of them.
std::vector<Entry> entriesOf(zip_t* archive, const std::string& path, std::size_t most) {
  const auto count = static_cast<std::size_t>(zip_get_num_entries(archive, 0));
  if (count > kMostEntries)
    throw Error(path + ": holds " + std::to_string(count) + " files, at most " + std::to_string(kMostEntries) +
                " are read");
  std::vector<Entry> entries;
  std::map<std::string, std::string> seen;  // from lower-case to given name
  std::uint64_t left = most;
  for (std::size_t i = 0; i < count; ++i) {
    Entry entry = entryOf(archive, i, path);
    if (entry.size > left) throw Error(path + ": holds more than " + std::to_string(most) + " bytes");
    left -= entry.size;
    std::string lower = std::filesystem::path(entry.name).lexically_normal().string();
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (lower.back() == '/') lower.pop_back();
    const auto [same, isNew] = seen.emplace(lower, entry.name);
    if (!isNew)
      throw Error(path + ": holds \"" + same->second + "\" and \"" + entry.name +
                  "\", which are the same file if case is ignored");
    entries.push_back(std::move(entry));
  }
  return entries;
}

void unpack(zip_t* archive, const Entry& entry, const std::string& path, const std::filesystem::path& target) {
  std::string buffer(1 << 16, '\0');
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> source(zip_fopen_index(archive, entry.index, 0), &zip_fclose);
  if (source == nullptr) throw Error(path + ": " + entry.name + " cannot be read: " + zip_strerror(archive));
  std::ofstream file(target, std::ios::binary);
  if (!file) throw Error(path + ": cannot unpack " + entry.name + ": " + std::strerror(errno));
  std::uint64_t size = 0;
  for (zip_int64_t read = 0; (read = zip_fread(source.get(), buffer.data(), buffer.size())) != 0;) {
    if (read > 0) size += static_cast<std::uint64_t>(read);
    if (read < 0 || size > entry.size) throw Error(path + ": " + entry.name + " is damaged");
    file.write(buffer.data(), read);
  }
  if (size != entry.size) throw Error(path + ": " + entry.name + " is damaged");
  if (!file.flush())
    throw Error(path + ": cannot unpack " + entry.name + " to " + target.string() + " (is the disk full?)");
}

void unpackAll(zip_t* archive, const std::string& path, const std::filesystem::path& folder, std::size_t most) {
  for (const Entry& entry : entriesOf(archive, path, most)) {
    const std::filesystem::path target = folder / entry.name;
    const bool isFolder = entry.name.back() == '/';
    std::error_code problem;
    std::filesystem::create_directories(isFolder ? target : target.parent_path(), problem);
    if (problem) throw Error(path + ": cannot unpack " + entry.name + ": " + problem.message());
    if (!isFolder) unpack(archive, entry, path, target);
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
    // The fastest level is within a few percent of the smallest size. The same unit always has the same bytes.
    zip_set_file_compression(archive.get(), static_cast<zip_uint64_t>(entry), ZIP_CM_DEFLATE, 1);
    zip_file_set_dostime(archive.get(), static_cast<zip_uint64_t>(entry), 0, 0x21, 0);
  }
  if (zip_close(archive.get()) != 0) throw Error(path + ": cannot write the archive: " + zip_strerror(archive.get()));
  (void)archive.release();
}

UnpackedArchive::UnpackedArchive(const std::string& path, std::size_t most) {
  const Archive archive = openArchive(path, ZIP_RDONLY);
  std::string pattern = (std::filesystem::temp_directory_path() / "enamel-unit-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw Error(path + ": cannot be unpacked into the folder " + pattern);
  folder_ = pattern;
  try {
    unpackAll(archive.get(), path, folder_, most);
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
