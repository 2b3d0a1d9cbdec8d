// Strict reading of TOML files: every key must be known, present and of the right type, every number finite.
// Private to the library, so that toml++ is no dependency of its users.
#pragma once

// toml++ 3.3 asserts what malformed files break ("[,a]"), and optimises by it where assertions are off: here it throws.
namespace enamel {
[[noreturn]] void refuseToml();
}
#pragma push_macro("NDEBUG")
#undef NDEBUG
#define TOML_ASSERT(condition) ((condition) ? void() : ::enamel::refuseToml())
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

#include <initializer_list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// One table of a TOML file. Read every key, then call finish(), which refuses the keys that nobody read.
class TomlTable {
 public:
  bool has(std::string_view key) const;
  /// Line of a key, which may be a path such as "chain[0].link1.mass"; of the closest parent where it is absent.
  int line(std::string_view path) const;

  std::string text(std::string_view key);
  double number(std::string_view key);
  std::int64_t integer(std::string_view key);
  bool boolean(std::string_view key);
  Vec3 vector3(std::string_view key);
  Vec6 vector6(std::string_view key);
  std::vector<double> numbers(std::string_view key);  ///< of any length
  /// A 3 x 3 matrix given by its rows, or by its diagonal as a list of three numbers.
  Mat3 matrix3(std::string_view key);
  TomlTable table(std::string_view key);
  std::vector<TomlTable> tables(std::string_view key);

  /// Refuses keys that were not read. Throws ConfigurationError.
  void finish() const;

  /// Throws a ConfigurationError that names file, line and full key (or path, as for line()).
  [[noreturn]] void fail(std::string_view key, const std::string& problem) const;

 private:
  friend TomlTable parseToml(std::string_view text, const std::string& file);
  TomlTable(std::shared_ptr<const toml::table> root, const toml::table* table, std::string file, std::string path);

  const toml::node& require(std::string_view key);
  std::string fullKey(std::string_view key) const;
  double asNumber(const toml::node& node, std::string_view key) const;
  void asNumbers(const toml::node& node, std::string_view key, double* values, std::size_t count) const;

  std::shared_ptr<const toml::table> root_;  // keeps the whole document alive
  const toml::table* table_;
  std::string file_;
  std::string path_;  // "" or "chain[0].link1."
  std::set<std::string, std::less<>> read_;
};

/// Parses TOML text; `file` stands in messages. Throws ConfigurationError.
TomlTable parseToml(std::string_view text, const std::string& file);

}  // namespace enamel
