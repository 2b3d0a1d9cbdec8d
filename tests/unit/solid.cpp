// Solids that can be cut: distances compared with the exact mesh, volumes with Monte Carlo, and only cut material is
// lost.
#include "enamel/collision/solid.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "collision/mesh_data.hpp"
#include "collision/solid_patch.inl"
#include "collision/solid_query.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_solid {

namespace {

const std::vector<SolidLayer> kTooth = {{"enamel", {}, 3.4e9, 0.0, nullptr}, {"dentine", {}, 0.6e9, 1e-3, nullptr}};
constexpr double kCell = 1e-4;

double sum(const RemovedVolume& volume) { return std::accumulate(volume.begin(), volume.end(), 0.0); }

std::vector<BrickSamples> samplesOf(const Solid& solid) {
  std::vector<BrickSamples> all;
  for (int brick = 0; brick < solid.bricks(); ++brick) all.push_back(solid.samples(brick));
  return all;
}

Solid block(const Vec3& half) { return Solid(MeshModel(test::boxMesh(half)), kTooth, {kCell}); }

// Cut along a path in steps of a tick.
double cutAlong(Solid& solid, const Vec3& from, const Vec3& to, double radius, int steps) {
  double removed = sum(solid.cut({from, from}, {from, from}, radius));
  for (int i = 0; i < steps; ++i) {
    const Vec3 a = from + (to - from) * i / steps, b = from + (to - from) * (i + 1) / steps;
    removed += sum(solid.cut({a, a}, {b, b}, radius));
  }
  return removed;
}

}  // namespace

TEST_CASE("solid: distances against the exact mesh", "[solid]") {
  struct Case {
    std::string name;
    TriangleMesh mesh;
    double most;  // error of half the points, and of 999 in 1000, cells
    double mostOfAll;
    double cell;
  };
  // A ball of 3 mm: h^2 / (4 R) is 0.008 cells; normals and vertices of its triangles have this accuracy. The cells
  // round the molar's fissures and corners.
  const TriangleMesh molar = loadMesh(ENAMEL_SOURCE_DIR "/data/meshes/molar.ply", 1e-3);
  std::vector<Case> cases = {{"ball", test::transformed(test::ball(5), 3e-3, Vec3::Zero()), 0.01, 0.05, kCell},
                             {"molar", molar, 0.01, 0.2, kCell}};
  if (test::longRun()) {
    for (const double cell : {2e-4, 5e-5}) cases.push_back({"molar", molar, 0.01, 0.2, cell});
    for (const char* name : {"tooth36", "armadillo"})
      for (const double cell : {2e-4, kCell})
        if (const std::string folder = test::largeMeshFolder(); !folder.empty())
          cases.push_back({name, loadMesh(folder + "/" + name + ".ply", 1e-3), 0.02, 0.3, cell});
  }
  for (const Case& c : cases) {
    INFO(c.name << ", cells of " << 1e3 * c.cell << " mm");
    const MeshModel model(c.mesh);
    const MeshReport report = inspect(c.mesh);
    const Solid solid(model, kTooth, {c.cell});
    if (c.name == "molar" && c.cell == kCell) CHECK(solid.bytes() < 64000000);
    CHECK(sum(solid.volume()) == Approx(report.volume).epsilon(1e-3 * c.cell / kCell));
    test::Random random(2201);
    const int points = test::count(20000, 1000000);
    const double count = report.triangles;
    std::vector<double> errors;
    int wrong = 0, missed = 0, turned = 0;
    for (int i = 0; i < points; ++i) {
      const auto& t = c.mesh.triangles[static_cast<std::size_t>(random.uniform(0.0, count))];
      double u = random.uniform(0.0, 1.0), v = random.uniform(0.0, 1.0);
      if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
      const Vec3 corner = c.mesh.vertices[t[0]];
      const Vec3 on = corner + u * (c.mesh.vertices[t[1]] - corner) + v * (c.mesh.vertices[t[2]] - corner);
      const Vec3 p = on + random.ofLength(0.0, 5.0 * c.cell);
      const SurfacePoint exact = signedDistance(model, p);
      const SolidPoint found = signedDistance(solid, p);
      missed += !found.found;
      wrong += (found.distance < 0.0) != (exact.distance < 0.0) && std::abs(exact.distance) > 0.5 * c.cell;
      errors.push_back(std::abs(found.distance - exact.distance) / c.cell);
      turned += std::abs(exact.distance) > c.cell && found.normal.dot(exact.normal) < std::cos(0.3);
    }
    std::sort(errors.begin(), errors.end());
    if (test::longRun())
      std::printf(
          "%-10s cells of %.2f mm, %5.1f MB: off by %.4f (median), %.4f (99 %%), %.4f (99.9 %%), %.4f cells at "
          "most; %d on the wrong side, normal off by 0.3 rad for %d of %d\n",
          c.name.c_str(), 1e3 * c.cell, 1e-6 * static_cast<double>(solid.bytes()), errors[errors.size() / 2],
          errors[errors.size() * 99 / 100], errors[errors.size() * 999 / 1000], errors.back(), wrong, turned, points);
    CHECK(missed == 0);
    CHECK(wrong == 0);
    CHECK(turned < points / 50);
    CHECK(errors[errors.size() / 2] < c.most);
    CHECK(errors[errors.size() * 999 / 1000] < c.mostOfAll);
  }
}

TEST_CASE("solid: nearest to a segment is nearest to one of its points", "[solid]") {
  const Solid solid(MeshModel(test::transformed(test::ball(4, 0.1), 3e-3, Vec3::Zero())), kTooth, {kCell});
  test::Random random(2202);
  SolidCache anywhere;  // of the last segment, which was elsewhere
  for (int i = 0; i < test::count(200, 5000); ++i) {
    const Segment segment{random.ofLength(3.5e-3, 6e-3), random.ofLength(3.5e-3, 6e-3)};
    double least = kNoLimit;
    bool crosses = false;
    for (int k = 0; k <= 100; ++k) {
      const Vec3 p = segment.a + 0.01 * k * (segment.b - segment.a);
      least = std::min(least, std::abs(signedDistance(solid, p).distance));
      crosses = crosses || isInside(solid, p);
    }
    if (crosses) continue;
    const SolidPoint found = closestToSegment(solid, segment);
    const double step = 0.01 * (segment.b - segment.a).norm();
    REQUIRE(found.found);
    CHECK(found.distance <= least + 0.02 * kCell);
    CHECK(found.distance >= least - step);
    const Vec3 there = segment.a + found.parameter * (segment.b - segment.a);
    CHECK((there - found.point).norm() == Approx(found.distance));
    CHECK_FALSE(closestToSegment(solid, segment, 0.9 * found.distance).found);
    const SolidPoint again = kernel::closestToSegment(solid, segment, kNoLimit, anywhere);
    CHECK(again.distance == Approx(found.distance).margin(0.02 * kCell));
  }
}

TEST_CASE("solid: cavity, groove and through-hole have the bur's volume, nothing else changes", "[solid]") {
  const Vec3 half(3e-3, 2e-3, 1.5e-3);
  const double radius = 0.5e-3, pi = 3.14159265358979323846;
  struct Case {
    const char* name;
    Vec3 from, to;
  };
  const Case cases[] = {{"cavity", Vec3(0.31e-3, 0.12e-3, -0.2e-3), Vec3(0.31e-3, 0.12e-3, -0.2e-3)},
                        {"groove", Vec3(-2.1e-3, 0.21e-3, 1.4e-3), Vec3(1.9e-3, 0.73e-3, 1.3e-3)},
                        {"hole", Vec3(0.13e-3, 0.17e-3, 2.5e-3), Vec3(-0.4e-3, 0.3e-3, -2.5e-3)}};
  for (const Case& c : cases) {
    INFO(c.name);
    Solid solid = block(half);
    const std::vector<BrickSamples> before = samplesOf(solid);
    const double whole = sum(solid.volume());
    CHECK(whole == Approx(8.0 * half.prod()).epsilon(1e-3));
    const double estimate = cutAlong(solid, c.from, c.to, radius, 100), removed = whole - sum(solid.volume());
    CHECK(estimate == Approx(removed).epsilon(kCell * kCell / (radius * radius)));

    // Monte Carlo in the box of the sweep, 0.2 % (one sigma).
    const Vec3 low = c.from.cwiseMin(c.to) - Vec3::Constant(radius),
               high = c.from.cwiseMax(c.to) + Vec3::Constant(radius);
    test::Random random(2203);
    const int points = 600000;
    int within = 0;
    for (int i = 0; i < points; ++i) {
      const Vec3 p =
          low +
          (high - low).cwiseProduct(Vec3{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0), random.uniform(0.0, 1.0)});
      if ((p.cwiseAbs() - half).maxCoeff() > 0.0) continue;
      const Vec3 span = c.to - c.from;
      const double t =
          span.squaredNorm() > 0.0 ? std::clamp((p - c.from).dot(span) / span.squaredNorm(), 0.0, 1.0) : 0.0;
      within += (p - c.from - t * span).norm() < radius;
    }
    CHECK(removed == Approx((high - low).prod() * within / points).epsilon(0.01));
    if (c.from == c.to) CHECK(removed == Approx(4.0 / 3.0 * pi * radius * radius * radius).epsilon(0.01));

    const Vec3 span = c.to - c.from;
    const double reach = radius + kCell * kCell / (12.0 * radius) + 1e-9;
    int outside = 0, told = 0, untold = 0;
    std::vector<char> isTold(static_cast<std::size_t>(solid.bricks()));
    for (int brick = solid.takeChanged(); brick >= 0; brick = solid.takeChanged()) isTold[brick] = 1;
    for (int brick = 0; brick < solid.bricks(); ++brick) {
      const BrickSamples& now = solid.samples(brick);
      const bool isSame = now == before[static_cast<std::size_t>(brick)];
      told += isTold[brick] != 0 && isSame;
      untold += isTold[brick] == 0 && !isSame;
      for (int i = 0; i < static_cast<int>(now.size()); ++i) {
        if ((now[i] < 0.0f) == (before[brick][i] < 0.0f)) continue;
        const Vec3 p = solid.lowOf(brick) + kCell * Vec3(i % kBrickSamples, i / kBrickSamples % kBrickSamples,
                                                         i / (kBrickSamples * kBrickSamples));
        const double t =
            span.squaredNorm() > 0.0 ? std::clamp((p - c.from).dot(span) / span.squaredNorm(), 0.0, 1.0) : 0.0;
        outside += (p - c.from - t * span).norm() > reach || now[i] < 0.0f;
      }
    }
    CHECK(outside == 0);
    CHECK(told == 0);
    CHECK(untold == 0);
  }
}

TEST_CASE("solid: a bur fits into what it has cut", "[solid]") {
  Solid solid = block(Vec3(3e-3, 2e-3, 1.5e-3));
  const double radius = 0.5e-3;
  Scene scene;
  const Vec3 from(-1e-3, 0.0, 1.7e-3), to(1e-3, 0.3e-3, 1.6e-3);
  cutAlong(solid, from, to, radius, 50);
  scene.add({"block", std::make_shared<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  Tool bur;
  bur.parts[0].radius = radius;
  for (double t = 0.1; t < 0.95; t += 0.05) {
    Pose pose;
    pose.position = from + t * (to - from);
    ContactSnapshot contacts;
    REQUIRE(findContacts(scene, bur, pose, 1e-3, nullptr, contacts) == Status::ok);
    REQUIRE(contacts.count > 0);
    CHECK(std::abs(contacts.contacts[0].gap) < 6e-6);  // h^2 / (4 R): 5 um
    pose.position.z() += 0.05e-3;                      // lifted, it touches the walls no more than before
    REQUIRE(findContacts(scene, bur, pose, 1e-3, nullptr, contacts) == Status::ok);
    CHECK(contacts.contacts[0].gap > -6e-6);
    pose.position.z() -= 0.10e-3;  // deeper than before
    REQUIRE(findContacts(scene, bur, pose, 1e-3, nullptr, contacts) == Status::ok);
    CHECK(contacts.contacts[0].gap == Approx(-0.05e-3).margin(6e-6));
    CHECK(contacts.contacts[0].normal.z() > 0.98);
  }
}

namespace {

// The nearest place of each cell with surface within `reach` of p, found one by one. Lengths are in cells.
struct CellPlace {
  double distance;
  Vec3 direction;  // to p
  bool isMinimum;  // along the normal
};
std::vector<CellPlace> placesOf(const Solid& solid, const Vec3& p, double reach) {
  std::vector<CellPlace> places;
  for (int brick = 0; brick < solid.bricks(); ++brick) {
    const Vec3 inBrick = (p - solid.lowOf(brick)) / solid.cell();
    if ((inBrick - inBrick.cwiseMax(0.0).cwiseMin(kBrickCells)).norm() > reach) continue;
    const BrickSamples& samples = solid.samples(brick);
    const std::array<std::uint64_t, kBrickCells> surface = kernel::surfaceCells(samples);
    for (int z = 0; z < kBrickCells; ++z)
      for (int y = 0; y < kBrickCells; ++y)
        for (int x = 0; x < kBrickCells; ++x) {
          kernel::Touch touch;
          const Vec3 q = inBrick - Vec3(x, y, z);
          if ((surface[z] >> (kBrickCells * y + x) & 1) == 0 ||
              !kernel::nearestOn(kernel::Patch(samples.data() + z * kernel::kUp + y * kernel::kBack + x), q, touch))
            continue;
          const Vec3 way = q - touch.point;
          places.push_back({way.norm(), way.normalized(),
                            way.cross(touch.gradient.normalized()).norm() < 0.2 && way.dot(touch.gradient) > 0.0});
        }
  }
  return places;
}

}  // namespace

// A ball of 5 cells is pushed into the block and cuts it, in steps of 0.3 cells or less.
TEST_CASE("solid: the minima in a freshly cut pit against all cells, one by one", "[solid]") {
  test::Random random(2204);
  const double radius = 0.5e-3, reach = radius + 2e-4;
  const SimdLevel best = simdLevel();
  int uncovered = 0, minima = 0;
  for (int pit = 0; pit < test::count(3, 30); ++pit) {
    Solid solid = block(Vec3(3e-3, 2e-3, 1.5e-3));
    Vec3 at(random.uniform(-2e-3, 2e-3), random.uniform(-1e-3, 1e-3), 1.9e-3);
    Vec3 way = (Vec3(0.0, 0.0, -1.0) + 0.5 * random.direction()).normalized();
    for (int tick = 0; tick < 30; ++tick) {
      const Vec3 next = at + random.uniform(0.1e-6, 30e-6) * way;
      way = (way + 0.1 * random.direction()).normalized();
      (void)solid.cut({at, at}, {next, next}, radius);
      at = next;
      const Vec3 p = at + random.uniform(0.0, 20e-6) * random.direction();
      if (isInside(solid, p)) continue;
      kernel::SolidMinima found, other;
      for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512}) {
        if (useSimdLevel(level) != level) continue;
        kernel::findMinima(solid, p, reach, other);
        if (level == SimdLevel::baseline) found = other;
        REQUIRE(other.count == found.count);
        for (int i = 0; i < found.count; ++i) {
          CHECK(other.all[i].distance == found.all[i].distance);
          CHECK(other.all[i].point == found.all[i].point);
          CHECK(other.all[i].normal == found.all[i].normal);
        }
      }
      useSimdLevel(best);
      const std::vector<CellPlace> places = placesOf(solid, p, reach / kCell);
      double nearest = reach / kCell;
      for (const CellPlace& place : places) nearest = std::min(nearest, place.distance);
      REQUIRE(found.count > 0);
      // A place in a cell is found to a thousandth of a cell.
      CHECK(found.all[0].distance / kCell == Approx(nearest).margin(2e-3));
      // Each minimum is one of those found, or within 30 deg of one that is not farther.
      for (const CellPlace& place : places) {
        if (!place.isMinimum || place.distance > reach / kCell) continue;
        if (found.count == kernel::kMaxSolidMinima &&
            place.distance > found.all[found.count - 1].distance / kCell - 5e-3)
          continue;
        ++minima;
        const bool isCovered = std::any_of(found.all.begin(), found.all.begin() + found.count, [&](const auto& one) {
          return (p - one.point).normalized().dot(place.direction) > std::cos(31.0 / 180.0 * M_PI) &&
                 one.distance / kCell < place.distance + 5e-3;
        });
        uncovered += !isCovered;
      }
    }
  }
  CHECK(minima > 1000);
  CHECK(uncovered < minima / 50);  // a minimum between them was replaced by a nearer one
}

// A point walks and jumps around the block while a ball cuts it.
TEST_CASE("solid: a cache does not change the nearest place, which is that of all cells", "[solid]") {
  test::Random random(2206);
  Solid solid = block(Vec3(3e-3, 2e-3, 1.5e-3));
  const SimdLevel best = simdLevel();
  SolidCache cache;
  Vec3 p(0.0, 0.0, 1.7e-3), bur(0.0, 0.0, 1.9e-3);
  for (int tick = 0; tick < test::count(2000, 50000); ++tick) {
    p += 50e-6 * random.direction();
    if (tick % 50 == 0) p = 4e-3 * random.direction();
    const Vec3 next = bur + 30e-6 * random.direction() - 1e-6 * bur.cwiseSign();
    if (tick % 2 == 0) (void)solid.cut({bur, bur}, {next, next}, 0.4e-3);
    bur = next;
    const double limit = tick % 5 == 0 ? 2e-3 : kNoLimit;
    const SolidPoint found = signedDistance(solid, p, limit);
    for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512}) {
      if (useSimdLevel(level) != level) continue;
      SolidCache same = cache;
      const SolidPoint other = signedDistance(solid, p, limit, &same);
      REQUIRE(other.found == found.found);
      REQUIRE(other.distance == found.distance);
      REQUIRE(other.point == found.point);
      REQUIRE(other.normal == found.normal);
      if (level == best) cache = same;
    }
    useSimdLevel(best);
    if (tick % 10 != 0) continue;
    double nearest = limit / kCell;
    for (const CellPlace& place : placesOf(solid, p, std::min(limit / kCell, 100.0)))
      nearest = std::min(nearest, place.distance);
    REQUIRE(found.found == (nearest < limit / kCell));
    // A place in a cell is found to a thousandth of a cell.
    if (found.found) CHECK(std::abs(found.distance) / kCell == Approx(nearest).margin(2e-3));
  }
}

TEST_CASE("solid: outside of a ball the distance has one minimum, at every distance", "[solid]") {
  const Solid solid(MeshModel(test::transformed(test::ball(5), 3e-3, Vec3::Zero())), kTooth, {kCell});
  test::Random random(2205);
  for (int i = 0; i < test::count(2000, 50000); ++i) {
    const double distance = kCell * random.uniform(0.05, 6.0);
    const Vec3 p = (3e-3 + distance) * random.direction();
    kernel::SolidMinima minima;
    kernel::findMinima(solid, p, 7.0 * kCell, minima);
    REQUIRE(minima.count == 1);
    CHECK(minima.all[0].distance == Approx(distance).margin(0.05 * kCell));  // as above
  }
}

TEST_CASE("solid: layers, their contacts' material, undo and restore", "[solid]") {
  std::vector<SolidLayer> layers = kTooth;
  layers[0].material.stiffness = 1e6;
  layers[1].material.stiffness = 2e5;
  const MeshModel box(test::boxMesh(Vec3(3e-3, 2e-3, 1.5e-3)));
  layers.push_back(
      {"pulp",
       {},
       1e6,
       0.0,
       std::make_shared<const MeshModel>(test::transformed(test::ball(3), 0.5e-3, Vec3(-1.5e-3, 0.0, 0.0)))});
  Solid solid(box, layers, {kCell, 40});
  CHECK(solid.layerAt(Vec3(0.0, 0.0, 1.2e-3)) == 0);
  CHECK(solid.layerAt(Vec3(1e-3, 0.0, 0.2e-3)) == 1);
  CHECK(solid.layerAt(Vec3(-1.4e-3, 0.0, 0.1e-3)) == 2);
  CHECK(solid.volume()[2] == Approx(4.18879 * 0.125e-9).epsilon(0.1));

  const std::vector<BrickSamples> whole = samplesOf(solid);
  const RemovedVolume before = solid.volume();
  solid.mark();
  cutAlong(solid, Vec3(0, 0, 2e-3), Vec3(0, 0, 1.2e-3), 0.5e-3, 10);
  const std::vector<BrickSamples> first = samplesOf(solid);
  const std::uint64_t restorations = solid.restorations();
  solid.mark();
  cutAlong(solid, Vec3(0, 0, 1.2e-3), Vec3(0.3e-3, 0, 0.6e-3), 0.5e-3, 10);
  CHECK(samplesOf(solid) != first);
  CHECK(signedDistance(solid, Vec3(0.3e-3, 0, 0.2e-3)).layer == 1);
  REQUIRE(solid.undo());
  CHECK(samplesOf(solid) == first);
  REQUIRE(solid.undo());
  CHECK(samplesOf(solid) == whole);
  CHECK(solid.restorations() > restorations);
  for (int k = 0; k < 3; ++k) CHECK(solid.volume()[k] == Approx(before[k]).epsilon(1e-9));
  CHECK_FALSE(solid.undo());

  // A stroke that needs more room than available cannot be undone; later ones can.
  solid.mark();
  cutAlong(solid, Vec3(-3e-3, -2e-3, 1.4e-3), Vec3(3e-3, 2e-3, -1.4e-3), 0.5e-3, 100);
  solid.mark();
  const std::vector<BrickSamples> long1 = samplesOf(solid);
  solid.cut({Vec3(2e-3, -1e-3, 1.5e-3), Vec3(2e-3, -1e-3, 1.5e-3)},
            {Vec3(2e-3, -1e-3, 1.5e-3), Vec3(2e-3, -1e-3, 1.5e-3)}, 0.3e-3);
  REQUIRE(solid.undo());
  CHECK(samplesOf(solid) == long1);
  CHECK_FALSE(solid.undo());
  solid.restore();
  CHECK(samplesOf(solid) == whole);
  CHECK(solid.volume() == before);

  // Contacts have the material of their layer.
  cutAlong(solid, Vec3(0, 0, 2e-3), Vec3(0, 0, 0.9e-3), 0.5e-3, 10);  // 1.1 mm deep
  Scene scene;
  scene.add({"tooth", std::make_shared<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  Tool bur;
  bur.parts[0].radius = 0.4e-3;
  ContactSnapshot contacts;
  Pose pose;
  pose.position = Vec3(0.0, 0.0, 0.8e-3);
  REQUIRE(findContacts(scene, bur, pose, 1e-3, nullptr, contacts) == Status::ok);
  CHECK(contacts.contacts[0].material.stiffness == 2e5);
  pose.position = Vec3(1.5e-3, 0.0, 1.9e-3);
  REQUIRE(findContacts(scene, bur, pose, 1e-3, nullptr, contacts) == Status::ok);
  CHECK(contacts.contacts[0].material.stiffness == 1e6);
}

TEST_CASE("solid: cells of volume / area keep a part of every convex body", "[solid]") {
  test::Random random(5);
  for (int i = 0; i < 50; ++i) {
    const Vec3 half(random.uniform(0.2e-3, 3e-3), random.uniform(0.2e-3, 3e-3), random.uniform(0.2e-3, 3e-3));
    TriangleMesh mesh = test::boxMesh(half);
    const Mat3 turn = random.rotation(3.0);
    for (Vec3& vertex : mesh.vertices) vertex = turn * vertex;
    const MeshReport body = inspect(mesh);
    CAPTURE(i);
    CHECK(sum(Solid(MeshModel(mesh), kTooth, {body.volume / body.area}).volume()) > 0.0);
  }
}

TEST_CASE("solid: what is refused, what finds nothing", "[solid]") {
  const MeshModel box(test::boxMesh(Vec3(3e-3, 2e-3, 1.5e-3)));
  TriangleMesh open = test::boxMesh(Vec3(3e-3, 2e-3, 1.5e-3));
  open.triangles.pop_back();
  const auto build = [](const MeshModel& mesh, const std::vector<SolidLayer>& layers, SolidOptions options = {}) {
    return Solid(mesh, layers, options);
  };
  CHECK_THROWS_WITH(build(MeshModel(open), kTooth), test::ContainsSubstring("the mesh of a solid must be closed"));
  CHECK_THROWS_WITH(build(box, {}), test::ContainsSubstring("the solid has 0 layers, must have 1 to 8"));
  CHECK_THROWS_WITH(build(box, {{"soft", {}, 0.0, 0.0, nullptr}}), test::ContainsSubstring("hardness"));
  CHECK_THROWS_WITH(build(box, {{"a", {}, 1e9, 1e-3, nullptr}, {"b", {}, 1e9, 0.5e-3, nullptr}}),
                    test::ContainsSubstring("depth"));
  CHECK_THROWS_WITH(build(box, {{"a", {}, 1e9, 0.0, std::make_shared<const MeshModel>(open)}}),
                    test::ContainsSubstring("closed"));
  CHECK_THROWS_WITH(build(box, kTooth, {0.0}), test::ContainsSubstring("cell"));
  CHECK_THROWS_WITH(build(box, kTooth, {1e-7}), test::ContainsSubstring("1 GB"));
  CHECK_THROWS_WITH(build(MeshModel(test::boxMesh(Vec3::Constant(3e-6))), kTooth, {0.9e-6}),
                    test::ContainsSubstring("at least 1e-06 m"));
  CHECK_THROWS_WITH(build(box, kTooth, {1e-4, -1}), test::ContainsSubstring("undo"));
  CHECK_THROWS_WITH(build(box, kTooth, {7e-3}),
                    "cells of 7.000000 mm are too large: no corner of a cell is inside, so nothing of the body would "
                    "remain; make them at most 0.666667 mm, its volume / area, or check the unit of the mesh");

  Solid solid = block(Vec3(1e-3, 1e-3, 1e-3));
  const std::vector<BrickSamples> whole = samplesOf(solid);
  const double bad = std::nan("");
  const Vec3 zero = Vec3::Zero(), nowhere(bad, 0.0, 0.0);
  CHECK_FALSE(signedDistance(solid, nowhere).found);
  CHECK_FALSE(signedDistance(solid, zero, -1.0).found);
  CHECK_FALSE(closestToSegment(solid, {zero, nowhere}).found);
  CHECK_FALSE(isInside(solid, nowhere));
  CHECK_FALSE(isInside(solid, Vec3(1.0, 1.0, 1.0)));
  CHECK(signedDistance(solid, Vec3(0.0, 0.0, 10.0)).distance == Approx(9.999));
  CHECK(sum(solid.cut({zero, zero}, {nowhere, zero}, 1e-3)) == 0.0);
  CHECK(sum(solid.cut({zero, zero}, {zero, zero}, bad)) == 0.0);
  CHECK(sum(solid.cut({zero, zero}, {zero, Vec3(0, 0, 0.1)}, 1e-3)) == 0.0);
  CHECK(sum(solid.cut({Vec3(9, 9, 9), Vec3(9, 9, 9)}, {Vec3(9, 9, 9), Vec3(9, 9, 9)}, 1e-3)) == 0.0);
  CHECK(samplesOf(solid) == whole);
  // All of it can be removed.
  for (double x = -1e-3; x <= 1.01e-3; x += 0.5e-3)
    for (double y = -1e-3; y <= 1.01e-3; y += 0.5e-3) cutAlong(solid, Vec3(x, y, -1e-3), Vec3(x, y, 1e-3), 0.5e-3, 40);
  CHECK(sum(solid.volume()) == Approx(0.0).margin(1e-15));
  CHECK_FALSE(signedDistance(solid, zero).found);
  CHECK_FALSE(isInside(solid, zero));
}

}  // namespace enamel::test_solid
