// A mesh that changes in use gives the same results as a new one.
#include "enamel/collision/mesh_update.hpp"

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/sweep.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_mesh_update {

namespace {

// Return the mesh without its removed triangles, and the old numbers of its triangles.
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
    if (a.distance * b.distance <= 0.0) continue;  // without a volume, the side of the nearest sheet is undefined
    REQUIRE(contactsA.count == contactsB.count);
    // On the surface itself, the sign of a distance of 1e-17 is rounding.
    for (int k = 0; k < contactsA.count; ++k)
      REQUIRE(std::abs(contactsA.contacts[k].gap - contactsB.contacts[k].gap) < 1e-14);
  }
}

}  // namespace

TEST_CASE("moved, removed, replaced and added triangles answer as a fresh build", "[hard]") {
  test::Random random(51);
  const auto pick = [&random](std::size_t n) {
    return static_cast<int>(std::min(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n))), n - 1));
  };
  for (const int levels : {1, 4}) {
    const int rounds = test::count(24, 300), perRound = levels == 1 ? 2 : 60;
    const auto model =
        std::make_shared<MeshModel>(test::ball(levels, 0.1), SpareCapacity{rounds * perRound, rounds * perRound});
    const std::size_t vertices = model->mesh().vertices.size(), triangles = model->mesh().triangles.size();
    ProximityCache cache;
    for (int round = 0; round < rounds; ++round) {
      // Make a dent: move all vertices near a place, as a tool would.
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
      const int firstVertex = static_cast<int>(model->mesh().vertices.size());
      const int firstTriangle = static_cast<int>(model->mesh().triangles.size());
      std::vector<Vec3> spikes;  // on random triangles
      std::vector<std::array<int, 3>> sides;
      for (int i = 0; i < perRound; ++i) {
        const auto& t = model->mesh().triangles[static_cast<std::size_t>(pick(triangles))];
        spikes.push_back(model->mesh().vertices[static_cast<std::size_t>(t[0])] * random.uniform(1.0, 1.2));
        sides.push_back({t[0], t[1], firstVertex + i});
      }
      REQUIRE(addVertices(*model, spikes.data(), perRound) == Status::ok);
      REQUIRE(addTriangles(*model, sides.data(), perRound) == Status::ok);
      CHECK(isPresent(*model, firstTriangle + perRound - 1));
      compare(model, random, cache, 20);
    }
  }
}

TEST_CASE("below an overhang that an edit makes is outside, whichever triangle is the first", "[hard]") {
  // A flat lid with two rings around its middle, above a deep point. One vertex of the inner ring moves down and back,
  // so that the middle hangs over a pit. The surface bends only there: elsewhere one normal gives the side.
  TriangleMesh mesh;
  mesh.vertices.push_back(Vec3::Zero());
  const int corners = 5;
  for (const double radius : {1.0, 2.0})
    for (const double angle : {0.0, 100.0, 160.0, 200.0, 260.0})
      mesh.vertices.push_back(radius * Vec3(std::cos(angle * M_PI / 180.0), std::sin(angle * M_PI / 180.0), 0.0));
  mesh.vertices.push_back({0.0, 0.0, -10.0});
  for (int i = 0; i < corners; ++i) {
    const int a = 1 + i, b = 1 + (i + 1) % corners;
    for (const std::array<int, 3>& t : {std::array<int, 3>{0, a, b},
                                        {a, a + corners, b + corners},
                                        {a, b + corners, b},
                                        {b + corners, a + corners, 1 + 2 * corners}})
      mesh.triangles.push_back(t);
  }
  REQUIRE(inspect(mesh).watertight);
  const Vec3 p = 0.05 * Vec3(1.0, 0.0, -0.05).normalized();
  for (std::size_t first = 0; first < mesh.triangles.size(); ++first) {
    INFO("triangle " << first);
    MeshModel model(mesh);
    CHECK(signedDistance(model, p).distance < 0.0);
    const int moved = 1;
    const Vec3 to(-0.1, 0.0, -1.0);
    REQUIRE(moveVertices(model, &moved, &to, 1) == Status::ok);
    CHECK(test::windingNumber(model.mesh(), p) == Approx(0.0).margin(1e-9));
    CHECK(signedDistance(model, p).distance == Approx(0.05).epsilon(1e-12));
    std::rotate(mesh.triangles.begin(), mesh.triangles.begin() + 1, mesh.triangles.end());
  }
}

TEST_CASE("what a cache holds ready does not outlive an edit", "[hard]") {
  test::Random random(55);
  MeshModel model(test::ball(4, 0.1));
  ProximityCache cache;
  for (int round = 0; round < 20; ++round) {
    const Vec3 way = random.direction();
    for (int i = 0; i < 300; ++i) {  // slowly, so that the cache works ahead
      const Vec3 p = (1.3 + 1e-5 * i) * way;
      const SurfacePoint found = closestPoint(model, p, &cache), plain = closestPoint(model, p);
      REQUIRE(found.triangle == plain.triangle);
      REQUIRE(found.point == plain.point);
      if (i != 200) continue;
      for (const int v : model.mesh().triangles[static_cast<std::size_t>(found.triangle)]) {
        const Vec3 to = 0.7 * model.mesh().vertices[static_cast<std::size_t>(v)];
        REQUIRE(moveVertices(model, &v, &to, 1) == Status::ok);
      }
    }
  }
}

TEST_CASE("where triangles were removed, a cache finds the nearest of the others", "[hard]") {
  test::Random random(54);
  const TriangleMesh mesh = test::ball(3);
  MeshModel model(mesh);
  std::vector<int> front;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t)
    if (mesh.vertices[static_cast<std::size_t>(mesh.triangles[static_cast<std::size_t>(t)][0])].x() > 0.0)
      front.push_back(t);
  REQUIRE(removeTriangles(model, front.data(), static_cast<int>(front.size())) == Status::ok);
  for (int i = 0; i < 200; ++i) {
    ProximityCache cache;
    (void)closestPoint(model, random.ofLength(1.5, 3.0), &cache);
    const Vec3 p = random.ofLength(1.5, 3.0);
    const SurfacePoint found = closestPoint(model, p, &cache), plain = closestPoint(model, p);
    REQUIRE(found.triangle == plain.triangle);
    REQUIRE(found.point == plain.point);
  }
}

TEST_CASE("the sign of a moved closed mesh agrees with the winding number, also if it crosses itself", "[hard]") {
  const bool crosses = GENERATE(false, true);
  test::Random random(52);
  MeshModel model(test::ball(4, 0.1));
  std::vector<int> moved;
  std::vector<Vec3> positions;
  for (std::size_t v = 0; v < model.mesh().vertices.size(); ++v)
    if (model.mesh().vertices[v].x() > 0.3) {
      moved.push_back(static_cast<int>(v));
      positions.push_back(crosses ? random.vector(1.0) : Vec3(model.mesh().vertices[v] * random.uniform(0.8, 1.0)));
    }
  REQUIRE(moveVertices(model, moved.data(), positions.data(), static_cast<int>(moved.size())) == Status::ok);
  ProximityCache cache;
  for (int i = 0; i < test::count(1000, 20000); ++i) {
    const Vec3 p = i % 2 == 0 ? test::queryPoint(model.mesh(), test::sizeOf(model.mesh()), random) : random.vector(3.0);
    const SurfacePoint found = signedDistance(model, p, &cache);
    if (std::abs(found.distance) < 1e-8) continue;
    REQUIRE((found.distance < 0.0) == (test::windingNumber(model.mesh(), p) > 0.5));
  }
}

TEST_CASE("a model says what it is after updates", "[hard]") {
  MeshModel model(test::boxMesh({1, 1, 1}), {1, 2});
  CHECK_THAT(describe(model), test::ContainsSubstring("watertight: the sign"));
  const int lid[2] = {2, 3};
  REQUIRE(removeTriangles(model, lid, 2) == Status::ok);
  CHECK_THAT(describe(model), test::ContainsSubstring("open (4 boundary edges)"));
  CHECK(presentMesh(model).triangles.size() == 10);
  CHECK(inspect(presentMesh(model)).boundaryEdges == 4);
  // Another lid from separate triangles: a pyramid.
  const Vec3 tip(0, 0, 2);
  const std::array<int, 3> sides[4] = {{4, 5, 8}, {5, 7, 8}, {7, 6, 8}, {6, 4, 8}};
  REQUIRE(addVertices(model, &tip, 1) == Status::ok);
  REQUIRE(addTriangles(model, sides, 2) == Status::ok);
  CHECK(addTriangles(model, sides + 2, 1) == Status::outOfRange);  // no room
  CHECK(addVertices(model, &tip, 1) == Status::outOfRange);
  CHECK(spareCapacity(model).triangles == 0);
  REQUIRE(replaceTriangles(model, lid, sides + 2, 2) == Status::ok);
  CHECK_THAT(describe(model), test::ContainsSubstring("watertight: the sign"));
  CHECK(isSound(model));
  CHECK(signedDistance(model, {0, 0, 3}).distance == 1.0);
  CHECK(signedDistance(model, {0, 0, 1.5}).distance < 0.0);
  int all[14];
  for (int i = 0; i < 14; ++i) all[i] = i;
  REQUIRE(removeTriangles(model, all, 14) == Status::ok);
  CHECK(describe(model) == "has no triangles left");
  CHECK_THROWS_AS(MeshModel(test::boxMesh({1, 1, 1}), {-1, 0}), Error);
  CHECK_THROWS_AS(MeshModel(test::boxMesh({1, 1, 1}), {0, 1 << 27}), Error);
}

TEST_CASE("everything may be removed, and bad updates change nothing", "[hard]") {
  MeshModel model(test::boxMesh({1, 1, 1}), {4, 4});
  const int bad[2] = {0, 12};
  CHECK(removeTriangles(model, bad, 2) == Status::outOfRange);
  CHECK(isPresent(model, 0));
  const Vec3 far[1] = {Vec3(100, 0, 0)}, nan[1] = {Vec3(std::nan(""), 0, 0)};
  CHECK(moveVertices(model, bad, far, 1) == Status::outOfRange);
  CHECK(moveVertices(model, bad, nan, 1) == Status::notFinite);
  CHECK(moveVertices(model, bad + 1, far, 1) == Status::outOfRange);
  CHECK(moveVertices(model, bad, far, -1) == Status::outOfRange);
  CHECK(removeTriangles(model, bad, -1) == Status::outOfRange);
  CHECK(addVertices(model, far, 1) == Status::outOfRange);
  CHECK(addVertices(model, nan, 1) == Status::notFinite);
  CHECK(addVertices(model, far, -1) == Status::outOfRange);
  const std::array<int, 3> corners[1] = {{0, 1, 8}};
  CHECK(replaceTriangles(model, bad, corners, 1) == Status::outOfRange);
  CHECK(addTriangles(model, corners, 1) == Status::outOfRange);
  CHECK(addTriangles(model, corners, -1) == Status::outOfRange);
  CHECK(model.mesh().triangles.size() == 12);
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
