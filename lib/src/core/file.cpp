#include "enamel/core/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "enamel/core/error.hpp"

namespace enamel {

std::string readFile(const std::string& path, std::size_t most) {
  const auto refuse = [&path](const std::string& problem) { throw ConfigurationError(path, 0, "", problem); };
  struct Descriptor {
    const int number;
    ~Descriptor() { close(number); }
  };
  // Without O_NONBLOCK a pipe would wait for a writer.
  const Descriptor file{open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};
  if (file.number < 0) refuse(std::string("cannot open the file: ") + std::strerror(errno));
  struct stat status {};
  if (fstat(file.number, &status) != 0) refuse(std::string("cannot read the file: ") + std::strerror(errno));
  if (S_ISDIR(status.st_mode)) refuse("is a folder, not a file");
  if (!S_ISREG(status.st_mode)) refuse("is a pipe or a device, must be a regular file");
  if (static_cast<std::size_t>(status.st_size) > most)
    refuse("is " + std::to_string(status.st_size) + " bytes, at most " + std::to_string(most) + " are read");
  std::string text(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t got = read(file.number, text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(std::string("cannot read the file: ") + std::strerror(errno));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
  }
  if (size != text.size() || (size == 0 && read(file.number, &status, 1) > 0))  // files of /proc report a size of 0
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
  struct stat there {};
  const bool exists = stat(path.c_str(), &there) == 0;
  if (path == "/dev/stdout") {  // continue at the present position of the standard output
    std::fflush(stdout);
    file_.reset(fdopen(dup(STDOUT_FILENO), "wb"));
  } else if (exists && !S_ISREG(there.st_mode)) {
    file_.reset(std::fopen(path.c_str(), "wb"));
  } else {
    if (!exists && errno != ENOENT) fail();
    static std::atomic<unsigned> count{0};
    std::error_code ignored;
    if (exists && access(path.c_str(), W_OK) != 0) fail();
    if (exists) target_ = std::filesystem::canonical(path, ignored).string();
    while (!exists && std::filesystem::is_symlink(target_, ignored)) {  // to a file that does not exist yet
      const std::filesystem::path link(target_);
      target_ = (link.parent_path() / std::filesystem::read_symlink(link, ignored)).string();
    }
    int number = -1;
    do {  // a killed process may have had the same number, typically in a container
      beside_ = target_ + "." + std::to_string(getpid()) + "-" + std::to_string(count++) + ".part";
      number = open(beside_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (number < 0 && errno == EEXIST);
    if (number < 0) {
      beside_.clear();
      fail();
    }
    if (exists) (void)fchmod(number, there.st_mode & 07777u);
    file_.reset(fdopen(number, "wb"));
  }
  if (file_) return;
  if (!beside_.empty()) unlink(beside_.c_str());
  fail();
}

FileWriter::~FileWriter() {
  if (!beside_.empty()) unlink(beside_.c_str());
}

void FileWriter::fail() const { throw Error(path_ + ": cannot write the file: " + std::strerror(errno)); }

void FileWriter::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
}

void FileWriter::close() {
  if (std::fflush(file_.get()) != 0 || std::fclose(file_.release()) != 0) fail();
  if (beside_.empty()) return;
  if (std::rename(beside_.c_str(), target_.c_str()) != 0) fail();
  beside_.clear();
}

void writeFile(const std::string& path, std::string_view bytes) {
  FileWriter file(path);
  file.write(bytes);
  file.close();
}

}  // namespace enamel
