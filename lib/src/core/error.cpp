#include "enamel/core/error.hpp"

#include <utility>

namespace enamel {
namespace {

std::string compose(const std::string& file, int line, const std::string& key, const std::string& problem) {
  std::string message = file;
  if (line > 0) message += ":" + std::to_string(line);
  message += ": ";
  if (!key.empty()) message += key + ": ";
  return message + problem;
}

}  // namespace

std::string printable(std::string_view text) {
  constexpr std::size_t kHead = 1200, kTail = 800;  // bytes: files are at the beginning, reasons at the end
  if (text.size() > kHead + kTail)
    return printable(text.substr(0, kHead)) + " ... " + printable(text.substr(text.size() - kTail));
  constexpr char kDigits[] = "0123456789abcdef";
  std::string line;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    // Also U+0080 to U+009F: two bytes of UTF-8.
    const bool isControl =
        byte < 0x20 || byte == 0x7f || (i > 0 && text[i - 1] == '\xc2' && byte >= 0x80 && byte < 0xa0);
    if (byte == '\n' || byte == '\t')
      line += ' ';
    else if (isControl)
      line += {'\\', 'x', kDigits[byte / 16], kDigits[byte % 16]};
    else
      line += text[i];
  }
  return line;
}

ConfigurationError::ConfigurationError(std::string file, int line, std::string key, const std::string& problem)
    : Error(compose(file, line, key, problem)), file_(std::move(file)), line_(line), key_(std::move(key)) {}

}  // namespace enamel
