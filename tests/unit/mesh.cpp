// The mesh report counts known defects.
#include "enamel/collision/mesh.hpp"

#include <algorithm>
#include <limits>

#include "collision/mesh_data.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"

namespace enamel::test_mesh {

TEST_CASE("a sound box has no defects and the volume of a box", "[unit]") {
  const MeshReport report = inspect(test::boxMesh({1, 2, 3}));
  CHECK(report.triangles == 12);
  CHECK(report.vertices == 8);
  CHECK(report.edges == 18);
  CHECK(report.components == 1);
  CHECK(report.watertight);
  CHECK_FALSE(report.inwards);
  CHECK(report.volume == Approx(48.0).epsilon(1e-14));
  CHECK(report.area == Approx(88.0).epsilon(1e-14));
  CHECK(report.low == Vec3(-1, -2, -3));
  CHECK(report.high == Vec3(1, 2, 3));
  CHECK(report.degenerateTriangles + report.duplicateTriangles + report.boundaryEdges + report.nonManifoldEdges +
            report.flippedEdges + report.nonManifoldVertices ==
        0);
}

TEST_CASE("each defect is counted", "[unit]") {
  const TriangleMesh box = test::boxMesh({1, 1, 1});
  TriangleMesh mesh = box;
  mesh.triangles.pop_back();
  CHECK(inspect(mesh).boundaryEdges == 3);
  CHECK_FALSE(inspect(mesh).watertight);
  CHECK(inspect(mesh).volume == 0.0);

  mesh = box;
  std::swap(mesh.triangles[4][0], mesh.triangles[4][1]);
  CHECK(inspect(mesh).flippedEdges == 3);
  CHECK_FALSE(inspect(mesh).watertight);

  mesh = box;
  for (auto& t : mesh.triangles) std::swap(t[0], t[1]);
  CHECK(inspect(mesh).inwards);
  CHECK(inspect(mesh).volume == Approx(-8.0).epsilon(1e-14));

  mesh = box;
  mesh.triangles.push_back(mesh.triangles[3]);
  mesh.triangles.push_back({3, 3, 4});
  mesh.triangles.push_back({1, 1, 1});
  CHECK(inspect(mesh).duplicateTriangles == 1);
  CHECK(inspect(mesh).degenerateTriangles == 2);
  CHECK(inspect(mesh).nonManifoldEdges == 3);

  // Two boxes that share one corner, given twice.
  mesh = test::joined(box, test::transformed(box, 1.0, {2, 2, 2}));
  const MeshReport two = inspect(mesh);
  CHECK(two.vertices == 16);
  CHECK(two.places == 15);
  CHECK(two.components == 2);
  CHECK(two.nonManifoldVertices == 1);
  CHECK(two.watertight);
}

TEST_CASE("separate vertices at one place are one place", "[unit]") {
  for (const auto& [name, mesh, closed] : test::brokenMeshes())
    if (name == "loose vertices") {
      const MeshReport report = inspect(mesh);
      CHECK(report.watertight);
      CHECK(report.places * 2 - 4 == report.triangles);  // Euler's formula
    }
}

TEST_CASE("meshes that no query can use are refused with the place", "[unit]") {
  using test::ContainsSubstring;
  TriangleMesh mesh = test::boxMesh({1, 1, 1});
  mesh.vertices[5].y() = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(inspect(mesh), ContainsSubstring("vertex 5"));
  mesh.vertices[5].y() = 2e9;
  CHECK_THROWS_WITH(checkMesh(mesh), ContainsSubstring("vertex 5"));
  mesh = test::boxMesh({1, 1, 1});
  mesh.triangles[7][1] = 8;
  CHECK_THROWS_WITH(checkMesh(mesh), ContainsSubstring("triangle 7") && ContainsSubstring("vertex 8"));
  CHECK_THROWS_AS(checkMesh(TriangleMesh{}), Error);
}

TEST_CASE("a mesh has few nodes, and no memory for more", "[unit]") {
  for (const auto& [name, mesh, closed] : test::soundMeshes()) {
    INFO(name);
    const MeshModel model(mesh);
    const kernel::MeshData& data = kernel::Inside::of(model);
    const auto isExact = [](const auto& vector) { return vector.capacity() == vector.size(); };
    CHECK((isExact(data.nodes) && isExact(data.boxes) && isExact(data.nodeParent)));
    CHECK((isExact(data.leaves) && isExact(data.leafParent) && isExact(data.triangles)));
    // Each node but the first, and each leaf, takes one of a node's kWidth places. The tree of least area
    // fills more than half of them.
    const std::size_t places = kernel::kWidth - 1, least = (data.leaves.size() - 1 + places - 1) / places;
    CHECK(data.nodes.size() <= std::max<std::size_t>(1, 2 * least));
  }
}

TEST_CASE("a model says what it is and how its sign is found", "[unit]") {
  using test::ContainsSubstring;
  const auto said = [](const TriangleMesh& mesh) { return describe(MeshModel(mesh)); };
  TriangleMesh mesh = test::ball(2);
  CHECK_THAT(said(mesh), ContainsSubstring("watertight: ") && ContainsSubstring("exact"));
  CHECK_THAT(said(test::joined(mesh, test::transformed(mesh, 1.0, {0.5, 0.1, 0.2}))),
             ContainsSubstring("crosses itself"));
  TriangleMesh flipped = mesh;
  std::swap(flipped.triangles[3][0], flipped.triangles[3][1]);
  CHECK_THAT(said(flipped), ContainsSubstring("open (3 edges between triangles of opposite orientation)"));
  TriangleMesh inwards = mesh;
  for (auto& t : inwards.triangles) std::swap(t[0], t[1]);
  CHECK_THAT(said(inwards), ContainsSubstring("watertight, normals point inwards"));
  CHECK(signedDistance(MeshModel(inwards), Vec3(0.1, 0.2, 0.0)).distance < 0.0);
  CHECK(signedDistance(MeshModel(inwards), Vec3(0.1, 0.2, 1.1)).normal.z() > 0.5);
  mesh.triangles.pop_back();
  CHECK_THAT(said(mesh), ContainsSubstring("open (3 boundary edges)") &&
                             ContainsSubstring("points with a winding number above 1/2 are inside"));
  CHECK_FALSE(isSound(MeshModel(mesh)));
  inwards.triangles.pop_back();  // a small hole does not hide the orientation
  CHECK(signedDistance(MeshModel(inwards), Vec3(0.1, 0.2, 0.0)).distance < 0.0);
}

}  // namespace enamel::test_mesh
