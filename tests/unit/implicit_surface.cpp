// Meshes of formulas: a ball and a torus against their formulas, and refused input.
#include "enamel/collision/implicit_surface.hpp"

#include <cmath>
#include <limits>

#include "enamel/core/error.hpp"
#include "support/catch.hpp"

namespace enamel::test_implicit_surface {

namespace {

constexpr double kPi = 3.14159265358979323846;
const Vec3 kLow(-3e-3, -3.1e-3, -3.2e-3), kHigh(3.3e-3, 3.2e-3, 3.1e-3);

}  // namespace

TEST_CASE("the mesh of a ball and of a torus is closed, outward and as near as the cells allow", "[unit]") {
  const auto ball = [](const Vec3& p) { return p.norm() - 2e-3; };
  const auto torus = [](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.y()) - 2e-3, p.z()) - 0.8e-3; };
  const double ballVolume = 4.0 / 3.0 * kPi * 8e-9, torusVolume = 2.0 * kPi * kPi * 2e-3 * 0.64e-6;
  for (const double cell : {4e-4, 2e-4, 1e-4}) {
    INFO("cell " << cell);
    double most = 0.0;
    const TriangleMesh round = surfaceOf(ball, kLow, kHigh, cell);
    for (const Vec3& v : round.vertices) most = std::max(most, std::abs(ball(v)));
    // Tetrahedra have edges up to sqrt(3) cells. A vertex keeps 1 % of the edge from its ends.
    CHECK(most < 3.0 * cell * cell / (8.0 * 2e-3) + 0.01 * std::sqrt(3.0) * cell);
    CHECK(inspect(round).watertight);
    CHECK(inspect(round).volume == Approx(ballVolume).epsilon(0.5 * cell * cell / 1e-6));
    const TriangleMesh ring = surfaceOf(torus, kLow, kHigh, cell);
    CHECK(inspect(ring).watertight);
    CHECK(inspect(ring).volume == Approx(torusVolume).epsilon(2.0 * cell * cell / 1e-6));
    // Euler characteristic: vertices - edges + triangles.
    const auto characteristic = [](const TriangleMesh& mesh) {
      return static_cast<int>(mesh.vertices.size()) - static_cast<int>(mesh.triangles.size()) / 2;
    };
    CHECK(characteristic(round) == 2);
    CHECK(characteristic(ring) == 0);
  }
}

TEST_CASE("a shape that the box cuts off is closed there, and no shape gives no mesh", "[unit]") {
  const auto below = [](const Vec3& p) { return p.z(); };
  const TriangleMesh half = surfaceOf(below, kLow, kHigh, 1e-4);
  CHECK(inspect(half).watertight);
  CHECK(inspect(half).volume == Approx(6.3e-3 * 6.3e-3 * 3.2e-3).epsilon(0.1));
  CHECK(surfaceOf([](const Vec3&) { return 1.0; }, kLow, kHigh, 1e-4).triangles.empty());
}

TEST_CASE("an implicit surface refuses input that has none", "[unit]") {
  const auto field = [](const Vec3& p) { return p.norm() - 2e-3; };
  CHECK_THROWS_WITH(surfaceOf(field, kLow, kLow, 1e-4), "implicit surface: the box is empty or not finite");
  CHECK_THROWS_WITH(surfaceOf(field, kLow, kHigh, 0.0), "implicit surface: the cell is 0 m, must be above 0");
  CHECK_THROWS_WITH(surfaceOf(field, kLow, kHigh, 1e-6),
                    "implicit surface: cells of 1e-06 m need more than 2^28 samples");
  CHECK_THROWS_WITH(surfaceOf([](const Vec3&) { return std::numeric_limits<double>::quiet_NaN(); }, kLow, kHigh, 1e-3),
                    "implicit surface: the field is not finite");
}

}  // namespace enamel::test_implicit_surface
