// Nearest points on sound, broken and real meshes against references that use other formulas than the library.
#include "enamel/collision/proximity.hpp"

#include <cstdio>

#include "collision/mesh_data.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_proximity {

namespace {

std::vector<test::NamedMesh> allMeshes() {
  std::vector<test::NamedMesh> all = test::soundMeshes();
  for (auto& mesh : test::brokenMeshes()) all.push_back(std::move(mesh));
  const std::string folder = test::largeMeshFolder();
  if (folder.empty()) std::puts("skipped: the large meshes are not installed");
  if (!folder.empty())
    for (const char* name : {"tooth36", "dental-scan-10k", "dental-scan", "armadillo-10k", "armadillo"}) {
      TriangleMesh mesh = loadMesh(folder + "/" + name + ".ply", 1e-3);
      const bool closed = inspect(mesh).watertight;
      all.push_back({name, std::move(mesh), closed});
    }
  return all;
}

}  // namespace

TEST_CASE("distances are exact on every mesh", "[hard]") {
  for (const auto& [name, mesh, closed] : allMeshes()) {
    const MeshModel model(mesh);
    const test::ReferenceDistance reference(mesh);
    const double size = test::sizeOf(mesh);
    test::Random random(11);
    const int count = mesh.triangles.size() > 50000 ? test::count(300, 100000) : test::count(1000, 100000);
    double worst = 0.0;
    for (int i = 0; i < count; ++i) {
      const Vec3 p = test::queryPoint(mesh, size, random);
      const SurfacePoint found = closestPoint(model, p);
      const double truth = reference(p);
      // Rounding of the inputs alone changes a distance by 1e-16 of the mesh size and of the distance.
      const double error = std::abs(found.distance - truth) / (size + truth);
      const double consistency = std::abs((p - found.point).norm() - found.distance) / (size + truth);
      worst = std::max({worst, error, consistency});
      if (worst > 1e-12) {
        INFO(name << " query " << i << " at " << p.transpose() << ": " << found.distance << ", true " << truth);
        REQUIRE(worst <= 1e-12);
      }
    }
    std::printf("%-24s %8zu triangles  worst error %.1e of the size\n", name.c_str(), mesh.triangles.size(), worst);
    CHECK(worst <= 1e-12);
  }
}

TEST_CASE("the sign agrees with the winding number wherever a volume is enclosed", "[hard]") {
  for (const auto& [name, mesh, closed] : allMeshes()) {
    if (!closed) continue;
    INFO(name);
    CHECK(inspect(mesh).watertight);
    const MeshModel model(mesh);
    const double size = test::sizeOf(mesh);
    test::Random random(12);
    const int count = mesh.triangles.size() > 50000 ? test::count(100, 5000) : test::count(500, 20000);
    int inside = 0;
    for (int i = 0; i < count; ++i) {
      const Vec3 p = test::queryPoint(mesh, size, random);
      const SurfacePoint found = signedDistance(model, p);
      CHECK(std::abs(found.normal.norm() - 1.0) < 1e-9);  // unit length
      // On the surface the winding number jumps; its rounding error is about 1e-16 size / distance.
      if (std::abs(found.distance) < 1e-8 * size) continue;
      const double winding = test::windingNumber(mesh, p);
      inside += winding > 0.5;
      INFO("query " << i << " at " << p.transpose() << ": " << found.distance << ", winding number " << winding);
      REQUIRE((found.distance < 0.0) == (winding > 0.5));
      // Moving against the normal reaches the surface.
      CHECK((p - found.distance * found.normal - found.point).norm() <= 1e-12 * (size + std::abs(found.distance)));
    }
    CHECK(inside > count / 100);
  }
}

TEST_CASE("the same bits with and without a cache, and on every SIMD level", "[hard]") {
  const SimdLevel best = simdLevel();
  for (const auto& [name, mesh, closed] : allMeshes()) {
    INFO(name);
    const MeshModel model(mesh), other(test::boxMesh({1, 1, 1}));
    const double size = test::sizeOf(mesh);
    test::Random random(13);
    ProximityCache cache;
    Vec3 p = mesh.vertices[mesh.triangles[0][0]], velocity = Vec3::Zero();
    double speed = 1e-3;
    const int count = test::count(2000, 100000);
    for (int i = 0; i < count; ++i) {
      if (i % 300 == 0) speed = std::pow(10.0, random.uniform(-6.0, -0.5));
      if (i % 97 == 0) p = test::queryPoint(mesh, size, random);
      if (i % 401 == 0) closestPoint(other, p, &cache);  // a cache from another place
      velocity = 0.9 * velocity + 0.3 * speed * size * random.direction();
      p += velocity;
      const double limit = i % 5 == 0 ? size * std::pow(10.0, random.uniform(-4.0, 0.0)) : kNoLimit;
      const SurfacePoint plain = signedDistance(model, p, nullptr, limit);
      const SurfacePoint cached = signedDistance(model, p, &cache, limit);
      REQUIRE(plain.triangle == cached.triangle);
      REQUIRE(plain.feature == cached.feature);
      REQUIRE(plain.distance == cached.distance);
      REQUIRE(plain.point == cached.point);
      REQUIRE(plain.normal == cached.normal);
      for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512}) {
        if (useSimdLevel(level) != level) continue;
        const SurfacePoint here = signedDistance(model, p, i % 2 == 0 ? &cache : nullptr, limit);
        REQUIRE(plain.triangle == here.triangle);
        REQUIRE(plain.distance == here.distance);
        REQUIRE(plain.point == here.point);
        REQUIRE(plain.normal == here.normal);
      }
      useSimdLevel(best);
    }
  }
}

TEST_CASE("a tool that comes from far away misses nothing", "[hard]") {
  // Small, and away from the origin: lists of near triangles made at a large distance are coarse here.
  const Vec3 at(1, 2, 3);
  const std::vector<test::NamedMesh> meshes = {
      {"one triangle", {{at, at + Vec3(1e-3, 0, 0), at + Vec3(3e-4, 1e-3, 2e-4)}, {{0, 1, 2}}}},
      {"one point", {{at}, {{0, 0, 0}}}},
      {"ball", test::transformed(test::ball(2), 1e-3, at)}};
  for (const auto& [name, mesh, closed] : meshes) {
    const MeshModel model(mesh);
    test::Random random(15);
    ProximityCache cache;
    Vec3 p = at, velocity = Vec3::Zero();
    double speed = 0.0;
    for (int i = 0; i < test::count(60000, 1000000); ++i) {
      if (i % 300 == 0) speed = std::pow(10.0, random.uniform(-8.0, -2.0));
      if (i % 101 == 0 || i % 101 == 2) {
        const double away = random.power(-9.0, i % 101 == 2 ? -2.0 : i % 3 == 0 ? 150.0 : 3.0);
        p = at + away * random.direction();
      }
      velocity = 0.9 * velocity + 0.3 * speed * random.direction();
      p += velocity;
      const SurfacePoint plain = signedDistance(model, p), cached = signedDistance(model, p, &cache);
      INFO(name << " query " << i << " at " << p.transpose());
      REQUIRE(cached.triangle >= 0);
      REQUIRE(plain.triangle == cached.triangle);
      REQUIRE(plain.distance == cached.distance);
      REQUIRE(plain.point == cached.point);
    }
  }
}

TEST_CASE("a tool that jumped soon has its list of near triangles again", "[hard]") {
  const MeshModel model(test::ball(5));
  ProximityCache cache;
  const auto walk = [&](const Vec3& start, int ticks) {  // returns the number of queries that a list could answer
    int held = 0;
    for (int i = 0; i < ticks; ++i) {
      const Vec3 p = (start + 5e-4 * i * Vec3::UnitX()).normalized() * 1.02;
      (void)closestPoint(model, p, &cache);
      const kernel::Cache& content = *kernel::Inside::of(&cache);
      const kernel::NearList& list = content.near.list[content.near.active];
      const Vec3 origin(list.origin), now(content.query);
      held += (now - origin).norm() <= list.radius ? 1 : 0;
    }
    return held;
  };
  (void)walk(Vec3::UnitZ(), 200);
  REQUIRE(walk(Vec3(0.1, 0, 1), 200) > 180);
  for (int jump = 0; jump < 6; ++jump) (void)walk(Vec3(0, 0, jump % 2 == 0 ? -1 : 1), 1);
  (void)walk(Vec3::UnitY(), 200);
  CHECK(walk(Vec3(0.1, 1, 0), 200) > 180);
}

TEST_CASE("a limit hides what is farther and nothing else", "[hard]") {
  const MeshModel model(test::ball(4, 0.1));
  test::Random random(14);
  for (int i = 0; i < test::count(2000, 100000); ++i) {
    const Vec3 p = test::queryPoint(model.mesh(), test::sizeOf(model.mesh()), random);
    const SurfacePoint all = closestPoint(model, p);
    const double limit = all.distance * random.uniform(0.5, 1.5);
    const SurfacePoint found = closestPoint(model, p, nullptr, limit);
    REQUIRE((found.triangle >= 0) == (all.distance <= limit));
    if (found.triangle >= 0) REQUIRE(found.distance == all.distance);
    CHECK(closestPoint(model, p, nullptr, all.distance * (1.0 + 1e-15)).triangle == all.triangle);
  }
  const auto statusOf = [&](double x, double limit) { return closestPoint(model, {x, 0, 0}, nullptr, limit).status; };
  CHECK(statusOf(2.0, 0.0) == Status::ok);
  CHECK(statusOf(2.0, -1.0) == Status::outOfRange);
  CHECK(statusOf(2.0, std::nan("")) == Status::notFinite);
  CHECK(statusOf(std::nan(""), 1.0) == Status::notFinite);
}

TEST_CASE("after a jump a tool that moves on has a list of near triangles soon", "[hard]") {
  const MeshModel model(test::ball(5, 0.1));
  test::Random random(16);
  ProximityCache cache;
  int jumps = 0, without = 0;
  for (; jumps < 50; ++jumps) {
    const Vec3 start = 1.3 * random.direction(), step = 1e-4 * random.direction();
    for (int i = 0; i < 200; ++i) {
      (void)closestPoint(model, start + i * step, &cache);
      const kernel::Cache& known = *kernel::Inside::of(&cache);
      const kernel::NearList& list = known.near.list[known.near.active];
      double squared = 0.0;
      for (int k = 0; k < 3; ++k) squared += std::pow(known.query[k] - list.origin[k], 2);
      without += !(list.radius >= 0.0 && squared <= list.radius * list.radius);
    }
  }
  std::printf("without a list: %.1f queries after a jump\n", static_cast<double>(without) / jumps);
  CHECK(without < 100 * jumps);
}

}  // namespace enamel::test_proximity
