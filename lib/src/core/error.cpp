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

ConfigurationError::ConfigurationError(std::string file, int line, std::string key, const std::string& problem)
    : Error(compose(file, line, key, problem)), file_(std::move(file)), line_(line), key_(std::move(key)) {}

}  // namespace enamel
