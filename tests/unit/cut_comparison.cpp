// A cut solid against a target: balls cut out of a block against their formulas, and properties of random cuts.
#include "enamel/collision/cut_comparison.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "enamel/collision/solid_surface.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_cut_comparison {

namespace {

const std::vector<SolidLayer> kTooth = {{"enamel", {}, 3.4e9, 0.0, nullptr}, {"dentine", {}, 0.6e9, 0.4e-3, nullptr}};
const Vec3 kHalf(1.6e-3, 1.5e-3, 1.4e-3);
constexpr double kPi = 3.14159265358979323846;

double sum(const RemovedVolume& volume) { return std::accumulate(volume.begin(), volume.end(), 0.0); }

Segment at(const Vec3& p) { return {p, p}; }

Solid block(double cell, const Vec3& shift = Vec3::Zero()) {
  return Solid(MeshModel(test::transformed(test::boxMesh(kHalf), 1.0, shift)), kTooth, {cell});
}

// The block with a cavity: a ball whose triangles point inwards, with the volume of a true ball.
MeshModel cavity(const Vec3& centre, double radius) {
  TriangleMesh ball = test::ball(5);
  const double scale = radius * std::cbrt(4.0 / 3.0 * kPi / inspect(ball).volume);
  ball = test::transformed(ball, scale, centre);
  for (auto& t : ball.triangles) std::swap(t[1], t[2]);
  return MeshModel(test::joined(test::boxMesh(kHalf), ball));
}

double ballVolume(double radius) { return 4.0 / 3.0 * kPi * radius * radius * radius; }

// Volume that two balls of equal radius share at a distance d.
double lens(double radius, double d) {
  return kPi / 12.0 * (4.0 * radius + d) * (2.0 * radius - d) * (2.0 * radius - d);
}

void cutAnyhow(Solid& solid, std::uint64_t seed, const Vec3& shift = Vec3::Zero()) {
  test::Random random(seed);
  for (int i = 0; i < 6; ++i) {
    const Vec3 a = shift + kHalf.cwiseProduct(random.vector(1.0)), b = a + random.vector(1e-3);
    solid.cut({a, b}, {a + random.vector(2e-4), b}, random.uniform(2e-4, 6e-4));
  }
}

void checkSums(const CutComparison& c) {
  for (std::size_t k = 0; k < kMaxSolidLayers; ++k) {
    CHECK(c.planned[k] - c.removed[k] == Approx(c.whole.underCut[k] - c.whole.overCut[k]).margin(1e-18));
    CHECK(c.floors.overCut[k] + c.walls.overCut[k] == c.whole.overCut[k]);
    CHECK(c.floors.underCut[k] + c.walls.underCut[k] == c.whole.underCut[k]);
  }
  CHECK(c.floors.area + c.walls.area == Approx(c.whole.area));
  CHECK(c.floors.area * c.floors.mean + c.walls.area * c.walls.mean == Approx(c.whole.area * c.whole.mean));
  CHECK(std::max(c.floors.deepest, c.walls.deepest) == c.whole.deepest);
  CHECK(std::max(c.floors.highest, c.walls.highest) == c.whole.highest);
}

}  // namespace

TEST_CASE("cut comparison: a ball cut out of a block, against a larger, a smaller and a moved ball", "[unit]") {
  // Errors: surfaces apart by h^2 / (4 R) at most, times the area of the ball.
  const Vec3 centre(0.11e-3, -0.07e-3, 0.05e-3);
  const double radius = 0.8e-3, more = 0.9e-3, away = 0.3e-3;
  std::vector<std::array<double, 3>> errors;
  for (const double cell : {0.1e-3, 0.05e-3}) {
    INFO("cells of " << 1e3 * cell << " mm");
    Solid solid = block(cell);
    solid.cut(at(centre), at(centre), radius);
    const double off = cell * cell / (4.0 * radius), tolerance = off * 4.0 * kPi * more * more;

    const CutComparison same = compareCut(solid, cavity(centre, radius));
    CHECK(sum(same.whole.overCut) < tolerance);
    CHECK(sum(same.whole.underCut) < tolerance);
    CHECK(same.whole.highest < 2.0 * off);
    CHECK(same.whole.deepest < 2.0 * off);
    CHECK(same.whole.area == Approx(4.0 * kPi * radius * radius).epsilon(0.01));

    const CutComparison small = compareCut(solid, cavity(centre, more));
    CHECK(sum(small.whole.underCut) == Approx(ballVolume(more) - ballVolume(radius)).margin(tolerance));
    CHECK(sum(small.whole.overCut) == 0.0);
    CHECK(small.whole.mean == Approx(more - radius).margin(2.0 * off));
    CHECK(small.whole.p95 == Approx(more - radius).margin(2.0 * off));
    CHECK(small.whole.highest == Approx(more - radius).margin(2.0 * off));
    CHECK(small.whole.deepest == 0.0);

    const CutComparison large = compareCut(solid, cavity(centre, 0.7e-3));
    CHECK(sum(large.whole.overCut) == Approx(ballVolume(radius) - ballVolume(0.7e-3)).margin(tolerance));
    CHECK(sum(large.whole.underCut) == 0.0);
    CHECK(large.whole.deepest == Approx(0.1e-3).margin(2.0 * off));
    CHECK(sum(large.removed) == Approx(ballVolume(radius)).margin(tolerance));
    CHECK(sum(large.planned) == Approx(ballVolume(0.7e-3)).margin(tolerance));

    const CutComparison moved = compareCut(solid, cavity(centre + Vec3(0.0, away, 0.0), radius));
    const double lune = ballVolume(radius) - lens(radius, away);
    CHECK(sum(moved.whole.overCut) == Approx(lune).margin(tolerance));
    CHECK(sum(moved.whole.underCut) == Approx(lune).margin(tolerance));
    CHECK(moved.whole.highest == Approx(away).margin(2.0 * off));
    CHECK(moved.whole.deepest == Approx(away).margin(2.0 * off));
    // Towards the other ball's centre by u times the radius, the surfaces are apart by this distance.
    std::vector<double> apart;
    for (double u = -1.0; u < 1.0; u += 1e-4)
      apart.push_back(std::abs(std::sqrt(radius * radius + away * away - 2.0 * radius * away * u) - radius));
    std::sort(apart.begin(), apart.end());
    CHECK(moved.whole.p95 == Approx(apart[apart.size() * 95 / 100]).margin(0.02 * away));
    CHECK(moved.whole.mean ==
          Approx(std::accumulate(apart.begin(), apart.end(), 0.0) / static_cast<double>(apart.size()))
              .margin(0.02 * away));
    int misplaced = 0;  // the ball is the preparation, and the block's sides are not
    for (std::size_t v = 0; v < moved.isPrepared.size(); ++v)
      misplaced += (moved.isPrepared[v] != 0) != ((moved.surface.vertices[v] - centre).norm() < radius + cell);
    CHECK(misplaced == 0);
    errors.push_back(
        {std::abs(sum(small.whole.underCut) / (ballVolume(more) - ballVolume(radius)) - 1.0),
         std::abs(sum(large.whole.overCut) / (ballVolume(radius) - ballVolume(0.7e-3)) - 1.0),
         std::max(std::abs(sum(moved.whole.overCut) / lune - 1.0), std::abs(sum(moved.whole.underCut) / lune - 1.0))});
    if (test::longRun())
      std::printf("cells of %.2f mm: volumes off by %.2f %% (under cut), %.2f %% (over cut), %.2f %% (moved)\n",
                  1e3 * cell, 1e2 * errors.back()[0], 1e2 * errors.back()[1], 1e2 * errors.back()[2]);
    for (const CutComparison* c : {&same, &small, &large, &moved}) checkSums(*c);
  }
  for (std::size_t i = 0; i < 3; ++i) CHECK(errors[1][i] < 0.4 * errors[0][i]);  // proportional to h^2
}

TEST_CASE("cut comparison: floors and walls of a step, layers by depth", "[unit]") {
  // The target is the block without a slab on top and one at the side; nothing is cut.
  const double cell = 0.1e-3, depth = 0.43e-3, width = 1.1e-3;
  const Solid solid = block(cell);
  const Vec3 less(0.5 * width, 0.0, 0.5 * depth);
  const CutComparison c = compareCut(solid, MeshModel(test::transformed(test::boxMesh(kHalf - less), 1.0, -less)));
  const double all = 8.0 * kHalf.prod(), left = 8.0 * (kHalf - less).prod(), corner = 2.0 * kHalf.y() * width * depth;
  CHECK(sum(c.whole.underCut) == Approx(all - left).epsilon(0.002));  // edges are rounded by a cell
  CHECK(sum(c.whole.overCut) == 0.0);
  CHECK(sum(c.removed) == 0.0);
  CHECK(c.whole.highest == Approx(std::hypot(width, depth)).margin(cell));
  // Where both slabs meet, the edge is nearest, which counts as either.
  const double top = 4.0 * (kHalf - less).x() * kHalf.y() * depth;
  const double side = 4.0 * (kHalf - less).z() * kHalf.y() * width;
  CHECK(sum(c.floors.underCut) > 0.99 * top);
  CHECK(sum(c.walls.underCut) > 0.99 * side);
  CHECK(sum(c.floors.underCut) + sum(c.walls.underCut) == Approx(top + side + corner).epsilon(0.002));
  checkSums(c);
  // Turned by 90 deg about y, the side is the floor.
  const CutComparison turned =
      compareCut(solid, MeshModel(test::transformed(test::boxMesh(kHalf - less), 1.0, -less)), Vec3(0.1, 0.0, 0.0));
  CHECK(sum(turned.floors.underCut) > 0.99 * side);
  CHECK(sum(turned.walls.underCut) > 0.99 * top);
  // Dentine is a box 0.4 mm inside the block. A cell has the layer of its corner, so a border is off by up to a cell.
  const Vec3 inner = kHalf - Vec3::Constant(0.4e-3), cut(width - 0.4e-3, 0.0, depth - 0.4e-3);
  const double dentine = 8.0 * (inner.prod() - (inner - 0.5 * cut).prod());
  CHECK(c.planned[1] == Approx(dentine).margin(cell * (all - left) / std::min(width, depth)));
  CHECK(c.planned[0] == Approx(all - left - dentine).margin(cell * (all - left) / std::min(width, depth)));
}

TEST_CASE("cut comparison: of itself, after a shift, and with cut and target exchanged", "[unit]") {
  const MeshModel whole(test::boxMesh(kHalf));
  const auto apart = [](const CutComparison& c) { return sum(c.whole.overCut) + sum(c.whole.underCut); };
  for (int run = 0; run < test::count(3, 30); ++run) {
    const auto seed = static_cast<std::uint64_t>(5701 + run);
    CAPTURE(seed);
    std::array<double, 2> off{};  // with both sizes of cells
    for (std::size_t i = 0; i < 2; ++i) {
      const double cell = i == 0 ? 0.2e-3 : 0.1e-3;
      Solid a = block(cell), b = block(cell);
      const CutComparison uncut = compareCut(a, whole);
      CHECK(apart(uncut) == 0.0);
      CHECK(uncut.whole.area == 0.0);
      const double before = sum(a.volume());
      cutAnyhow(a, seed);
      cutAnyhow(b, seed + 1000);
      const CutComparison all = compareCut(a, whole);
      CHECK(sum(all.whole.overCut) == Approx(sum(all.removed)));
      CHECK(sum(all.removed) == Approx(before - sum(a.volume())));
      const MeshModel surfaceA(surfaceOf(a)), surfaceB(surfaceOf(b));
      const CutComparison ab = compareCut(a, surfaceB), ba = compareCut(b, surfaceA);
      const CutComparison own = compareCut(a, surfaceA);
      CHECK(own.whole.mean == Approx(0.0).margin(1e-15));
      CHECK(std::max(own.whole.highest, own.whole.deepest) < 1e-12);
      // The share of a cell differs between the samples of a solid and those of its surface. These differences are all
      // that the exchange can change.
      off[i] = apart(own);
      const double most = off[i] + apart(compareCut(b, surfaceB));
      CHECK(std::abs(sum(ab.whole.overCut) - sum(ba.whole.underCut)) < most);
      CHECK(std::abs(sum(ab.whole.underCut) - sum(ba.whole.overCut)) < most);
      for (const CutComparison* c : {&all, &own, &ab, &ba}) checkSums(*c);
      if (i == 1) continue;

      const Vec3 shift(3.7e-3, -1.3e-3, 12.1e-3);
      Solid moved = block(cell, shift);
      cutAnyhow(moved, seed, shift);
      const CutComparison there = compareCut(moved, MeshModel(test::transformed(surfaceOf(b), 1.0, shift)));
      for (std::size_t k = 0; k < 2; ++k) {
        CHECK(there.whole.overCut[k] == Approx(ab.whole.overCut[k]).epsilon(1e-6));
        CHECK(there.whole.underCut[k] == Approx(ab.whole.underCut[k]).epsilon(1e-6));
      }
      CHECK(there.whole.mean == Approx(ab.whole.mean).epsilon(1e-6));
      CHECK(there.whole.p95 == Approx(ab.whole.p95).epsilon(1e-3));
    }
    if (test::longRun()) std::printf("%.3f and %.3f mm^3 apart from its own surface\n", 1e9 * off[0], 1e9 * off[1]);
    CHECK(off[1] < 0.4 * off[0]);  // proportional to h^2
  }
}

TEST_CASE("cut comparison: what is refused; a solid that is cut away", "[unit]") {
  Solid solid = block(0.2e-3);
  const MeshModel whole(test::boxMesh(kHalf));
  TriangleMesh open = test::boxMesh(kHalf);
  open.triangles.pop_back();
  CHECK_THROWS_WITH(compareCut(solid, MeshModel(open)), test::ContainsSubstring("must be closed"));
  CHECK_THROWS_WITH(compareCut(solid, whole, Vec3::Zero()), test::ContainsSubstring("axis"));
  CHECK_THROWS_WITH(compareCut(solid, whole, Vec3(0.0, 0.0, std::nan(""))), test::ContainsSubstring("axis"));
  const double before = sum(solid.volume());
  solid.cut(at(Vec3::Zero()), at(Vec3::Zero()), 4e-3);
  const CutComparison c = compareCut(solid, whole);
  CHECK(sum(c.whole.overCut) == Approx(before));
  CHECK(c.surface.triangles.empty());
  CHECK(c.whole.area == 0.0);
  CHECK(c.whole.p95 == 0.0);
}

}  // namespace enamel::test_cut_comparison
