#include "toml.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/message.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

std::string nameOfType(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "a list";
    case toml::node_type::string: return "a string";
    case toml::node_type::integer: return "an integer";
    case toml::node_type::floating_point: return "a number";
    case toml::node_type::boolean: return "a boolean";
    default: return "a date or time";
  }
}

constexpr std::size_t kLargestToml = std::size_t{1} << 18;  // bytes: each may take 100 bytes of memory

// Whether a key is one typing error away: a missing, additional or wrong letter, or two swapped letters.
bool isAlmost(std::string_view meant, std::string_view found) {
  const std::size_t shorter = std::min(meant.size(), found.size()), longer = std::max(meant.size(), found.size());
  std::size_t front = 0, back = 0;
  while (front < shorter && meant[front] == found[front]) ++front;
  while (back < shorter - front && meant[meant.size() - 1 - back] == found[found.size() - 1 - back]) ++back;
  const std::size_t differ = longer - front - back;
  return longer - shorter <= 1 && shorter > 1 &&
         (differ == 1 ||
          (differ == 2 && longer == shorter && meant[front] == found[front + 1] && meant[front + 1] == found[front]));
}

int lineOf(const toml::node& node) { return static_cast<int>(node.source().begin.line); }

}  // namespace

TomlTable parseToml(std::string_view text, const std::string& file) {
  if (text.size() > kLargestToml)
    throw ConfigurationError(
        file, 0, "",
        "is " + std::to_string(text.size()) + " bytes, at most " + std::to_string(kLargestToml) + " are read");
  checkNesting(text, file);
  try {
    auto root = std::make_shared<const toml::table>(toml::parse(text, file));
    const toml::table* table = root.get();
    return TomlTable(std::move(root), table, file, "");
  } catch (const toml::parse_error& error) {
    throw ConfigurationError(file, static_cast<int>(error.source().begin.line), "",
                             "not valid TOML: " + std::string(error.description()));
  } catch (const Error& error) {  // from refuseToml()
    throw ConfigurationError(file, 0, "", error.what());
  }
}

void refuseToml() { throw Error("not valid TOML"); }

TomlTable::TomlTable(std::shared_ptr<const toml::table> root, const toml::table* table, std::string file,
                     std::string path)
    : root_(std::move(root)), table_(table), file_(std::move(file)), path_(std::move(path)) {}

bool TomlTable::has(std::string_view key) const {
  asked_.emplace(key);
  return table_->contains(key);
}
bool TomlTable::isText(std::string_view key) const { return table_->get_as<std::string>(key) != nullptr; }

int TomlTable::line(std::string_view path) const {
  for (std::string_view rest = path; !rest.empty();) {
    if (const toml::node* node = table_->at_path(rest).node()) return lineOf(*node);
    const std::size_t cut = rest.find_last_of(".[");
    rest = cut == std::string_view::npos ? std::string_view() : rest.substr(0, cut);
  }
  return lineOf(*table_);
}

std::string TomlTable::fullKey(std::string_view key) const { return path_ + std::string(key); }

void TomlTable::fail(std::string_view key, const std::string& problem) const {
  throw ConfigurationError(file_, line(key), fullKey(key), problem);
}

const toml::node& TomlTable::require(std::string_view key) {
  asked_.emplace(key);
  const toml::node* node = table_->get(key);
  if (node == nullptr) {
    for (const auto& [other, value] : *table_)
      if (isAlmost(key, other.str()))
        fail(key, "is missing; is it " + printable(std::string(other.str())) + " of line " +
                      std::to_string(lineOf(value)) + "?");
    fail(key, "is missing");
  }
  read_.emplace(key);
  return *node;
}

std::string TomlTable::text(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_string()) fail(key, "is " + nameOfType(node) + ", must be a string");
  const std::string& text = **node.as_string();
  if (printable(text) != text)
    fail(key, "is \"" + text + "\", must be one line of at most 2000 bytes without control characters");
  return text;
}

double TomlTable::asNumber(const toml::node& node, std::string_view key) const {
  if (!node.is_number())
    throw ConfigurationError(file_, lineOf(node), fullKey(key), "is " + nameOfType(node) + ", must be a number");
  const double value = *node.value<double>();
  if (!std::isfinite(value))
    throw ConfigurationError(file_, lineOf(node), fullKey(key), "is " + formatNumber(value) + ", must be finite");
  return value;
}

void TomlTable::asNumbers(const toml::node& node, std::string_view key, double* values, std::size_t count) const {
  const toml::array* list = node.as_array();
  const std::string wanted = "must be a list of " + std::to_string(count) + " numbers";
  if (list == nullptr)
    throw ConfigurationError(file_, lineOf(node), fullKey(key), "is " + nameOfType(node) + ", " + wanted);
  if (list->size() != count)
    throw ConfigurationError(file_, lineOf(node), fullKey(key),
                             "has " + std::to_string(list->size()) + " elements, " + wanted);
  for (std::size_t i = 0; i < count; ++i)
    values[i] = asNumber((*list)[i], std::string(key) + "[" + std::to_string(i) + "]");
}

double TomlTable::number(std::string_view key) { return asNumber(require(key), key); }

std::int64_t TomlTable::integer(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_integer()) fail(key, "is " + nameOfType(node) + ", must be an integer");
  return **node.as_integer();
}

bool TomlTable::boolean(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_boolean()) fail(key, "is " + nameOfType(node) + ", must be true or false");
  return **node.as_boolean();
}

Vec3 TomlTable::vector3(std::string_view key) {
  Vec3 value;
  asNumbers(require(key), key, value.data(), 3);
  return value;
}

Vec6 TomlTable::vector6(std::string_view key) {
  Vec6 value;
  asNumbers(require(key), key, value.data(), 6);
  return value;
}

std::vector<double> TomlTable::numbers(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_array()) fail(key, "is " + nameOfType(node) + ", must be a list of numbers");
  std::vector<double> values(node.as_array()->size());
  asNumbers(node, key, values.data(), values.size());
  return values;
}

std::vector<Vec3> TomlTable::points(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_array()) fail(key, "is " + nameOfType(node) + ", must be a list of points of 3 numbers");
  std::vector<Vec3> values(node.as_array()->size());
  for (std::size_t i = 0; i < values.size(); ++i)
    asNumbers((*node.as_array())[i], std::string(key) + "[" + std::to_string(i) + "]", values[i].data(), 3);
  return values;
}

Mat3 TomlTable::matrix3(std::string_view key) {
  const toml::node& node = require(key);
  const toml::array* rows = node.as_array();
  if (rows == nullptr || rows->size() != 3)
    fail(key, "must be a list of 3 rows of 3 numbers, or of 3 numbers for a diagonal matrix");
  if (!(*rows)[0].is_array()) {
    Vec3 diagonal;
    asNumbers(node, key, diagonal.data(), 3);
    return diagonal.asDiagonal();
  }
  Mat3 value;
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3 row;
    asNumbers((*rows)[i], std::string(key) + "[" + std::to_string(i) + "]", row.data(), 3);
    value.row(static_cast<int>(i)) = row;
  }
  return value;
}

TomlTable TomlTable::table(std::string_view key) {
  const toml::node& node = require(key);
  if (!node.is_table()) fail(key, "is " + nameOfType(node) + ", must be a table");
  return TomlTable(root_, node.as_table(), file_, fullKey(key) + ".");
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
  const toml::node& node = require(key);
  const toml::array* list = node.as_array();
  if (list == nullptr) fail(key, "is " + nameOfType(node) + ", must be a list of tables");
  std::vector<TomlTable> result;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string name = fullKey(key) + "[" + std::to_string(i) + "]";
    if (!(*list)[i].is_table())
      throw ConfigurationError(file_, lineOf((*list)[i]), name, "is " + nameOfType((*list)[i]) + ", must be a table");
    result.push_back(TomlTable(root_, (*list)[i].as_table(), file_, name + "."));
  }
  return result;
}

void TomlTable::finish() const {
  for (const auto& [key, node] : *table_) {
    if (read_.count(key.str()) != 0) continue;
    std::string hint;
    for (const std::string& known : asked_) hint += (hint.empty() ? "; possible are " : ", ") + known;
    for (const std::string& known : asked_)
      if (read_.count(known) == 0 && isAlmost(known, key.str())) hint = "; is it " + known + "?";
    throw ConfigurationError(file_, static_cast<int>(key.source().begin.line), fullKey(key.str()),
                             "is not a known key" + hint);
  }
}

}  // namespace enamel
