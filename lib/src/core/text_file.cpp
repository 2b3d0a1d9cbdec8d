#include "text_file.hpp"

#include <fstream>

#include "enamel/core/error.hpp"
#include "message.hpp"

namespace enamel {
namespace {

constexpr std::streamoff kLargestTextFile = 16 * 1024 * 1024;  // bytes

}  // namespace

std::string readTextFile(const std::string& path) {
  std::ifstream stream(path, std::ios::binary | std::ios::ate);
  if (!stream) throw ConfigurationError(path, 0, "", "cannot open the file");
  const std::streamoff size = stream.tellg();
  if (size < 0) throw ConfigurationError(path, 0, "", "cannot read the file (is it a folder?)");
  if (size > kLargestTextFile)
    throw ConfigurationError(path, 0, "", "is " + std::to_string(size) + " bytes, at most 16 MiB are read");
  std::string text(static_cast<std::size_t>(size), '\0');
  stream.seekg(0);
  if (!stream.read(text.data(), size)) throw ConfigurationError(path, 0, "", "cannot read the file (is it a folder?)");
  return text;
}

}  // namespace enamel
