// Cuts at the limits of what Solid::cut() accepts.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "enamel/collision/solid.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/processor_time.hpp"

namespace enamel::test_solids {

namespace {

constexpr double kCell = 1e-4;

Solid block() {
  return {MeshModel(test::boxMesh(Vec3(5e-3, 5e-3, 3e-3))), {{"enamel", {}, 3e9, 0.0, nullptr}}, {kCell, 64}};
}

double volumeOf(const Solid& solid) {
  const RemovedVolume volume = solid.volume();
  return std::accumulate(volume.begin(), volume.end(), 0.0);
}

double ballOf(double radius) { return 4.0 / 3.0 * M_PI * radius * radius * radius; }

// Return what a ball of `radius` removes from the block's middle, m^3.
double takenBy(Solid& solid, double radius) {
  const double before = volumeOf(solid);
  (void)solid.cut({Vec3::Zero(), Vec3::Zero()}, {Vec3::Zero(), Vec3::Zero()}, radius);
  const double taken = before - volumeOf(solid);
  solid.restore();
  return taken;
}

// Return the least processor time of three cuts, s.
double timeOf(Solid& solid, const Segment& from, const Segment& to, double radius) {
  solid.restore();
  return test::leastTime(
      3, [&] { (void)solid.cut(from, to, radius); }, [&] { solid.restore(); });
}

Segment ballAt(double y) { return {{0.0, y, 3e-3}, {0.0, y, 3e-3}}; }

}  // namespace

TEST_CASE("cuts: a ball of ten cells takes its volume", "[cases]") {
  Solid solid = block();
  CHECK(takenBy(solid, 10.0 * kCell) == Approx(ballOf(10.0 * kCell)).epsilon(0.02));
}

TEST_CASE("case 05: a ball smaller than a cell takes no more than its volume and a cell", "[cases]") {
  Solid solid = block();
  double worst = 0.0, worstRadius = 0.0;  // m^3 above 1.5 times the ball; m
  for (const double radius : {1e-300, 1e-9, 1e-8, 1e-7, 3e-7, 1e-6, 1e-5, 3e-5, 6e-5, 1e-4, 2e-4}) {
    const double excess = takenBy(solid, radius) - 1.5 * ballOf(radius);
    if (excess <= worst) continue;
    worst = excess;
    worstRadius = radius;
  }
  CAPTURE(worst, worstRadius);
  CHECK(worst < kCell * kCell * kCell);
}

// The limit is a ratio because machines differ; an ordinary cut takes about 0.1 ms.
TEST_CASE("case 18: no cut that is accepted costs more than 100 ordinary ones", "[cases]") {
  Solid solid = block();
  const double ordinary = timeOf(solid, ballAt(0.0), ballAt(1e-4), 1e-3);
  REQUIRE(ordinary > 0.0);
  const auto costs = [&](const Segment& from, const Segment& to, double radius) {
    return timeOf(solid, from, to, radius) / ordinary;
  };
  const Segment across{{-0.05, -0.03, 0.0}, {0.04, 0.03, 3e-3}};  // an axis of 0.1 m
  const Vec3 aside(0.0, 0.0, 0.019);
  CHECK(costs(across, {across.a + aside, across.b - aside}, 1e-3) < 100.0);
  CHECK(costs(across, {across.a + aside, across.b - aside}, Solid::kLargestBur) < 100.0);
  CHECK(costs(ballAt(-0.0095), ballAt(0.0095), Solid::kLargestBur) < 100.0);
  CHECK(costs(ballAt(-0.0095), ballAt(0.0095), 1e-5) < 100.0);
}

TEST_CASE("cuts: a cut outside the limits removes nothing, and the call says so", "[cases]") {
  Solid solid = block();
  const Segment ball = ballAt(0.0);
  const auto refuses = [&](const Segment& from, const Segment& to, double radius) {
    double reached = 1.0;
    const RemovedVolume taken = solid.cut(from, to, radius, &reached);
    return reached == 0.0 && std::accumulate(taken.begin(), taken.end(), 0.0) == 0.0;
  };
  CHECK_FALSE(refuses(ball, ball, Solid::kLargestBur));
  for (const double radius : {0.0, -1e-3, 5.1e-3, 1.0, std::nan(""), HUGE_VAL}) CHECK(refuses(ball, ball, radius));
  CHECK(refuses(ball, ballAt(0.021), 1e-3));
  CHECK(refuses({{-0.051, 0.0, 0.0}, {0.051, 0.0, 0.0}}, {{-0.051, 0.0, 0.0}, {0.051, 0.0, 0.0}}, 1e-3));
}

TEST_CASE("cuts: what a long one leaves, the next calls take", "[cases]") {
  Solid whole = block(), parts = block();
  const Segment from = ballAt(-0.0095), to = ballAt(0.0095);
  constexpr double kRadius = 4e-3;
  for (int i = 1; i <= 40; ++i)
    (void)whole.cut(ballAt(-0.0095 + 0.019 * (i - 1) / 40), ballAt(-0.0095 + 0.019 * i / 40), kRadius);
  Segment at = from;
  int calls = 0;
  for (double reached = 0.0; reached < 1.0; ++calls) {
    REQUIRE(calls < 50);
    (void)parts.cut(at, to, kRadius, &reached);
    REQUIRE(reached > 0.0);
    at = {at.a + reached * (to.a - at.a), at.b + reached * (to.b - at.b)};
  }
  CHECK(calls > 1);
  CHECK(volumeOf(parts) == Approx(volumeOf(whole)).epsilon(2e-3));
}

}  // namespace enamel::test_solids
