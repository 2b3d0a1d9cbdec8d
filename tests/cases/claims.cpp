// Impossible numbers for obstacles.
#include "enamel/collision/scene.hpp"
#include "support/catch.hpp"

namespace enamel::test_claims {

TEST_CASE("case 15: a position of 1e300 m is rejected", "[cases]") {
  Scene scene = flatWall();
  Pose pose;
  pose.position.z() = 1e300;
  CHECK(scene.move(0, pose, Vec6::Zero()) != Status::ok);
}

TEST_CASE("case 15: a velocity of 1e300 m/s is rejected", "[cases]") {
  Scene scene = flatWall();
  Vec6 twist = Vec6::Zero();
  twist[2] = 1e300;
  CHECK(scene.move(0, Pose{}, twist) != Status::ok);
}

TEST_CASE("case 15: poses and velocities up to the limits are accepted", "[cases]") {
  Scene scene = flatWall();
  const auto moved = [&](const Vec3& position, double speed, double turn) {
    const Pose before = scene.obstacles()[0].pose;
    Vec6 twist;
    twist << 0.0, speed, 0.0, 0.0, 0.0, turn;
    const Status status = scene.move(0, {position, Mat3::Identity()}, twist);
    CHECK((status == Status::ok || scene.obstacles()[0].pose.position == before.position));
    return status;
  };
  CHECK(moved({kFarthest, -kFarthest, 0.0}, kFastest, -kFastestTurn) == Status::ok);
  CHECK(moved({0.0, 1.001 * kFarthest, 0.0}, 0.0, 0.0) == Status::outOfRange);
  CHECK(moved(Vec3::Zero(), -1.001 * kFastest, 0.0) == Status::outOfRange);
  CHECK(moved(Vec3::Zero(), 0.0, 1.001 * kFastestTurn) == Status::outOfRange);
  CHECK_THROWS_WITH(scene.add(halfSpace("far", Vec3(0.0, 0.0, 1e6), Vec3::UnitZ())),
                    test::ContainsSubstring("obstacle \"far\": must be within 100 m"));
}

}  // namespace enamel::test_claims
