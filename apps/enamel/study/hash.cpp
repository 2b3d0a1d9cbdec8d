#include "study/hash.hpp"

#include <fmt/core.h>

namespace enamel::app {

std::string hashOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return fmt::format("{:016x}", hash);
}

std::string hashOf(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{} ", value);
  return hashOf(text);
}

std::string hashOf(const std::vector<ServoGain>& gains) {
  std::vector<double> values;
  for (const ServoGain& gain : gains) values.insert(values.end(), gain.data(), gain.data() + gain.size());
  return hashOf(values);
}

}  // namespace enamel::app
