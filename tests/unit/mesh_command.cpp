// `enamel mesh` as a user runs it: the shipped meshes are sound and are what the generator makes.
#include "enamel/collision/mesh_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_mesh_command {

using Catch::Matchers::Contains;

TEST_CASE("the report names what was counted", "[unit]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "flap.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n");
  const test::CommandResult result = test::run("mesh " + (folder / "flap.off") + " --unit m");
  CHECK(result.status == 0);
  CHECK_THAT(result.output, Contains("boundary edges           3") && Contains("watertight               no") &&
                                Contains("area                     1 m^2"));
}

TEST_CASE("a file that cannot be used is refused in one line", "[unit]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "cut.off", "OFF 3 1 0\n0 0 0\n1 0 0\n");
  for (const std::string& arguments :
       {"mesh " + (folder / "cut.off"), std::string("mesh"), std::string("mesh --generate molar")}) {
    const test::CommandResult result = test::run(arguments);
    CHECK(result.status == 1);
    CHECK(result.output.find('\n') == result.output.size() - 1);
  }
}

TEST_CASE("the shipped meshes are closed, in mm, and made by the generator", "[unit]") {
  const test::TemporaryFolder folder;
  for (const char* name : {"molar", "jaw"}) {
    INFO(name);
    const std::string shipped = ENAMEL_SOURCE_DIR "/data/meshes/" + std::string(name) + ".ply";
    const TriangleMesh mesh = loadMesh(shipped, 1e-3);
    const MeshReport report = inspect(mesh);
    CHECK(report.watertight);
    CHECK_FALSE(report.inwards);
    CHECK(report.degenerateTriangles + report.duplicateTriangles + report.nonManifoldVertices == 0);
    CHECK((report.high - report.low).norm() < 0.1);
    REQUIRE(test::run(std::string("mesh --generate ") + name + " --output " + (folder / "made.ply")).status == 0);
    const TriangleMesh made = loadMesh(folder / "made.ply", 1e-3);
    REQUIRE(made.triangles == mesh.triangles);
    double difference = 0.0;  // sines and powers may differ in their last bit from one C library to the next
    for (std::size_t v = 0; v < made.vertices.size(); ++v)
      difference = std::max(difference, (made.vertices[v] - mesh.vertices[v]).norm());
    CHECK(difference < 1e-8);
  }
}

}  // namespace enamel::test_mesh_command
