// The sign of meshes that are open, intersect themselves or are not surfaces, compared with all their solid angles.
#include <Eigen/Geometry>
#include <cstdio>

#include "collision/mesh_data.hpp"
#include "collision/winding.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/mesh_update.hpp"
#include "enamel/collision/proximity.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_sign {

namespace {

constexpr double kCoarse = 0.05, kStated = 1e-3;  // error of the winding number; how close to 1/2 the sign may differ

TriangleMesh without(TriangleMesh mesh, double part, int seed) {
  test::Random random(seed);
  std::vector<std::array<int, 3>> kept;
  for (const auto& t : mesh.triangles)
    if (random.uniform(0.0, 1.0) >= part) kept.push_back(t);
  mesh.triangles = kept;
  return mesh;
}

// Remove everything below a height.
TriangleMesh cutOff(TriangleMesh mesh, int axis, double part) {
  const MeshReport report = inspect(mesh);
  const double height = report.low[axis] + part * (report.high[axis] - report.low[axis]);
  std::vector<std::array<int, 3>> kept;
  for (const auto& t : mesh.triangles)
    if (mesh.vertices[t[0]][axis] > height) kept.push_back(t);
  mesh.triangles = kept;
  return mesh;
}

TriangleMesh soup(int count, int seed) {
  test::Random random(seed);
  TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const Vec3 centre = random.vector(0.01);
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(centre + random.vector(0.006));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

std::vector<test::NamedMesh> openMeshes() {
  std::vector<test::NamedMesh> all;
  const auto add = [&](const std::string& name, TriangleMesh mesh) { all.push_back({name, std::move(mesh), false}); };
  const TriangleMesh wavy = test::transformed(test::ball(4, 0.1), 0.01, Vec3::Zero());
  add("cup", cutOff(wavy, 2, 0.6));
  for (const double part : {0.01, 0.1, 0.3}) add("ball with holes", without(wavy, part, 81));
  add("two balls", test::joined(wavy, test::transformed(wavy, 0.9, {0.005, 0.002, 0.001})));
  const std::string folder = test::largeMeshFolder();
  if (folder.empty()) std::puts("skipped: the large meshes are not installed");
  if (folder.empty()) return all;
  const TriangleMesh scan = loadMesh(folder + "/dental-scan.ply", 1e-3),
                     tooth = loadMesh(folder + "/tooth36.ply", 1e-3);
  add("scan", scan);
  for (int axis = test::longRun() ? 0 : 2; axis < 3; ++axis) add("scan cut off", cutOff(scan, axis, 0.3));
  for (const double part : {0.01, 0.1, 0.3})
    if (part == 0.3 || test::longRun()) add("scan with holes", without(scan, part, 82));
  add("two teeth", test::joined(tooth, test::transformed(tooth, 1.0, {0.003, 0.001, 0.0})));
  return all;
}

// Compare signs at `count` points; return how many are inside by the winding number of all triangles.
int compare(const std::string& name, const TriangleMesh& mesh, int count, int seed) {
  INFO(name);
  const MeshModel model(mesh);
  const kernel::MeshData& data = kernel::Inside::of(model);
  CHECK_FALSE(data.sound);
  test::Random random(seed);
  const double size = test::sizeOf(mesh);
  const SimdLevel best = simdLevel();
  int inside = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3 p = i % 2 == 0
                       ? test::queryPoint(mesh, size, random)
                       : Vec3(data.low + (data.high - data.low)
                                             .cwiseProduct(Vec3{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0),
                                                                random.uniform(0.0, 1.0)}));
    const SurfacePoint found = signedDistance(model, p);
    const double winding = test::windingNumber(mesh, p);
    if (std::abs(found.distance) > 1e-7 * data.size) {
      REQUIRE(std::abs(kernel::windingNumber(data, p, 2.0) - winding) < kCoarse);
      if (i % 16 == 0) REQUIRE(std::abs(kernel::windingNumber(data, p, 8.0) - winding) < kStated);
      const double here = kernel::windingNumber(data, p, 2.0);
      for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512})
        if (useSimdLevel(level) == level) REQUIRE(kernel::windingNumber(data, p, 2.0) == here);
      useSimdLevel(best);
    }
    if (std::abs(winding - 0.5) < kStated || std::abs(found.distance) < 1e-7 * data.size) continue;
    const bool isBeyond = ((p - data.low).array() < 0.0).any() || ((data.high - p).array() < 0.0).any();
    const bool isInside = !isBeyond && winding > 0.5;
    INFO("point " << i << " at " << p.transpose() << ": " << found.distance << ", winding number " << winding);
    REQUIRE((found.distance < 0.0) == isInside);
    CHECK((p - found.distance * found.normal - found.point).norm() <= 1e-12 * (data.size + std::abs(found.distance)));
    inside += isInside;
  }
  return inside;
}

}  // namespace

TEST_CASE("the sign of an open mesh is that of its winding number", "[hard]") {
  for (const auto& [name, mesh, closed] : openMeshes()) {
    const int count = mesh.triangles.size() > 50000 ? test::count(25, 5000) : test::count(400, 20000);
    CHECK(compare(name, mesh, count, 83) >= count / 50);
  }
  for (int i = 0; i < 100; ++i) (void)compare("soup", soup(10 + 3 * i, 1000 + i), test::count(30, 1000), 84 + i);
}

TEST_CASE("outside of the bounding box is outside", "[hard]") {
  auto all = openMeshes();
  for (auto& mesh : test::brokenMeshes()) all.push_back(std::move(mesh));
  for (auto& mesh : test::soundMeshes()) {
    for (auto& t : mesh.mesh.triangles) std::swap(t[0], t[1]);  // inwards
    all.push_back(std::move(mesh));
  }
  all.push_back({"soup", soup(100, 85), false});
  for (const auto& [name, mesh, closed] : all) {
    INFO(name);
    const auto shared = std::make_shared<const MeshModel>(mesh);
    const MeshModel& model = *shared;
    const kernel::MeshData& data = kernel::Inside::of(model);
    Scene scene;
    scene.add({"it", shared, Pose(), Vec6::Zero(), {}});
    test::Random random(86);
    const int count = name == "scan" ? test::count(5000, 1000000) : test::count(500, 50000);
    int asked = 0;
    for (int i = 0; asked < count && i < 4 * count; ++i) {
      Vec3 p = 0.5 * (data.low + data.high) + random.vector(0.7 * data.size + 1e-6);
      if (i % 2 == 0) {  // just outside
        const int axis = i / 2 % 3;
        p[axis] = i / 6 % 2 == 0 ? data.low[axis] - 1e-3 * data.size : data.high[axis] + 1e-3 * data.size;
      }
      if (!((p - data.low).array() < 0.0).any() && !((data.high - p).array() < 0.0).any()) continue;
      ++asked;
      REQUIRE(signedDistance(model, p).distance >= 0.0);
      const double distance = closestPoint(model, p).distance;
      const ContactSnapshot contacts =
          test::contactsOf(scene, test::sphereTool(std::min(0.3 * distance, kLargestTool)), test::at(p), 0.0);
      REQUIRE(contacts.count == 0);
    }
    CHECK(asked > count / 2);
  }
}

TEST_CASE("no false contact of an open scan at poses outside of what it was cut from", "[hard]") {
  const std::string folder = test::largeMeshFolder();
  const TriangleMesh whole = folder.empty() ? test::transformed(test::ball(5, 0.1), 0.01, Vec3::Zero())
                                            : loadMesh(folder + "/tooth36.ply", 1e-3);
  const MeshModel closed(whole);
  Scene scene;
  const MeshModel& open = *[&] {
    auto model = std::make_shared<const MeshModel>(cutOff(without(whole, 0.02, 87), 2, 0.15));
    scene.add({"it", model, Pose(), Vec6::Zero(), {}});
    return model.get();
  }();
  test::Random random(88);
  int asked = 0, far = 0;
  const int count = test::count(20000, 1000000);
  while (asked < count) {
    const Vec3 p = random.vector(0.012);
    const double distance = signedDistance(closed, p).distance;
    if (!(distance > 1e-5)) continue;
    ++asked;
    const double radius = 0.9 * closestPoint(open, p).distance;
    const ContactSnapshot contacts = test::contactsOf(scene, test::sphereTool(radius), test::at(p), 0.0);
    // A hole is closed where the winding number is 1/2. That surface may bulge, but by less than the hole's width.
    far += contacts.count > 0 && contacts.contacts[0].gap + radius < -0.5e-3;
  }
  CHECK(far == 0);
}

TEST_CASE("edits that open a mesh and close it again change how its sign is told", "[hard]") {
  const TriangleMesh mesh = test::ball(3, 0.1);
  MeshModel model(mesh);
  const kernel::MeshData& data = kernel::Inside::of(model);
  test::Random random(89);
  std::vector<Vec3> points;
  std::vector<double> before;
  for (int i = 0; i < 200; ++i) {
    points.push_back(random.vector(1.1));
    before.push_back(signedDistance(model, points.back()).distance);
  }
  const auto differ = [&] {
    int count = 0;
    for (std::size_t i = 0; i < points.size(); ++i) count += signedDistance(model, points[i]).distance != before[i];
    return count;
  };
  REQUIRE(data.sound);
  for (int round = 0; round < 20; ++round) {
    std::array<int, 5> triangles;
    std::array<std::array<int, 3>, 5> corners;
    for (std::size_t k = 0; k < 5; ++k) {
      triangles[k] = (37 * round + 101 * static_cast<int>(k)) % 512;
      corners[k] = mesh.triangles[static_cast<std::size_t>(triangles[k])];
    }
    REQUIRE(removeTriangles(model, triangles.data(), 5) == Status::ok);
    REQUIRE_FALSE(data.closed);
    CHECK(differ() < 20);  // near the holes only
    std::swap(corners[0][0], corners[0][1]);
    REQUIRE(replaceTriangles(model, triangles.data(), corners.data(), 5) == Status::ok);
    REQUIRE_FALSE(data.closed);  // one triangle has the wrong orientation
    CHECK(differ() < 10);
    std::swap(corners[0][0], corners[0][1]);
    REQUIRE(replaceTriangles(model, triangles.data(), corners.data(), 5) == Status::ok);
    REQUIRE(data.sound);
    CHECK(differ() == 0);
  }
}

}  // namespace enamel::test_sign
