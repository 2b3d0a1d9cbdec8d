// Numbers that no obstacle can have.
#include "enamel/collision/scene.hpp"
#include "support/catch.hpp"

namespace enamel::test_claims {

TEST_CASE("case 15: a position of 1e300 m is rejected (expected failure until the hardening)", "[!shouldfail][cases]") {
  Scene scene = flatWall();
  Pose pose;
  pose.position.z() = 1e300;
  CHECK(scene.move(0, pose, Vec6::Zero()) != Status::ok);
}

TEST_CASE("case 15: a velocity of 1e300 m/s is rejected (expected failure until the hardening)",
          "[!shouldfail][cases]") {
  Scene scene = flatWall();
  Vec6 twist = Vec6::Zero();
  twist[2] = 1e300;
  CHECK(scene.move(0, Pose{}, twist) != Status::ok);
}

}  // namespace enamel::test_claims
