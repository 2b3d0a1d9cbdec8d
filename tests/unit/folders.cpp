// The table of folders in CONTRIBUTING.md matches the disk.
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_folders {

namespace {

namespace fs = std::filesystem;
const fs::path kSource = ENAMEL_SOURCE_DIR;
using Names = std::set<std::string>;

// Return the table's contents by folder. A row begins with its folder; texts after it that end in a slash are its
// subfolders.
std::map<std::string, Names> namedFolders(const std::string& page) {
  std::map<std::string, Names> named;
  const auto add = [&named](const fs::path& folder) {
    named[folder.parent_path().string()].insert(folder.filename().string());
  };
  const std::string heading = "## Where things are\n```\n";
  const std::size_t begin = page.find(heading) + heading.size();
  std::istringstream rows(page.substr(begin, page.find("```", begin) - begin));
  const std::regex name(R"(([A-Za-z0-9_]+)/(?=[\s,.;:)]|$))");
  for (std::string row; std::getline(rows, row);) {
    const std::string folder = row.substr(0, row.find("/ "));
    const std::string text = row.substr(folder.size() + 1);
    add(folder);
    for (std::sregex_iterator found(text.begin(), text.end(), name), end; found != end; ++found)
      add(fs::path(folder) / (*found)[1].str());
  }
  return named;
}

Names foldersIn(const fs::path& folder) {
  Names names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory() && name[0] != '.' && name[0] != '_') names.insert(name);  // not __pycache__
  }
  return names;
}

}  // namespace

TEST_CASE("a row of the table names its folder and those in it", "[folders]") {
  const auto named = namedFolders(
      "# Page\n## Where things are\n```\nlib/src/core/   types/ and (files/), a/b or c\napps/  viewer/: x/y, "
      "tool/\n```\nz/\n");
  CHECK(named.size() == 4);
  CHECK(named.at("lib/src") == Names{"core"});
  CHECK(named.at("lib/src/core") == Names{"types", "files"});
  CHECK(named.at("") == Names{"apps"});
  CHECK(named.at("apps") == Names{"viewer", "tool"});
}

TEST_CASE("the table of folders names what is on the disk", "[folders]") {
  const auto named = namedFolders(test::readFile((kSource / "CONTRIBUTING.md").string()));
  for (const char* folder : {"lib/include/enamel", "plugins", "apps", "data", "tests"}) {
    INFO(folder);
    REQUIRE(named.count(folder) == 1);
    CHECK(named.at(folder) == foldersIn(kSource / folder));
  }
  for (const auto& [folder, names] : named)
    for (const std::string& name : names) {
      INFO(folder << "/" << name);
      CHECK(fs::is_directory(kSource / folder / name));
    }
  CHECK(foldersIn(kSource / "lib/src") == foldersIn(kSource / "lib/include/enamel"));  // "the same folders"
  for (const std::string& module : foldersIn(kSource / "lib/src")) {
    const std::string folder = "lib/include/enamel/" + module;
    INFO(folder);
    CHECK((named.count(folder) == 1 ? named.at(folder) : Names{}) == foldersIn(kSource / folder));
  }
}

}  // namespace enamel::test_folders
