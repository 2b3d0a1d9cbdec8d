// Scenes made from scans.
#include "scan.hpp"

#include <Eigen/Geometry>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::viewer::test_scan {

namespace {

std::string vertex(const Vec3& v) {
  return "v " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
}

// Write an open bowl of cusps, 60 x 40 mm, as an intraoral scan: only its upper side, turned by `turn`.
void writeArch(const std::string& path, const Mat3& turn) {
  constexpr int n = 24;
  std::string text;
  const auto at = [](int i, int j) {
    const double x = 60.0 * i / n - 30.0, y = 40.0 * j / n - 20.0;
    return Vec3(x, y, 1.5 * std::cos(0.6 * x) * std::cos(0.6 * y) - 0.002 * (x * x + y * y));
  };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) text += vertex(turn * at(i, j));
  const auto index = [](int i, int j) { return std::to_string(i * (n + 1) + j + 1) + " "; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      text += "f " + index(i, j) + index(i + 1, j) + index(i + 1, j + 1) + "\nf " + index(i, j) + index(i + 1, j + 1) +
              index(i, j + 1) + "\n";
  test::writeFile(path, text);
}

}  // namespace

TEST_CASE("a scan stands below the tool, in the unit of its size, and says so", "[viewer]") {
  const test::TemporaryFolder folder;
  CHECK(isScan("/a/b.PLY"));
  CHECK(isScan("b.stl"));
  CHECK_FALSE(isScan("b.toml"));
  CHECK_FALSE(isScan("ply"));
  CHECK(isRecording("a/b.rec"));
  CHECK_FALSE(isRecording("b.ply"));
  const std::string file = folder / "wedge \"1\".obj";
  for (const auto& [factor, unit] : {std::pair{1.0, "mm"}, {1e-3, "m"}, {1e3, "um"}}) {
    // A wedge of 40 x 40 x 20 mm whose highest corner is at (12, -3, 20) mm.
    const auto corner = [f = factor](double x, double y, double z) { return vertex(f * Vec3(x, y, z)); };
    test::writeFile(file, corner(-20, -20, 0) + corner(20, -20, 0) + corner(0, 20, 0) + corner(12, -3, 20) +
                              "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    const ScanScene scan = sceneOfScan(file);
    const SceneFile scene = parseScene(scan.text, file);
    INFO(unit);
    CHECK(scene.name == "wedge \"1\"");
    CHECK(scan.note == "wedge \"1\".obj: 40.0 x 40.0 x 20.0 mm, unit " + std::string(unit) +
                           ", guessed from the size. The surface is closed.");
    CHECK(scene.notes.empty());
    // The tool's ball starts above the highest corner, 8 + 4 mm from it. Coordinates have 6 decimals.
    Pose start;
    start.position = scene.start;
    const Contact nearest = nearestContact(scene.scene, scene.tool, start, nullptr);
    CHECK(nearest.gap == Approx(0.012).margin(2e-6));
    CHECK(scene.scene.obstacles()[0].material.friction > 0.0);
    // Turned by a person, another corner is below the tool: still 12 mm from it.
    ScanPlacement placement;
    placement.turn = Eigen::AngleAxisd(2.0, Vec3(1.0, 2.0, 3.0).normalized()).toRotationMatrix();
    const SceneFile turned = parseScene(sceneOfScan(file, placement).text, file);
    CHECK(turned.scene.obstacles()[0].pose.rotation.isApprox(placement.turn, 1e-8));  // 9 digits of degrees
    CHECK(nearestContact(turned.scene, turned.tool, start, nullptr).gap == Approx(0.012).margin(2e-6));
  }
  ScanPlacement metres;
  metres.unit = "mm";
  CHECK_THROWS_WITH(sceneOfScan(file, metres), test::ContainsSubstring("must be 2 to 500 mm in the unit mm"));
  test::writeFile(folder / "tiny.obj", "v 0 0 0\nv 1e-9 0 0\nv 0 1e-9 0\nf 1 2 3\n");
  CHECK_THROWS_WITH(sceneOfScan(folder / "tiny.obj"), test::ContainsSubstring("tiny.obj: its longest side is"));
  test::writeFile(folder / "torn.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  CHECK_THROWS_WITH(sceneOfScan(folder / "torn.ply"), test::ContainsSubstring("torn.ply"));
}

TEST_CASE("the occlusal side of an open scan faces the person, whatever its frame", "[viewer]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "arch.obj";
  test::Random random(921);
  for (int i = 0; i < 20; ++i) {
    const Mat3 turn = Eigen::AngleAxisd(random.uniform(0.0, 3.1), random.vector(1.0).normalized()).toRotationMatrix();
    writeArch(file, turn);
    const ScanScene scan = sceneOfScan(file);
    const SceneFile scene = parseScene(scan.text, file);
    CHECK_THAT(scan.note, test::ContainsSubstring("The surface is open: touch its outer side."));
    const Vec3 occlusal = scene.scene.obstacles()[0].pose.rotation * turn.col(2);
    CHECK(occlusal.z() > std::cos(2e-2));  // rad: the bowl is symmetric, its grid of cusps is not
  }
}

}  // namespace enamel::viewer::test_scan
