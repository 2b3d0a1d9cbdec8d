// The figures of `enamel study`, drawn without a display, and looked at pixel by pixel.
#include <filesystem>
#include <map>
#include <set>

#include "viewer/support.hpp"

namespace enamel::test_figures {

using test::Pixels;

namespace {

constexpr unsigned kBlue = 0x0072B2, kVermilion = 0xD55E00, kGreen = 0x009E73, kOrange = 0xE69F00;

// Pixels of exactly a colour, or nearly.
int countOf(const Pixels& picture, unsigned rgb, int tolerance = 6) {
  const glm::ivec3 c(rgb >> 16 & 255, rgb >> 8 & 255, rgb & 255);
  int count = 0;
  for (int y = 0; y < picture.size().y; ++y)
    for (int x = 0; x < picture.size().x; ++x) {
      const glm::ivec3 d = glm::abs(picture.at(x, y) - c);
      count += d.x <= tolerance && d.y <= tolerance && d.z <= tolerance;
    }
  return count;
}

int distinctColours(const Pixels& picture) {
  std::set<int> colours;
  for (int y = 0; y < picture.size().y; ++y)
    for (int x = 0; x < picture.size().x; ++x) {
      const glm::ivec3 p = picture.at(x, y);
      colours.insert(p.x << 16 | p.y << 8 | p.z);
    }
  return static_cast<int>(colours.size());
}

// A text that is cut off touches the edge.
bool edgeIsWhite(const Pixels& picture) {
  const glm::ivec2 size = picture.size();
  constexpr int margin = 6;
  for (int y = 0; y < size.y; ++y)
    for (int x = 0; x < size.x; ++x) {
      if (x >= margin && x < size.x - margin && y >= margin && y < size.y - margin) continue;
      if (picture.at(x, y) != glm::ivec3(255)) return false;
    }
  return true;
}

int distance(const glm::ivec3& a, const glm::ivec3& b) {
  const glm::ivec3 d = glm::abs(a - b);
  return d.x + d.y + d.z;
}

const std::map<std::string, std::vector<unsigned>> kCurves = {{"fig06-scene", {0xFFFFFF}},
                                                              {"fig08-response-1", {kBlue, kGreen, kVermilion}},
                                                              {"fig09-response-2", {kBlue, kGreen, kVermilion}},
                                                              {"fig10-first-impact", {}},
                                                              {"along-y", {kBlue, kGreen}},
                                                              {"fig11-torque", {kBlue, kVermilion}},
                                                              {"fig12-steady-1", {}},
                                                              {"fig13-steady-2", {}},
                                                              {"impedance-stability", {0x9CC9E6, 0xF0B27A}},
                                                              {"convergence", {kBlue, kVermilion, kOrange}}};

}  // namespace

TEST_CASE("figures: every one is drawn, has its curves, and cuts nothing off", "[figures]") {
  const test::TemporaryFolder folder;
  const auto result =
      test::runCommand("env -u DISPLAY -u WAYLAND_DISPLAY '" ENAMEL_TOOL "' study --grid 3 --runs 2 --output '" +
                       (folder / "study") + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  CHECK(result.output.find("without figures") == std::string::npos);
  CHECK(result.output.find("VTK") == std::string::npos);  // no warnings either
  std::set<std::string> drawn;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "study/figures"))
    drawn.insert(entry.path().filename().string());
  CHECK(drawn.size() == kCurves.size());
  for (const auto& [name, colours] : kCurves) {
    INFO(name);
    REQUIRE(drawn.count(name + ".png") == 1);
    const Pixels picture(folder / ("study/figures/" + name + ".png"));
    CHECK(picture.size().x >= 1200);
    CHECK(edgeIsWhite(picture));
    CHECK(distinctColours(picture) > 60);
    for (const unsigned colour : colours) {
      INFO(std::hex << colour);
      CHECK(countOf(picture, colour) > 300);
    }
  }

  // Maps: the lowest and the highest colour of the scale stand in the map or its bar, and cells differ.
  for (const char* name : {"fig10-first-impact", "fig12-steady-1"}) {
    INFO(name);
    const Pixels picture(folder / (std::string("study/figures/") + name + ".png"));
    CHECK(countOf(picture, 0x440154, 12) > 200);
    CHECK(countOf(picture, 0xFDE725, 12) > 20);
  }
  // Hold is stiffer than impedance: its cells are lighter, on one scale. Position control comes before it.
  const Pixels map(folder / "study/figures/fig12-steady-1.png");
  const int row = 62 + 185;
  const glm::ivec3 servo = map.at(140 + 414 + 185, row), spring = map.at(140 + 2 * 414 + 185, row);
  CHECK(distance(servo, spring) > 200);
  CHECK(servo.y > spring.y + 80);

  // The report holds exactly these pictures.
  const std::string report = test::readFile(folder / "study/report.html");
  std::size_t pictures = 0;
  for (std::size_t at = 0; (at = report.find("src=\"data:image/png;base64,iVBORw0KGgo", at)) != std::string::npos; ++at)
    ++pictures;
  CHECK(pictures == kCurves.size());
  for (const auto& [name, colours] : kCurves) {
    (void)colours;
    INFO(name);
    // Decoded by another program, the same bytes.
    const std::string start = "alt=\"" + name + "\" src=\"data:image/png;base64,";
    const std::size_t begin = report.find(start) + start.size();
    REQUIRE(begin > start.size());
    test::writeFile(folder / "text", report.substr(begin, report.find('"', begin) - begin));
    CHECK(test::runCommand("base64 -d '" + (folder / "text") + "' | cmp - '" +
                           (folder / ("study/figures/" + name + ".png")) + "'")
              .status == 0);
  }
}

TEST_CASE("figures: of a device of three joints, and of a wall of one point", "[figures]") {
  const test::TemporaryFolder folder;
  const auto drawnBy = [&](const std::string& name, const std::string& arguments) {
    const auto result = test::runCommand("env -u DISPLAY -u WAYLAND_DISPLAY '" ENAMEL_TOOL "' study " + arguments +
                                         " --output '" + (folder / name) + "'");
    INFO(result.output);
    REQUIRE(result.status == 0);
    CHECK(result.output.find("without figures") == std::string::npos);
    CHECK(result.output.find("VTK") == std::string::npos);
    std::set<std::string> drawn;
    for (const auto& entry : std::filesystem::directory_iterator(folder / (name + "/figures"))) {
      INFO(entry.path().filename());
      const Pixels picture(entry.path());
      CHECK(edgeIsWhite(picture));
      CHECK(distinctColours(picture) > 60);
      drawn.insert(entry.path().stem());
    }
    return drawn;
  };
  CHECK(drawnBy("delta", "--device '" ENAMEL_SOURCE_DIR "/data/devices/delta.toml' --grid 3 --runs 2").size() ==
        kCurves.size());
  CHECK(drawnBy("point", "--renderers position-control --scenario 1 --grid 1 --runs 2").count("along-y") == 0);
}

TEST_CASE("figures: descriptions that cannot be drawn are refused in one line", "[figures]") {
  const test::TemporaryFolder folder;
  const std::string program = std::filesystem::path(ENAMEL_TOOL).parent_path() / "enamel-figures";
  for (const char* text : {"{", "{}", R"({"figures": [{"name": "x"}]})",
                           R"({"figures": [{"name": "x", "size": [200, 200], "texts": [{"x": 1, "y": 1}]}]})",
                           R"({"figures": [{"name": "x", "size": [200, 200], "panels": [{"place": [1, 1, 50, 50]}]}]})",
                           R"({"figures": [{"name": "no/such/folder", "size": [200, 200]}]})"}) {
    test::writeFile(folder / "figures.json", text);
    const auto result =
        test::runCommand("'" + program + "' '" + (folder / "figures.json") + "' '" + (folder / "") + "'");
    INFO(text << "\n" << result.output);
    CHECK(result.status == 1);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
  }
  CHECK(test::runCommand("'" + program + "'").status == 2);
}

}  // namespace enamel::test_figures
