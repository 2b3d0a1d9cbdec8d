// Analytic shapes: signed distances and features.
#include "enamel/collision/shapes.hpp"

#include "support/catch.hpp"
#include "support/meshes.hpp"

namespace enamel::test_shapes {

TEST_CASE("shapes answer with a point of their surface, a unit normal and the distance", "[unit]") {
  test::Random random(41);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = random.vector(2.0);
    for (const ShapePoint& found : {signedDistance(HalfSpace{}, p), signedDistance(Box{{0.5, 1.0, 0.7}}, p),
                                    signedDistance(Sphere{0.8}, p), signedDistance(Capsule{0.4, 0.9}, p)}) {
      CHECK(std::abs(found.normal.norm() - 1.0) < 1e-12);
      CHECK((found.point + found.distance * found.normal - p).norm() < 1e-12);
    }
    CHECK(std::abs(signedDistance(Box{{0.5, 1.0, 0.7}}, signedDistance(Box{{0.5, 1.0, 0.7}}, p).point).distance) <
          1e-12);
  }
}

TEST_CASE("a box's distance is the distance: zero on the surface, 1-Lipschitz, negative inside", "[unit]") {
  test::Random random(501);
  int in = 0;
  for (int i = 0; i < 20000; ++i) {
    const Box box{{random.uniform(0.002, 0.03), random.uniform(0.002, 0.03), random.uniform(0.002, 0.03)}};
    const Vec3 x = random.vector(0.06);
    const ShapePoint found = signedDistance(box, x);
    REQUIRE((found.distance < 0.0) == (x.cwiseAbs().array() < box.half.array()).all());
    in += found.distance < 0.0;
    const Vec3 y = x + random.vector(0.02);
    REQUIRE(std::abs(signedDistance(box, y).distance - found.distance) <= (y - x).norm() + 1e-15);  // one rounding
  }
  CHECK(in > 200);
  const Box box{{1.0, 2.0, 3.0}};
  CHECK(signedDistance(box, {4.0, 6.0, 0.0}).distance == 5.0);
  CHECK(signedDistance(box, {4.0, 6.0, 0.0}).normal == Vec3(0.6, 0.8, 0.0));
  CHECK(signedDistance(box, {2.0, 4.0, 5.0}).distance == 3.0);
  CHECK(signedDistance(box, {0.0, -2.0, 0.0}).normal == -Vec3::UnitY());
  CHECK(signedDistance(box, Vec3::Zero()).distance == -1.0);
  CHECK(signedDistance(box, {1.0 + 1e-300, 0.0, 0.0}).distance == 0.0);
}

}  // namespace enamel::test_shapes
