// Scenes made from scans.
#include "scan.hpp"

#include "enamel/collision/contacts.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::viewer::test_scan {

TEST_CASE("a scan stands below the tool, in the unit of its size, and says so", "[viewer]") {
  const test::TemporaryFolder folder;
  CHECK(isScan("/a/b.PLY"));
  CHECK(isScan("b.stl"));
  CHECK_FALSE(isScan("b.toml"));
  CHECK_FALSE(isScan("ply"));
  for (const auto& [factor, unit] : {std::pair{1.0, "mm"}, {1e-3, "m"}, {1e3, "um"}}) {
    // A wedge of 40 x 40 x 20 mm whose highest corner is at (12, -3, 20) mm.
    const auto vertex = [f = factor](double x, double y, double z) {
      return "v " + std::to_string(f * x) + " " + std::to_string(f * y) + " " + std::to_string(f * z) + "\n";
    };
    test::writeFile(folder / "wedge.obj", vertex(-20, -20, 0) + vertex(20, -20, 0) + vertex(0, 20, 0) +
                                              vertex(12, -3, 20) + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    const SceneFile scene = sceneOfScan(folder / "wedge.obj");
    INFO(unit);
    CHECK(scene.name == "wedge");
    REQUIRE(scene.notes.size() == 1);
    CHECK(scene.notes[0].rfind(std::string("wedge.obj: 40.0 x 40.0 x 20.0 mm, unit ") + unit + ". ", 0) == 0);
    CHECK(scene.notes[0].find("watertight") != std::string::npos);
    // The tool's ball starts above the highest corner, 8 + 4 mm from it. Coordinates have 6 decimals.
    Pose start;
    start.position = scene.start;
    const Contact nearest = nearestContact(scene.scene, scene.tool, start, nullptr);
    CHECK(nearest.gap == Approx(0.012).margin(2e-6));
    CHECK(scene.scene.obstacles()[0].material.friction > 0.0);
  }
  test::writeFile(folder / "tiny.obj", "v 0 0 0\nv 1e-9 0 0\nv 0 1e-9 0\nf 1 2 3\n");
  CHECK_THROWS_WITH(sceneOfScan(folder / "tiny.obj"), test::ContainsSubstring("tiny.obj: its longest side is"));
  test::writeFile(folder / "torn.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  CHECK_THROWS_WITH(sceneOfScan(folder / "torn.ply"), test::ContainsSubstring("torn.ply"));
}

}  // namespace enamel::viewer::test_scan
