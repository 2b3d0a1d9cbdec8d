// The order of layers: every #include of lib, plugins, apps and tests/support points to a lower layer, or sideways if
// permitted.
#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_layers {

namespace {

namespace fs = std::filesystem;
const fs::path kSource = ENAMEL_SOURCE_DIR;

// A module may include lower layers; within its own layer only the modules in kBeside. Some modules do not exist yet.
const std::vector<std::vector<std::string>> kLayers = {{"core"},
                                                       {"device", "control", "collision"},
                                                       {"render"},
                                                       {"sim", "runtime", "plugin"},
                                                       {"multibody", "identify", "study", "session"},
                                                       {"c"},
                                                       {"plugins", "apps"},
                                                       {"tests"}};
const std::map<std::string, std::set<std::string>> kBeside = {
    {"control", {"device"}},                                           // the linear plant of a mechanism
    {"identify", {"study"}},                                           // threads
    {"apps/enamel", {"apps/program", "apps/colours", "plugins/fmi"}},  // writes units and uses them as plants
    {"plugins/haply", {"plugins/driver_functions.hpp"}},
    {"plugins/forcedimension", {"plugins/driver_functions.hpp", "plugins/vendor_library.hpp"}},
    {"plugins/openhaptics", {"plugins/driver_functions.hpp", "plugins/vendor_library.hpp"}},
    {"apps/labels", {"apps/program"}},
    {"apps/viewer", {"apps/program", "apps/colours", "apps/offscreen"}}};

// Return "sim" for lib/src/sim/push.cpp and lib/include/enamel/sim/push.hpp; "apps/viewer" for apps/viewer/run.cpp.
std::string moduleOf(const fs::path& file) {
  std::vector<std::string> parts;
  for (const fs::path& part : file) parts.push_back(part.string());
  if (parts[0] == "tests") return "tests";
  if (parts[0] != "lib") return parts[0] + "/" + parts[1];
  return parts[1] == "include" ? parts.at(3) : parts.at(2);
}

std::size_t layerOf(const std::string& module) {
  const std::string name = module.substr(0, module.find('/'));
  std::size_t layer = 0;
  while (layer < kLayers.size() && std::count(kLayers[layer].begin(), kLayers[layer].end(), name) == 0) ++layer;
  return layer;
}

bool isPublic(const fs::path& file) { return file.string().rfind("lib/include/", 0) == 0; }
bool isOfLib(const fs::path& file) { return file.string().rfind("lib/", 0) == 0; }

// Return why a file may not include another; empty if it may. Paths are relative to the root.
std::string refusal(const fs::path& from, const fs::path& to) {
  const std::string above = moduleOf(from), below = moduleOf(to);
  if (layerOf(above) == kLayers.size()) return above + " is not in the order of layers";
  if (isOfLib(to) && !isPublic(to)) {
    if (isPublic(from)) return "a public header includes a private one";
    if (!isOfLib(from) && above != "tests") return above + " includes a private header of lib";
  }
  if (above == below || layerOf(above) > layerOf(below)) return "";
  const auto beside = kBeside.find(above);
  if (beside != kBeside.end() && beside->second.count(below) == 1) return "";
  return above + " may not include " + below;
}

// Return the sources of a tree, relative to its root.
std::vector<fs::path> sourcesOf(const fs::path& root) {
  const std::set<std::string> kinds = {".hpp", ".h", ".cpp", ".c", ".inl", ".in"};
  std::vector<fs::path> files;
  for (const char* folder : {"lib", "plugins", "apps", "tests/support"}) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (kinds.count(entry.path().extension().string()) == 1) files.push_back(fs::relative(entry.path(), root));
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Return the file of an include; nothing if it is outside of the tree.
std::optional<fs::path> fileOf(const fs::path& from, const std::string& name, const std::vector<fs::path>& files) {
  const auto isThere = [&](const fs::path& file) { return std::binary_search(files.begin(), files.end(), file); };
  const fs::path module = isOfLib(from) ? fs::path("lib/src") : fs::path(moduleOf(from));
  for (const fs::path& folder : {from.parent_path(), module, fs::path("lib/include"), fs::path("lib/src"),
                                 fs::path("apps"), fs::path("tests"), fs::path()})
    if (const fs::path file = (folder / name).lexically_normal(); isThere(file)) return file;
  // Relative to a folder of a target that is not named here.
  for (const fs::path& file : files)
    if (("/" + file.string()).size() > name.size() && file.string().rfind("/" + name) != std::string::npos &&
        file.string().rfind("/" + name) + name.size() + 1 == file.string().size())
      return file;
  return std::nullopt;
}

struct Arrows {
  int count = 0;                   // between files of the tree
  std::vector<std::string> wrong;  // "file:line: text: why"
};

Arrows arrowsOf(const fs::path& root) {
  const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"].*)");
  const std::vector<fs::path> files = sourcesOf(root);
  Arrows arrows;
  for (const fs::path& file : files) {
    std::istringstream text(test::readFile((root / file).string()));
    int number = 1;
    for (std::string line; std::getline(text, line); ++number) {
      std::smatch match;
      if (!std::regex_match(line, match, include)) continue;
      const std::optional<fs::path> to = fileOf(file, match[2], files);
      if (to) ++arrows.count;
      const std::string why = to ? refusal(file, *to) : match[1] == "<" ? "" : "leads nowhere";
      if (!why.empty()) arrows.wrong.push_back(file.string() + ":" + std::to_string(number) + ": " + line + ": " + why);
    }
  }
  return arrows;
}

// Return each of `texts` on its own line.
std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += text + "\n";
  return all;
}

}  // namespace

TEST_CASE("no include points up or to the side", "[layers]") {
  const Arrows arrows = arrowsOf(kSource);
  INFO(joined(arrows.wrong));
  CHECK(arrows.wrong.empty());
  CHECK(arrows.count > 1000);
}

TEST_CASE("an include that points up is found, and its line is told", "[layers]") {
  const test::TemporaryFolder folder;
  const fs::path root = fs::path(folder / "").parent_path();
  const auto write = [&](const std::string& path, const std::string& text) {
    fs::create_directories((root / path).parent_path());
    test::writeFile((root / path).string(), text);
  };
  const auto wrong = [&] { return arrowsOf(root).wrong; };
  for (const char* module : {"core", "device", "control", "collision", "render", "sim", "runtime", "study"})
    write(std::string("lib/include/enamel/") + module + "/" + module + ".hpp", "");
  write("lib/src/core/message.hpp", "");
  write("apps/enamel/plants.hpp", "");
  write("apps/viewer/palette.hpp", "");
  write("plugins/fmi/export.hpp", "");

  // Allowed includes.
  write("lib/src/control/x.cpp", "#include \"enamel/device/device.hpp\"\n#include \"core/message.hpp\"\n");
  write("lib/src/sim/x.cpp", "#include <enamel/render/render.hpp>\n#include <vector>\n");
  write("apps/enamel/fmu.cpp", "#include \"plants.hpp\"\n#include \"plugins/fmi/export.hpp\"\n");
  CHECK(wrong().empty());
  CHECK(arrowsOf(root).count == 5);

  const std::vector<std::vector<std::string>> refused = {
      {"lib/src/core/y.cpp", "enamel/device/device.hpp", "core may not include device"},
      {"lib/src/device/y.cpp", "enamel/control/control.hpp", "device may not include control"},
      {"lib/src/collision/y.cpp", "enamel/device/device.hpp", "collision may not include device"},
      {"lib/src/render/y.cpp", "enamel/sim/sim.hpp", "render may not include sim"},
      {"lib/src/sim/y.cpp", "enamel/runtime/runtime.hpp", "sim may not include runtime"},
      {"lib/src/runtime/y.cpp", "enamel/study/study.hpp", "runtime may not include study"},
      {"lib/src/study/y.cpp", "../../../apps/enamel/plants.hpp", "study may not include apps/enamel"},
      {"lib/include/enamel/sim/y.hpp", "core/message.hpp", "a public header includes a private one"},
      {"lib/src/other/y.cpp", "enamel/core/core.hpp", "other is not in the order of layers"},
      {"plugins/python/y.cpp", "apps/enamel/plants.hpp", "plugins/python may not include apps/enamel"},
      {"plugins/python/y.cpp", "plants.hpp", "plugins/python may not include apps/enamel"},
      {"plugins/python/y.cpp", "plugins/fmi/export.hpp", "plugins/python may not include plugins/fmi"},
      {"plugins/python/y.cpp", "core/message.hpp", "plugins/python includes a private header of lib"},
      {"apps/viewer/y.cpp", "enamel/plants.hpp", "apps/viewer may not include apps/enamel"},
      {"apps/enamel/y.cpp", "viewer/palette.hpp", "apps/enamel may not include apps/viewer"},
      {"apps/enamel/y.cpp", "missing.hpp", "leads nowhere"}};
  for (const auto& row : refused) {
    write(row[0], "// a comment\n  # include \"" + row[1] + "\"  // another\n");
    const auto found = wrong();
    REQUIRE(found.size() == 1);
    CHECK(found[0] == row[0] + ":2:   # include \"" + row[1] + "\"  // another: " + row[2]);
    fs::remove(root / row[0]);
  }
}

TEST_CASE("only the files of a system include its headers", "[layers]") {
  const std::regex header(
      R"(\s*#\s*include\s*<(sys/|arpa/|netinet/|netdb|unistd|fcntl|pthread|dlfcn|poll|sched|signal\.h|spawn|elf|windows|winsock2|io\.h).*)");
  const std::regex ported("(lib|apps/(enamel|program|colours))/.*");
  int count = 0;
  for (const fs::path& file : sourcesOf(kSource)) {
    const std::string stem = file.stem().string();
    const bool isOfSystem = std::regex_search(stem, std::regex("_(posix|windows)$"));
    if (!std::regex_match(file.generic_string(), ported)) continue;
    std::istringstream text(test::readFile((kSource / file).string()));
    for (std::string line; std::getline(text, line);) {
      if (!std::regex_match(line, header)) continue;
      INFO(file.string() + ": " + line);
      CHECK(isOfSystem);
      ++count;
    }
  }
  CHECK(count > 20);
}

// "core <- device, control": the layers that exist.
TEST_CASE("CONTRIBUTING states this order", "[layers]") {
  const auto exists = [](const std::string& module) {
    return fs::exists(kSource / "lib/src" / module) || fs::exists(kSource / module);
  };
  std::string order;
  for (const std::vector<std::string>& layer : kLayers) {
    if (layer == kLayers.back()) break;  // nothing includes tests
    std::string names;
    for (const std::string& module : layer)
      if (exists(module)) names += (names.empty() ? "" : ", ") + module;
    order += (order.empty() ? "" : " <- ") + names;
  }
  std::string page = test::readFile((kSource / "CONTRIBUTING.md").string());
  page = std::regex_replace(page, std::regex("\\s+"), " ");
  INFO(order);
  CHECK(page.find("`" + order + "`") != std::string::npos);
}

}  // namespace enamel::test_layers
