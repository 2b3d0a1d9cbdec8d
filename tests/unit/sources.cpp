// Every source of the library has a test of its name, or a row of `covered_by` in tests/CMakeLists.txt names its test.
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_sources {

namespace {

namespace fs = std::filesystem;
const fs::path kSource = ENAMEL_SOURCE_DIR;

// The rows of `covered_by`, and the names in enamel_add_test() and foreach() lists.
struct Tests {
  std::map<std::string, std::string> covers;  // by source, relative to lib/src without suffix: "unit/x"
  std::set<std::string> words;                // of the file without comments and those rows
};

Tests testsOf(const std::string& page) {
  Tests tests;
  std::string text = std::regex_replace(page, std::regex("#[^\n]*"), "");
  const std::string begin = "set(covered_by\n";
  const std::size_t from = text.find(begin);
  if (from != std::string::npos) {
    const std::size_t to = text.find(')', from);
    std::istringstream rows(text.substr(from + begin.size(), to - from - begin.size()));
    text.erase(from, to - from);
    for (std::string source, test; rows >> source >> test;) tests.covers[source] = test;
  }
  const std::regex word("\\w+");
  for (std::sregex_iterator found(text.begin(), text.end(), word), end; found != end; ++found)
    tests.words.insert(found->str());
  return tests;
}

// Return the faults in the tree at `root`, one line each.
std::vector<std::string> faultsOf(const fs::path& root) {
  const Tests tests = testsOf(test::readFile((root / "tests/CMakeLists.txt").string()));
  const auto exists = [&](const fs::path& test) {
    return fs::exists(root / "tests" / (test.string() + ".cpp")) && tests.words.count(test.filename().string()) == 1;
  };
  std::map<std::string, std::string> sources;  // by path: the stem
  std::map<std::string, int> namesakes;
  for (const auto& entry : fs::recursive_directory_iterator(root / "lib/src")) {
    if (entry.path().extension() != ".cpp") continue;
    const fs::path name = fs::relative(entry.path(), root / "lib/src").replace_extension();
    sources[name.string()] = name.filename().string();
    ++namesakes[name.filename().string()];
  }
  std::vector<std::string> faults;
  for (const auto& [source, stem] : sources) {
    bool hasOwn = false;
    for (const char* label : {"unit", "hard", "plugin", "realtime"}) hasOwn = hasOwn || exists(fs::path(label) / stem);
    hasOwn = hasOwn && namesakes.at(stem) == 1;
    const bool hasRow = tests.covers.count(source) == 1;
    const std::string name = "lib/src/" + source + ".cpp";
    if (!hasOwn && !hasRow) faults.push_back(name + " has no test of its name and no row in covered_by");
    if (hasOwn && hasRow) faults.push_back(name + " has a test of its name and a row in covered_by");
  }
  for (const auto& [source, test] : tests.covers) {
    if (sources.count(source) == 0) faults.push_back("covered_by: lib/src/" + source + ".cpp does not exist");
    if (!exists(test)) faults.push_back("covered_by: tests/" + test + ".cpp is no test");
  }
  return faults;
}

}  // namespace

TEST_CASE("a source without a test, a row without a source and a row without a test are found", "[sources]") {
  const test::TemporaryFolder folder;
  const fs::path root = folder / "tree";
  const auto write = [&root](const fs::path& file, const std::string& text) {
    fs::create_directories((root / file).parent_path());
    test::writeFile((root / file).string(), text);
  };
  const auto page = [&](const std::string& rows) {
    write("tests/CMakeLists.txt", "# seen: no test\nset(covered_by\n" + rows + ")\nenamel_add_test(unit own)\n");
    return faultsOf(root);
  };
  const std::string begin = "lib/src/core/";
  for (const char* test : {"unit/own", "hard/seen"}) write(fs::path("tests") / (std::string(test) + ".cpp"), "");
  write("lib/src/core/own.cpp", "");
  write("lib/src/core/own.hpp", "");
  CHECK(page("").empty());

  write("lib/src/core/seen.cpp", "");  // its file exists, but is not added as a test
  CHECK(page("") == std::vector<std::string>{begin + "seen.cpp has no test of its name and no row in covered_by"});
  CHECK(page("  core/seen unit/own\n").empty());
  CHECK(page("  core/seen hard/seen") == std::vector<std::string>{"covered_by: tests/hard/seen.cpp is no test"});
  CHECK(page("  core/seen unit/own core/gone unit/own") ==
        std::vector<std::string>{"covered_by: lib/src/core/gone.cpp does not exist"});
  CHECK(page("  core/seen unit/own core/own unit/own") ==
        std::vector<std::string>{begin + "own.cpp has a test of its name and a row in covered_by"});

  write("lib/src/core/deep/own.cpp", "");  // two sources of one name: which one does tests/unit/own.cpp cover?
  CHECK(page("  core/seen unit/own").size() == 2);
  CHECK(page("  core/seen unit/own core/own unit/own core/deep/own unit/own").empty());
}

TEST_CASE("every source of the library has a test", "[sources]") {
  std::string faults;
  for (const std::string& fault : faultsOf(kSource)) faults += fault + "\n";
  CHECK(faults == "");
  CHECK(testsOf(test::readFile((kSource / "tests/CMakeLists.txt").string())).covers.size() > 10);
}

}  // namespace enamel::test_sources
