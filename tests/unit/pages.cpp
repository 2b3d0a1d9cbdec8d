// Pages and examples: links have a target, shown code is tested code, examples are short.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_pages {

namespace {

namespace fs = std::filesystem;
const fs::path kSource = ENAMEL_SOURCE_DIR;

// Return every page of the project.
std::vector<fs::path> pages() {
  std::vector<fs::path> result;
  for (const auto& entry : fs::directory_iterator(kSource))
    if (entry.path().extension() == ".md") result.push_back(entry.path());
  for (const char* folder : {"lib", "apps", "plugins", "data"})
    for (const auto& entry : fs::recursive_directory_iterator(kSource / folder))
      if (entry.path().extension() == ".md") result.push_back(entry.path());
  return result;
}

// Return the lines without spaces at both ends; empty ones are left out.
std::vector<std::string> linesOf(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin != std::string::npos) result.push_back(line.substr(begin, line.find_last_not_of(' ') + 1 - begin));
  }
  return result;
}

// Return the anchors of headings, as hosts of repositories make them.
std::set<std::string> anchorsOf(const std::string& text) {
  std::set<std::string> result;
  for (const std::string& line : linesOf(text)) {
    if (line[0] != '#') continue;
    std::string anchor;
    for (const char c : line.substr(line.find_first_not_of("# "))) {
      if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_')
        anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      else if (c == ' ')
        anchor += '-';
    }
    result.insert(anchor);
  }
  return result;
}

// Check that the lines of each block of C++ on a page follow each other in one of the sources. Return the number of
// blocks.
int blocksFrom(const std::vector<std::vector<std::string>>& sources, const std::string& page) {
  const std::string text = test::readFile((kSource / page).string()), open = "```cpp\n";
  int blocks = 0;
  for (std::size_t at = 0; (at = text.find(open, at)) != std::string::npos; ++blocks) {
    const std::size_t begin = at + open.size();
    at = text.find("```", begin);
    const std::vector<std::string> shown = linesOf(text.substr(begin, at - begin));
    INFO(page << ": " << shown.front());
    CHECK(std::any_of(sources.begin(), sources.end(), [&](const std::vector<std::string>& lines) {
      return std::search(lines.begin(), lines.end(), shown.begin(), shown.end()) != lines.end();
    }));
  }
  return blocks;
}

}  // namespace

TEST_CASE("every relative link of the pages leads to a file, and to a heading where it names one", "[pages]") {
  const std::regex link(R"(\]\(([^)#: ]*)(?:#([^)]*))?\))");
  int links = 0;
  for (const fs::path& page : pages()) {
    const std::string text = test::readFile(page.string());
    for (std::sregex_iterator found(text.begin(), text.end(), link), end; found != end; ++found) {
      const std::string file = (*found)[1], heading = (*found)[2];
      INFO(page << ": " << found->str());
      const fs::path target = file.empty() ? page : page.parent_path() / file;
      REQUIRE(fs::exists(target));
      if (!heading.empty()) CHECK(anchorsOf(test::readFile(target.string())).count(heading) == 1);
      ++links;
    }
  }
  CHECK(links > 60);
}

TEST_CASE("the examples are below 80 lines, each is on their page, and the first hour shows their lines", "[pages]") {
  const std::string page = test::readFile((kSource / "apps/examples/README.md").string());
  std::vector<std::vector<std::string>> sources;
  for (const auto& folder : fs::directory_iterator(kSource / "apps/examples")) {
    if (!folder.is_directory()) continue;
    CHECK(page.find("[" + folder.path().filename().string() + "]") != std::string::npos);
    for (const auto& file : fs::directory_iterator(folder)) {
      INFO(file.path());
      const std::string text = test::readFile(file.path().string());
      CHECK(std::count(text.begin(), text.end(), '\n') < 80);
      sources.push_back(linesOf(text));
    }
  }
  CHECK(sources.size() >= 12);

  CHECK(blocksFrom(sources, "lib/docs/first-hour.md") >= 4);
}

TEST_CASE("the page of sessions shows the lines of its test", "[pages]") {
  const std::string test = test::readFile((kSource / "tests/unit/session_page.cpp").string());
  CHECK(blocksFrom({linesOf(test)}, "lib/docs/session.md") >= 9);
}

}  // namespace enamel::test_pages
