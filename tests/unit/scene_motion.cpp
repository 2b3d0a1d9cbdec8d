// Motion of obstacles between the poses that a host sets.
#include "enamel/render/scene_motion.hpp"

#include "support/catch.hpp"

namespace enamel::test_scene_motion {

namespace {

constexpr double kTick = 1e-3;  // s

Vec6 along(double speed) {
  Vec6 twist = Vec6::Zero();
  twist[2] = speed;
  return twist;
}

// A wall whose pose a host sets, as seen by the ticks.
struct Bench {
  Scene stated = flatWall();
  SceneMotion motion{stated};
  int tick = 0;

  void set(double height, const Vec6& twist = Vec6::Zero(), double angle = 0.0) {
    const Pose pose{Vec3(0.0, 0.0, height), rotationFromVector(Vec3(0.0, angle, 0.0))};
    REQUIRE(stated.move(0, pose, twist) == Status::ok);
  }
  const Obstacle& next() { return motion.follow(stated, kTick * tick++).obstacles()[0]; }
};

}  // namespace

TEST_CASE("scene motion: an obstacle at rest is where it is stated", "[scene_motion]") {
  Bench bench;
  bench.set(0.3);
  for (int i = 0; i < 3; ++i) {
    const Obstacle& seen = bench.next();
    CHECK(seen.pose.position.z() == 0.3);
    CHECK(seen.twist.isZero(0.0));
  }
  CHECK(bench.motion.ignoredTwists() == 0);
  CHECK(bench.motion.ignoredObstacle() == -1);
}

TEST_CASE("scene motion: a twist without a motion is ignored and counted", "[scene_motion]") {
  Bench bench;
  bench.set(0.0, along(1.0));
  for (int i = 0; i < 5; ++i) CHECK(bench.next().twist.isZero(0.0));
  CHECK(bench.motion.ignoredTwists() == 5);
  CHECK(bench.motion.ignoredObstacle() == 0);
  bench.set(0.0, along(0.9e-3));  // without a stated velocity
  bench.next();
  CHECK(bench.motion.ignoredTwists() == 5);
}

TEST_CASE("scene motion: poses and twists at every tick pass bit for bit", "[scene_motion]") {
  Bench bench;
  bench.next();
  double height = 0.0;
  for (int i = 0; i < 20; ++i) {
    height += 2e-5;
    const Vec6 twist = along(0.02 + 1e-4 * i);
    bench.set(height, twist);
    const Obstacle& seen = bench.next();
    if (i == 0) continue;  // the first pose may belong to a frame
    CHECK(seen.pose.position.z() == height);
    CHECK(seen.twist == twist);
  }
  CHECK(bench.motion.ignoredTwists() == 0);
  CHECK(bench.next().twist.isZero(0.0));
}

TEST_CASE("scene motion: poses at every tick without a twist, or with a wrong one, give the twist", "[scene_motion]") {
  for (const double stated : {0.0, -0.02, 0.2}) {
    Bench bench;
    bench.next();
    for (int i = 1; i <= 10; ++i) {
      bench.set(2e-5 * i, along(stated), 1e-4 * i);
      const Obstacle& seen = bench.next();
      if (i == 1) continue;
      CHECK((seen.twist - (Vec6() << 0.0, 0.0, 0.02, 0.0, 0.1, 0.0).finished()).norm() < 1e-9);
    }
    CHECK(bench.motion.ignoredTwists() == (stated == 0.0 ? 0 : 9));
  }
}

TEST_CASE("scene motion: poses at 60 Hz give a steady motion, whatever velocity the host states", "[scene_motion]") {
  constexpr double kSpeed = 0.02, kTurn = 0.5;  // m/s, rad/s
  for (const bool isStated : {false, true}) {
    Bench bench;
    int frame = 0, steady = 0;
    double before = 0.0, goal = 0.0;
    for (int tick = 0; tick < 300; ++tick) {
      if (tick >= static_cast<int>(frame * 1000.0 / 60.0)) {  // every 16 or 17 ticks
        ++frame;
        goal = kSpeed * kTick * tick;
        bench.set(goal, along(isStated ? kSpeed / (60.0 * kTick) : 0.0), kTurn * kTick * tick);
      }
      const Obstacle& seen = bench.next();
      const double height = seen.pose.position.z();
      CHECK(height >= before);
      CHECK(height - before < (frame > 4 ? 1.1 : 1.6) * kSpeed * kTick);
      CHECK(height <= goal);
      if (frame > 4) {
        ++steady;
        CHECK(seen.twist[2] == Approx(kSpeed).epsilon(0.1));
        CHECK(seen.twist[4] == Approx(kTurn).epsilon(0.1));
        CHECK(goal - height < 1.3 * kSpeed / 60.0);
        CHECK(isRotation(seen.pose.rotation));
      }
      before = height;
    }
    CHECK(steady > 200);
    CHECK((bench.motion.ignoredTwists() > 0) == isStated);
    for (int tick = 0; tick < 25; ++tick) bench.next();
    CHECK(bench.next().pose.position.z() == goal);  // it arrives and rests
    CHECK(bench.next().twist.isZero(0.0));
  }
}

TEST_CASE("scene motion: a pose after a rest is reached within 0.12 s", "[scene_motion]") {
  Bench bench;
  for (int i = 0; i < 500; ++i) bench.next();
  bench.set(1e-3);
  double before = 0.0;
  for (int i = 1; i <= 120; ++i) {
    const double height = bench.next().pose.position.z();
    CHECK(height - before == Approx(1e-3 / 120.0).epsilon(1e-6));
    before = height;
  }
  CHECK(before == 1e-3);
  bench.set(5e-3);
  bench.next();
  bench.motion.reset(bench.stated);
  CHECK(bench.motion.scene().obstacles()[0].pose.position.z() == 5e-3);
  CHECK(bench.next().pose.position.z() == 5e-3);
}

TEST_CASE("scene motion: lost samples take the time that they took", "[scene_motion]") {
  Bench bench;
  bench.next();
  bench.set(2e-5);
  bench.next();
  bench.tick += 3;  // the next sample comes four periods later
  bench.set(1e-4);
  const Obstacle& seen = bench.next();
  CHECK(seen.pose.position.z() == 1e-4);
  CHECK(seen.twist[2] == Approx(8e-5 / (4.0 * kTick)).epsilon(1e-9));
}

}  // namespace enamel::test_scene_motion
