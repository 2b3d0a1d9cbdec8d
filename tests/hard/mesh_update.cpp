// A mesh that changes in use answers as one that is built anew.
#include "enamel/collision/mesh_update.hpp"

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/sweep.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_mesh_update {

namespace {

// The mesh without its removed triangles, and the numbers that its triangles had.
std::pair<TriangleMesh, std::vector<int>> remaining(const MeshModel& model) {
  std::pair<TriangleMesh, std::vector<int>> result;
  result.first.vertices = model.mesh().vertices;
  for (int t = 0; t < static_cast<int>(model.mesh().triangles.size()); ++t)
    if (isPresent(model, t)) {
      result.first.triangles.push_back(model.mesh().triangles[static_cast<std::size_t>(t)]);
      result.second.push_back(t);
    }
  return result;
}

void compare(const std::shared_ptr<const MeshModel>& changed, test::Random& random, ProximityCache& cache,
             int queries) {
  const auto [mesh, numbers] = remaining(*changed);
  if (mesh.triangles.empty()) {
    CHECK(closestPoint(*changed, Vec3::Zero(), &cache).triangle == -1);
    return;
  }
  const auto fresh = std::make_shared<const MeshModel>(mesh);
  Scene changedScene, freshScene;
  changedScene.add({"it", changed, Pose(), Vec6::Zero(), {}});
  freshScene.add({"it", fresh, Pose(), Vec6::Zero(), {}});
  Tool tool;
  tool.parts[0].radius = 0.2;
  tool.count = 1;
  const double size = test::sizeOf(mesh);
  Vec3 p = Vec3::Zero();
  for (int i = 0; i < queries; ++i) {
    p = i % 4 == 0 ? test::queryPoint(mesh, size, random) : Vec3(p + 0.003 * random.direction());
    const SurfacePoint a = signedDistance(*changed, p, &cache), b = signedDistance(*fresh, p);
    REQUIRE(a.triangle == numbers[static_cast<std::size_t>(b.triangle)]);
    REQUIRE(std::abs(a.distance) == std::abs(b.distance));
    REQUIRE(a.point == b.point);
    if (std::abs(a.distance) > 1e-7 * size && inspect(mesh).watertight) REQUIRE(a.normal == b.normal);
    const SweepHit sweepA = sweepSphere(*changed, p, p + 0.3 * random.direction(), 0.01);
    CHECK(sweepA.status == Status::ok);
    ContactSnapshot contactsA, contactsB;
    Pose pose;
    pose.position = p;
    REQUIRE(findContacts(changedScene, tool, pose, 0.05, nullptr, contactsA) == Status::ok);
    REQUIRE(findContacts(freshScene, tool, pose, 0.05, nullptr, contactsB) == Status::ok);
    if (a.distance * b.distance <= 0.0) continue;  // without a volume the side of the nearest sheet is not defined
    REQUIRE(contactsA.count == contactsB.count);
    // On the surface itself the sign of a distance of 1e-17 is rounding.
    for (int k = 0; k < contactsA.count; ++k)
      REQUIRE(std::abs(contactsA.contacts[k].gap - contactsB.contacts[k].gap) < 1e-14);
  }
}

}  // namespace

TEST_CASE("moved, removed and replaced triangles answer as a fresh build", "[hard]") {
  test::Random random(51);
  const auto pick = [&random](std::size_t n) {
    return static_cast<int>(std::min(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n))), n - 1));
  };
  for (const int levels : {1, 4}) {
    const auto model = std::make_shared<MeshModel>(test::ball(levels, 0.1));
    const std::size_t vertices = model->mesh().vertices.size(), triangles = model->mesh().triangles.size();
    ProximityCache cache;
    for (int round = 0; round < test::count(30, 300); ++round) {
      // A dent: all vertices near a place, as a tool would push them.
      std::vector<int> moved;
      std::vector<Vec3> positions;
      const Vec3 centre = random.direction();
      for (std::size_t v = 0; v < vertices; ++v)
        if ((model->mesh().vertices[v] - centre).norm() < 0.2) {
          moved.push_back(static_cast<int>(v));
          positions.push_back(model->mesh().vertices[v] * random.uniform(0.9, 1.05));
        }
      REQUIRE(moveVertices(*model, moved.data(), positions.data(), static_cast<int>(moved.size())) == Status::ok);
      if (round == 0) REQUIRE(inspect(model->mesh()).watertight);
      compare(model, random, cache, 20);
      std::vector<int> chosen;
      for (int i = 0; i < static_cast<int>(triangles) / 40 + 1; ++i) chosen.push_back(pick(triangles));
      REQUIRE(removeTriangles(*model, chosen.data(), static_cast<int>(chosen.size())) == Status::ok);
      CHECK_FALSE(isPresent(*model, chosen[0]));
      compare(model, random, cache, 20);
      std::vector<std::array<int, 3>> corners;
      for (std::size_t i = 0; i < chosen.size(); ++i) {
        const auto& t = model->mesh().triangles[static_cast<std::size_t>(pick(triangles))];
        corners.push_back(i % 2 == 0 ? model->mesh().triangles[static_cast<std::size_t>(chosen[i])]
                                     : std::array<int, 3>{t[0], t[1], pick(vertices)});
      }
      REQUIRE(replaceTriangles(*model, chosen.data(), corners.data(), static_cast<int>(chosen.size())) == Status::ok);
      CHECK(isPresent(*model, chosen[0]));
      compare(model, random, cache, 20);
    }
  }
}

TEST_CASE("the sign of a moved closed mesh agrees with the winding number", "[hard]") {
  test::Random random(52);
  MeshModel model(test::ball(4, 0.1));
  std::vector<int> moved;
  std::vector<Vec3> positions;
  for (std::size_t v = 0; v < model.mesh().vertices.size(); ++v)
    if (model.mesh().vertices[v].x() > 0.3) {
      moved.push_back(static_cast<int>(v));
      positions.push_back(model.mesh().vertices[v] * random.uniform(0.8, 1.0));
    }
  REQUIRE(moveVertices(model, moved.data(), positions.data(), static_cast<int>(moved.size())) == Status::ok);
  for (int i = 0; i < test::count(1000, 20000); ++i) {
    const Vec3 p = test::queryPoint(model.mesh(), test::sizeOf(model.mesh()), random);
    const SurfacePoint found = signedDistance(model, p);
    if (std::abs(found.distance) < 1e-8) continue;
    REQUIRE((found.distance < 0.0) == (test::windingNumber(model.mesh(), p) > 0.5));
  }
}

TEST_CASE("everything may be removed, and bad updates change nothing", "[hard]") {
  MeshModel model(test::boxMesh({1, 1, 1}));
  const int bad[2] = {0, 12};
  CHECK(removeTriangles(model, bad, 2) == Status::outOfRange);
  CHECK(isPresent(model, 0));
  const Vec3 far[1] = {Vec3(100, 0, 0)}, nan[1] = {Vec3(std::nan(""), 0, 0)};
  CHECK(moveVertices(model, bad, far, 1) == Status::outOfRange);
  CHECK(moveVertices(model, bad, nan, 1) == Status::notFinite);
  CHECK(moveVertices(model, bad + 1, far, 1) == Status::outOfRange);
  const std::array<int, 3> corners[1] = {{0, 1, 8}};
  CHECK(replaceTriangles(model, bad, corners, 1) == Status::outOfRange);
  CHECK(closestPoint(model, {0, 0, 3}).distance == 2.0);
  int all[12];
  for (int i = 0; i < 12; ++i) all[i] = i;
  CHECK(removeTriangles(model, all, 12) == Status::ok);
  CHECK(closestPoint(model, {0, 0, 3}).triangle == -1);
  CHECK_FALSE(sweepSphere(model, {0, 0, 3}, {0, 0, -3}, 0.1).hit);
  const std::array<int, 3> again[1] = {{4, 5, 6}};
  CHECK(replaceTriangles(model, all, again, 1) == Status::ok);
  CHECK(closestPoint(model, {-0.5, -0.5, 3}).distance == 2.0);
}

}  // namespace enamel::test_mesh_update
