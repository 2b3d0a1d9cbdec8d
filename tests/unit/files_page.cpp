// lib/docs/files.md: its statements about keys of scene and device files match the readers.
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_files_page {

namespace {

const std::string kSource = ENAMEL_SOURCE_DIR;

struct Row {
  std::string key, example;
  bool needed = false;
  bool ofDevice = false;
};

// A complete file that can be loaded: shipped, or a block of the page.
struct File {
  std::string name, text;
  bool ofDevice = false;

  void load() const {
    if (ofDevice)
      (void)makeMechanism(parseDevice(text, name));
    else
      (void)parseScene(text, kSource + "/data/scenes/" + name);
  }
};

const std::string& page() {
  static const std::string text = test::readFile(kSource + "/lib/docs/files.md");
  return text;
}

std::vector<Row> rows() {
  const std::regex row(R"(^\| `([a-z0-9_]+)` \|(.*)\| `([^`]*)` \|[^|]*\|$)");
  std::vector<Row> result;
  std::istringstream lines(page());
  bool ofDevice = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == "## Device files") ofDevice = true;
    if (std::smatch match; std::regex_match(line, match, row))
      result.push_back({match[1], match[3], match[2].str().find("| needed ") != std::string::npos, ofDevice});
  }
  return result;
}

std::vector<File> files() {
  std::vector<File> result;
  const std::string open = "```toml\n";
  for (std::size_t at = 0; (at = page().find(open, at)) != std::string::npos;) {
    const std::size_t begin = at + open.size();
    at = page().find("```", begin);
    const std::string text = page().substr(begin, at - begin);
    result.push_back({"block.toml", text, text.find("axes") != std::string::npos});
  }
  for (const bool ofDevice : {false, true})
    for (const auto& entry :
         std::filesystem::directory_iterator(kSource + (ofDevice ? "/data/devices" : "/data/scenes")))
      result.push_back({entry.path().filename().string(), test::readFile(entry.path().string()), ofDevice});
  return result;
}

// Return the position of the last line of `text` that begins with `example` after spaces, or npos.
std::size_t lineOf(const std::string& text, const std::string& example) {
  for (std::size_t at = text.rfind(example); at != std::string::npos;
       at = at > 0 ? text.rfind(example, at - 1) : std::string::npos) {
    const std::size_t line = text.rfind('\n', at) + 1;
    if (text.find_first_not_of(' ', line) != at) continue;
    const char next = at + example.size() < text.size() ? text[at + example.size()] : '\n';
    if (next == '\n' || next == ' ') return at;
  }
  return std::string::npos;
}

}  // namespace

TEST_CASE("the page of files names the keys that the readers ask for, and no others", "[files_page]") {
  std::set<std::string> asked, named;
  const std::regex call(
      R"re((?:text|number|integer|boolean|vector3|vector6|matrix3|numbers|points|tables?|has|position|direction|length|read|readLink|refuseTurn)\((?:[\w\[\]]+, )?"([a-z0-9_]+)")re");
  const std::regex entry(R"re(\{"([a-z_]+)", (?:"[^"]*", )?&)re");
  std::vector<std::string> sources = {"collision/scene_file.cpp", "collision/bur_limits.hpp", "device/read.cpp"};
  for (const char* kind : {"tau", "delta", "cartesian"})
    sources.push_back(std::string("device/") + kind + "/parameters.cpp");
  for (const std::string& source : sources) {
    const std::string text = test::readFile(kSource + "/lib/src/" + source);
    for (const std::regex& pattern : {call, entry})
      for (std::sregex_iterator found(text.begin(), text.end(), pattern), end; found != end; ++found)
        asked.insert((*found)[1]);
  }
  for (const Row& row : rows()) named.insert(row.key);
  CHECK(asked.size() > 70);
  CHECK(named == asked);
}

TEST_CASE("every example of the page of files stands in a file that loads, and only without a needed key it does not",
          "[files_page]") {
  const std::vector<File> all = files();
  CHECK(all.size() >= 14);
  for (const File& file : all) {
    INFO(file.name);
    CHECK_NOTHROW(file.load());
  }
  for (const Row& row : rows()) {
    INFO(row.key << ": " << row.example);
    bool found = false;
    for (const File& file : all) {
      const std::size_t at = file.ofDevice == row.ofDevice ? lineOf(file.text, row.example) : std::string::npos;
      if (at == std::string::npos) continue;
      found = true;
      // Required by the following lines.
      if (row.example[0] == '[' || row.key == "thin" || row.key == "cable_stiffness" || row.key == "rotor_mass") break;
      File without = file;
      without.text.erase(at, file.text.find('\n', at) - at);
      if (row.needed)
        CHECK_THROWS_WITH(without.load(), test::ContainsSubstring(row.key));
      else
        CHECK_NOTHROW(without.load());
      break;
    }
    // A rod in one line.
    if (!found && row.key == "radius")
      for (const File& file : all) found = found || file.text.find(row.example) != std::string::npos;
    CHECK(found);
  }
}

}  // namespace enamel::test_files_page
