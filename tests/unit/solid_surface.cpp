// The surface of a solid as triangles: closed, at the samples' zero, after any cut; neighbouring bricks match.
#include "enamel/collision/solid_surface.hpp"

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <numeric>

#include "enamel/collision/mesh_file.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_solid_surface {

namespace {

constexpr double kCell = 1e-4;
const std::vector<SolidLayer> kTooth = {{"enamel", {}, 3.4e9, 0.0, nullptr}, {"dentine", {}, 0.6e9, 1e-3, nullptr}};

// Check the distance of mesh points from the surface that queries find, in cells: vertices and, at sharp edges, the
// centres of triangles.
void check(const Solid& solid, double accuracy) {
  const TriangleMesh mesh = surfaceOf(solid);
  const MeshReport report = inspect(mesh);
  CHECK(report.watertight);
  CHECK_FALSE(report.inwards);
  CHECK(report.nonManifoldEdges + report.nonManifoldVertices + report.flippedEdges == 0);
  CHECK(report.degenerateTriangles + report.duplicateTriangles == 0);
  CHECK(report.places == report.vertices);
  const RemovedVolume volume = solid.volume();
  CHECK(report.volume == Approx(std::accumulate(volume.begin(), volume.end(), 0.0)).epsilon(accuracy));
  double most = 0.0, mostBetween = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 1 + mesh.triangles.size() / 10000) {
    const auto& t = mesh.triangles[i];
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    most = std::max(most, std::abs(signedDistance(solid, a).distance) / kCell);
    mostBetween = std::max(mostBetween, std::abs(signedDistance(solid, (a + b + c) / 3.0).distance) / kCell);
  }
  CHECK(most < 0.02);
  INFO(mostBetween);
  CHECK(mostBetween < 0.5);
}

void cutAnyhow(Solid& solid, const Vec3& half, int cuts) {
  test::Random random(2220);
  for (int i = 0; i < cuts; ++i) {
    const Vec3 a = half.cwiseProduct(random.vector(1.0)), b = a + random.vector(5e-4), c = a + random.vector(2e-4);
    solid.cut({a, b}, {c, b}, random.uniform(0.3, 6.0) * kCell);
  }
}

}  // namespace

TEST_CASE("the surface of a solid is closed and where the samples are zero", "[unit]") {
  // A ball; a box with a side exactly at samples; the same after cutting all but crumbs.
  check(Solid(MeshModel(test::transformed(test::ball(4, 0.1), 2e-3, Vec3::Zero())), kTooth, {kCell}), 5e-3);
  const Vec3 half(1.025e-3, 0.8e-3, 0.6125e-3);
  Solid solid(MeshModel(test::boxMesh(half)), kTooth, {kCell});
  check(solid, 5e-3);
  for (const int cuts : {3, 30}) {
    INFO(cuts << " cuts");
    cutAnyhow(solid, half, cuts);
    check(solid, cuts < 10 ? 5e-3 : 0.05);  // volume() is less accurate for crumbs of a few cells
  }
  solid.cut({Vec3::Zero(), Vec3::Zero()}, {Vec3::Zero(), Vec3::Zero()}, 3e-3);
  CHECK(surfaceOf(solid).triangles.empty());
}

TEST_CASE("bricks of a surface fit to each other, normals point outwards", "[unit]") {
  const double radius = 1.5e-3;
  Solid solid(MeshModel(test::transformed(test::ball(5), radius, Vec3::Zero())), kTooth, {kCell});
  solid.cut({Vec3(0, 0, radius), Vec3(0, 0, radius)}, {Vec3(0, 0, radius), Vec3(0, 0, radius)}, 1e-3);
  SolidSurface all, one;
  std::size_t triangles = 0;
  int outside = 0;
  for (int brick = 0; brick < solid.bricks(); ++brick) {
    one.clear();
    appendSurface(solid, brick, solid.samples(brick), one);
    appendSurface(solid, brick, solid.samples(brick), all);
    triangles += one.mesh.triangles.size();
    for (const Vec3& v : one.mesh.vertices)
      outside +=
          ((v - solid.lowOf(brick)) / (kBrickCells * kCell) - Vec3::Constant(0.5)).cwiseAbs().maxCoeff() > 0.50001;
  }
  CHECK(outside == 0);
  CHECK(all.mesh.triangles.size() == triangles);
  CHECK(surfaceOf(solid).triangles.size() == triangles);
  CHECK(all.normals.size() == all.mesh.vertices.size());
  double worst = 0.0;
  int inwards = 0, misplaced = 0;
  for (std::size_t i = 0; i < all.normals.size(); ++i) {
    const Vec3& p = all.mesh.vertices[i];
    const Vec3 fromBur = p - Vec3(0, 0, radius);
    if (std::abs(fromBur.norm() - 1e-3) < 4.0 * kCell && std::abs(p.norm() - radius) < 4.0 * kCell) continue;  // rim
    const Vec3 exact = fromBur.norm() < 1.1e-3 ? Vec3(-fromBur.normalized()) : Vec3(p.normalized());
    worst = std::max(worst, all.normals[i].cross(exact).norm());
    inwards += all.normals[i].dot(exact) < 0.0;
    const double below = (p - 0.5 * kCell * exact).norm() - (radius - 1e-3);
    misplaced += std::abs(below) > kCell && all.layers[i] != (below < 0.0 ? 1 : 0);
  }
  // Every second sample: a quarter of the triangles, on the same surface.
  SolidSurface coarse;
  for (int brick = 0; brick < solid.bricks(); ++brick) appendSurface(solid, brick, solid.samples(brick), coarse, 2);
  CHECK(static_cast<double>(coarse.mesh.triangles.size()) / static_cast<double>(triangles) ==
        Approx(0.25).margin(0.03));
  double off = 0.0;
  for (const Vec3& p : coarse.mesh.vertices)
    if (p.z() < 0.0) off = std::max(off, std::abs(p.norm() - radius));  // where nothing is cut
  CHECK(off < 0.25 * kCell);
  CHECK(worst < 0.07);
  CHECK(inwards == 0);
  CHECK(misplaced == 0);
}

TEST_CASE("bricks of different steps fit to each other", "[unit]") {
  const Vec3 half(1.6e-3, 1.3e-3, 0.9e-3);
  for (const bool isCut : {false, true}) {
    INFO((isCut ? "box, cut anyhow" : "ball"));
    Solid solid(
        MeshModel(isCut ? test::boxMesh(half) : test::transformed(test::ball(4, 0.1), 1.5e-3, Vec3(1e-5, 2e-5, 3e-5))),
        kTooth, {kCell});
    if (isCut) cutAnyhow(solid, half, 10);
    const double edge = kBrickCells * kCell;
    test::Random random(2221);
    for (int round = 0; round < 10; ++round) {
      const double share = random.uniform(0.1, 0.9);
      std::map<std::array<int, 3>, int> steps;
      const auto placeOf = [&](int brick) {
        const Eigen::Vector3i at = ((solid.lowOf(brick) - solid.low()) / edge).array().round().cast<int>();
        return std::array<int, 3>{at[0], at[1], at[2]};
      };
      for (int brick = 0; brick < solid.bricks(); ++brick)
        steps[placeOf(brick)] = random.uniform(0.0, 1.0) < share ? 1 : 2;
      SolidSurface all;
      for (int brick = 0; brick < solid.bricks(); ++brick) {
        const std::array<int, 3> at = placeOf(brick);
        std::uint32_t coarser = 0;
        for (int i = 0; i < 27; ++i) {
          const auto other = steps.find({at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1});
          if (other != steps.end() && other->second > steps[at]) coarser |= 1u << i;
        }
        appendSurface(solid, brick, solid.samples(brick), all, steps[at], coarser);
      }
      const std::vector<int> place = weld(all.mesh);
      for (auto& triangle : all.mesh.triangles)
        for (int& v : triangle) v = place[static_cast<std::size_t>(v)];
      CHECK(inspect(all.mesh).watertight);
    }
  }
}

}  // namespace enamel::test_solid_surface
