#include "enamel/core/file.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/system_file.hpp"
#include "core/system_process.hpp"
#include "enamel/core/error.hpp"

namespace enamel {

namespace fs = std::filesystem;
using system::FileKind;

std::string readFile(const std::string& path, std::size_t most) {
  const auto refuse = [&path](const std::string& problem) { throw ConfigurationError(path, 0, "", problem); };
  struct Descriptor {
    const int number;
    ~Descriptor() { system::close(number); }
  };
  const Descriptor file{system::openToRead(path)};
  if (file.number < 0)
    refuse(errno == EISDIR ? "is a folder, not a file" : std::string("cannot open the file: ") + std::strerror(errno));
  const system::FileStatus status = system::statusOf(file.number);
  if (status.kind == FileKind::folder) refuse("is a folder, not a file");
  if (status.kind != FileKind::regular) refuse("is a pipe or a device, must be a regular file");
  if (status.size > most)
    refuse("is " + std::to_string(status.size) + " bytes, at most " + std::to_string(most) + " are read");
  std::string text(static_cast<std::size_t>(status.size), '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const std::int64_t got = system::readSome(file.number, text.data() + size, text.size() - size);
    if (got < 0) refuse(std::string("cannot read the file: ") + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  char more;  // files of /proc report a size of 0
  if (size != text.size() || (size == 0 && system::readSome(file.number, &more, 1) > 0))
    refuse("changed its size while it was read: is another program writing it?");
  return text;
}

void checkNesting(std::string_view text, const std::string& file) {
  constexpr int kDeepest = 32;
  constexpr std::size_t kManyValues = 1000, kLeastBytes = 4;  // bytes of a value, which takes 16 to 64 in memory
  std::size_t values = 0;
  int depth = 0, dots = 0, line = 1;
  const auto refuse = [&](const std::string& problem) {
    throw ConfigurationError(file, line, "", problem + std::to_string(kDeepest));
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '#') i = std::min(text.find('\n', i), text.size()) - 1;
    if (c == '"' || c == '\'') {  // skip a string: three quotes end one that three began; a line end ends others
      const std::string_view three = text.substr(i, 3);
      const bool isLong = three.size() == 3 && three[1] == c && three[2] == c;
      for (i += isLong ? 3 : 1; i < text.size(); ++i) {
        if (text[i] == '\n') ++line;
        if (text[i] == '\n' && !isLong) break;
        if (text[i] == '\\' && c == '"')
          ++i;
        else if (text[i] == c && (!isLong || text.substr(i, 3) == three))
          break;
      }
      if (isLong) i += 2;
      continue;
    }
    if (c == '\n') ++line;
    if (c == ',' || c == '[' || c == '{') ++values;
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    dots = c == '.' ? dots + 1 : c == '\n' || c == ',' || c == '=' || c == '[' || c == '{' ? 0 : dots;
    if (depth > kDeepest) refuse("has brackets nested deeper than ");
    if (dots >= kDeepest) refuse("has a dotted key with more parts than ");
  }
  if (values > kManyValues && values > text.size() / kLeastBytes)
    throw ConfigurationError(file, 0, "",
                             "has " + std::to_string(values) + " values in " + std::to_string(text.size()) +
                                 " bytes, at most one for every " + std::to_string(kLeastBytes) + " are read");
}

std::string readJson(const std::string& path) {
  std::string text = readFile(path);
  checkNesting(text, path);
  return text;
}

FileWriter::FileWriter(const std::string& path) : path_(path), target_(path), file_(nullptr, &std::fclose) {
  const system::FileStatus there = system::statusOf(path);
  const bool exists = there.kind != FileKind::missing;
  if (path == "/dev/stdout") {  // continue at the present position of the standard output
    std::fflush(stdout);
    file_.reset(system::streamOf(system::copyOfStandardOutput(), "wb"));
  } else if (exists && there.kind != FileKind::regular) {
    if (const int number = system::openPipe(path); number >= 0) file_.reset(system::streamOf(number, "wb"));
  } else {
    if (!exists && errno != ENOENT) fail();
    static std::atomic<unsigned> count{0};
    std::error_code ignored;
    if (exists && !system::isWritable(path)) fail();
    if (const fs::path real = fs::canonical(fs::u8path(path), ignored); !real.empty()) target_ = real.u8string();
    while (!exists && fs::is_symlink(fs::u8path(target_), ignored)) {  // to a file that does not exist yet
      const fs::path link = fs::u8path(target_);
      target_ = (link.parent_path() / fs::read_symlink(link, ignored)).u8string();
    }
    int number = -1;
    do {  // a killed process may have had the same number, typically in a container
      beside_ = target_ + "." + std::to_string(system::processId()) + "-" + std::to_string(count++) + ".part";
      number = system::openNew(beside_);
    } while (number < 0 && errno == EEXIST);
    if (number < 0) {
      beside_.clear();
      fail();
    }
    if (exists) (void)system::setMode(number, there.mode);
    file_.reset(system::streamOf(number, "wb"));
  }
  if (file_) return;
  if (!beside_.empty()) system::remove(beside_);
  fail();
}

FileWriter::~FileWriter() {
  if (!beside_.empty()) system::remove(beside_);
}

void FileWriter::fail() const { throw Error(path_ + ": cannot write the file: " + std::strerror(errno)); }

void FileWriter::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
}

void FileWriter::close() {
  if (std::fflush(file_.get()) != 0 || std::fclose(file_.release()) != 0) fail();
  if (beside_.empty()) return;
  if (!system::replace(beside_, target_)) fail();
  beside_.clear();
}

std::uint32_t crc32(std::string_view bytes, std::uint32_t before) noexcept {
  static const auto table = [] {
    std::array<std::uint32_t, 256> t{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      t[i] = i;
      for (int bit = 0; bit < 8; ++bit) t[i] = (t[i] >> 1) ^ ((t[i] & 1) != 0 ? 0xedb88320u : 0u);
    }
    return t;
  }();
  std::uint32_t crc = ~before;
  for (const char c : bytes) crc = (crc >> 8) ^ table[(crc ^ static_cast<unsigned char>(c)) & 0xff];
  return ~crc;
}

void writeFile(const std::string& path, std::string_view bytes) {
  FileWriter file(path);
  file.write(bytes);
  file.close();
}

}  // namespace enamel
