// Forward kinematics on many poses, on invalid input, and compared with all assembly modes.
#include <iostream>

#include "enamel/device/tau/kinematics.hpp"
#include "support/assembly_modes.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_forward_kinematics {

namespace {

double distance(const Pose& a, const Pose& b) { return (a.position - b.position).norm(); }

Vec3 homeElevations(const TauModel& model) {
  const Vec3 elbow = elbowAngles(model.home);
  return {model.homeAngles[1] + elbow[0], model.homeAngles[3] + elbow[1], model.homeAngles[5] + elbow[2]};
}

Vec6 wayTo(const TauModel& model, const Vec6& q) {
  Vec6 way;
  for (int i = 0; i < 6; ++i) way[i] = std::remainder(q[i] - model.homeAngles[i], 2.0 * M_PI);
  return way;
}

}  // namespace

TEST_CASE("forward kinematics converges on every workspace pose, near and cold", "[hard]") {
  constexpr std::uint64_t seed = 20260102;
  const int poses = test::count(100000, 1000000);
  const TauModel model = makeModel(test::nominal());
  test::Random random(seed);
  long nearIterations = 0, coldIterations = 0;
  int nearFailures = 0, coldFailures = 0;
  double worst_m = 0.0, worst_rad = 0.0;
  for (int i = 0; i < poses; ++i) {
    const Pose pose = random.workspacePose();
    Vec6 q;
    REQUIRE(inverseKinematics(model, pose, q) == Status::ok);
    Pose start = pose;
    start.position += 0.005 * random.direction();
    start.rotation = test::rotationAbout(random.direction(), 3.0 * M_PI / 180.0) * start.rotation;
    TauConfiguration near, cold;
    REQUIRE(inverseKinematics(model, start, near) == Status::ok);
    const auto check = [&](const ForwardKinematicsReport& report, const Pose& found, int& failures) {
      const double error_m = distance(found, pose), error_rad = angleBetween(found.rotation, pose.rotation);
      // Limits of the specification: 1e-11 m and 1e-10 rad. The platform is 75 mm wide.
      if (report.status != Status::ok || !(error_m < 1e-11) || !(error_rad < 1e-10)) ++failures;
      worst_m = std::max(worst_m, error_m);
      worst_rad = std::max(worst_rad, error_rad);
      return report.iterations;
    };
    nearIterations += check(forwardKinematics(model, q, near), near.pose, nearFailures);
    coldIterations += check(forwardKinematicsFromHome(model, q, cold), cold.pose, coldFailures);
  }
  const double perNear = static_cast<double>(nearIterations) / poses;
  std::cout << poses << " poses, seed " << seed << ": failures near " << nearFailures << ", cold " << coldFailures
            << "; iterations near " << perNear << ", cold " << static_cast<double>(coldIterations) / poses
            << "; worst error " << worst_m << " m, " << worst_rad << " rad\n";
  CHECK(nearFailures == 0);
  CHECK(coldFailures == 0);
  CHECK(perNear <= 4.0);
}

TEST_CASE("the branch that forward kinematics follows is the one continued from home", "[hard]") {
  constexpr std::uint64_t seed = 31;
  const int poses = test::count(300, 5000);
  const TauParameters device = test::nominal();
  const TauModel model = makeModel(device);
  test::Random random(seed);
  int fewest = 99, most = 0;
  double nearestImpostor_rad = M_PI;
  for (int i = 0; i < poses; ++i) {
    const Pose pose = random.workspacePose();
    Vec6 q;
    REQUIRE(inverseKinematics(model, pose, q) == Status::ok);
    const test::Legs legs = test::legsAt(device, q);
    const std::vector<Vec3> modes = test::assemblyModes(legs);
    int own = 0;
    for (const Vec3& mode : modes) {
      const Pose other = test::poseOfMode(device, legs, mode);
      const double angle = angleBetween(other.rotation, pose.rotation);
      if (distance(other, pose) < 1e-8 && angle < 1e-7)
        ++own;
      else
        nearestImpostor_rad = std::min(nearestImpostor_rad, angle);
    }
    CHECK(own == 1);
    CHECK(modes.size() <= 16);
    fewest = std::min(fewest, static_cast<int>(modes.size()));
    most = std::max(most, static_cast<int>(modes.size()));

    const test::Walk walk = test::slowWalk(device, model.homeAngles, homeElevations(model), wayTo(model, q), 2e-3);
    REQUIRE(walk.arrived);
    const Pose walked = test::poseOfMode(device, legs, walk.elevations);
    TauConfiguration c;
    REQUIRE(forwardKinematicsFromHome(model, q, c).status == Status::ok);
    CHECK(distance(walked, pose) < 1e-11);
    CHECK(distance(c.pose, walked) < 1e-11);
  }
  std::cout << poses << " poses, seed " << seed << ": " << fewest << " to " << most
            << " real assembly modes; the nearest other mode is rotated by " << nearestImpostor_rad * 180.0 / M_PI
            << " deg\n";
  CHECK(nearestImpostor_rad > M_PI / 3.0);  // 60 deg separate the branches in the workspace
}

TEST_CASE("garbage joint angles get a status, and ok only on the branch of home", "[hard]") {
  constexpr std::uint64_t seed = 41;
  const int vectors = test::count(10000, 100000);
  for (const TauParameters& device : {test::nominal(), test::randomDevice(2)}) {
    const TauModel model = makeModel(device);
    const Vec3 elevations = homeElevations(model);
    test::Random random(seed);
    int converged = 0, unreachable = 0, singular = 0, notFinite = 0, unfinished = 0, missed = 0, most = 0;
    for (int i = 0; i < vectors; ++i) {
      const double range = i % 3 == 0 ? M_PI : i % 3 == 1 ? 1.0 : 0.4;
      Vec6 q = model.homeAngles + random.vector6(range, range);
      if (i % 50 == 0) q[i / 50 % 6] = i % 100 == 0 ? std::nan("") : HUGE_VAL;
      TauConfiguration cold = model.home;
      const ForwardKinematicsReport report = forwardKinematicsFromHome(model, q, cold);
      TauConfiguration warm = model.home;
      const ForwardKinematicsReport warmReport = forwardKinematics(model, q, warm);
      most = std::max(most, report.iterations);
      REQUIRE(cold.pose.position.allFinite());
      REQUIRE(cold.pose.rotation.allFinite());
      REQUIRE(warm.pose.rotation.allFinite());
      switch (report.status) {
        case Status::ok: ++converged; break;
        case Status::unreachable: ++unreachable; break;
        case Status::singular: ++singular; break;
        case Status::notFinite: ++notFinite; break;
        default: ++unfinished; break;
      }
      REQUIRE((report.status == Status::notFinite) == !q.allFinite());
      if (report.status != Status::ok) CHECK(cold.pose.position == model.home.pose.position);
      if (report.status == Status::ok) {
        REQUIRE(report.residual < 1e-14);
        const test::Legs legs = test::legsAt(device, q);
        // Plain Newton without prediction needs shorter steps near a fold.
        test::Walk walk = test::slowWalk(device, model.homeAngles, elevations, wayTo(model, q), 2e-3);
        if (!walk.arrived) walk = test::slowWalk(device, model.homeAngles, elevations, wayTo(model, q), 1e-4);
        REQUIRE(walk.arrived);
        REQUIRE(walk.smallestSinElbow > 0.0);
        REQUIRE(distance(test::poseOfMode(device, legs, walk.elevations), cold.pose) < 1e-9);
      }
      // A warm start from home must find the pose of the walk, or none.
      if (warmReport.status == Status::ok) {
        REQUIRE(report.status == Status::ok);
        REQUIRE(distance(warm.pose, cold.pose) < 1e-9);
      }
      // If the walk refuses, there must be a singularity (checked for some, because the slow walk is slow).
      if (report.status != Status::ok && report.status != Status::notFinite && i % 20 == 1) {
        const test::Walk walk = test::slowWalk(device, model.homeAngles, elevations, wayTo(model, q), 2e-3);
        if (walk.arrived && std::min({walk.smallestDeterminant, walk.smallestSinElbow, walk.smallestRadius}) > 1e-2)
          ++missed;
      }
    }
    std::cout << device.name << ", " << vectors << " vectors, seed " << seed << ": ok " << converged << ", unreachable "
              << unreachable << ", singular " << singular << ", not finite " << notFinite << ", not converged "
              << unfinished << "; most iterations " << most << "\n";
    CHECK(converged > vectors / 20);
    CHECK(missed == 0);
    CHECK(most <= kMaxWalkIterations + 8);
  }
}

TEST_CASE("a warm start stays on the branch it starts from", "[hard]") {
  // From regular configurations, also near singularities, to joint angles up to 0.3 rad away. A result with status ok
  // must be the end of the slow walk from the start, or from home.
  constexpr std::uint64_t seed = 45;
  for (const TauParameters& device : {test::nominal(), test::randomDevice(2)}) {
    const TauModel model = makeModel(device);
    test::Random random(seed);
    int warm = 0, walkedFromHome = 0, jumped = 0;
    for (int i = 0; i < test::count(20000, 200000); ++i) {
      const Vec6 q = model.homeAngles + random.vector6(1.0, 1.0);
      TauConfiguration start;
      if (forwardKinematicsFromHome(model, q, start).status != Status::ok) continue;
      const double range = random.uniform(0.0, 0.3);
      const Vec6 way = random.vector6(range, range);
      TauConfiguration c = start;
      if (forwardKinematics(model, q + way, c).status != Status::ok) continue;
      const Vec3 elbow = elbowAngles(start);
      const test::Walk walk = test::slowWalk(device, q, {q[1] + elbow[0], q[3] + elbow[1], q[5] + elbow[2]}, way, 2e-3);
      const test::Legs legs = test::legsAt(device, q + way);
      if (walk.arrived && distance(test::poseOfMode(device, legs, walk.elevations), c.pose) < 1e-9) {
        ++warm;
        continue;
      }
      TauConfiguration fromHome;
      const bool home = forwardKinematicsFromHome(model, q + way, fromHome).status == Status::ok;
      ++(home && distance(fromHome.pose, c.pose) < 1e-9 ? walkedFromHome : jumped);
    }
    std::cout << device.name << ", seed " << seed << ": on the start's branch " << warm << ", on home's by a walk "
              << walkedFromHome << ", elsewhere " << jumped << "\n";
    CHECK(warm > 100);
    CHECK(jumped == 0);
  }
}

TEST_CASE("a singular pose is approached and refused, not jumped over", "[hard]") {
  // Walk from home along random directions in joint space until the slow walk reaches the fold. Just before it, forward
  // kinematics converges; just behind it, this branch has no solution.
  const TauParameters device = test::nominal();
  const TauModel model = makeModel(device);
  const Vec3 elevations = homeElevations(model);
  test::Random random(51);
  int folds = 0;
  for (int i = 0; i < test::count(100, 1000); ++i) {
    const Vec6 direction = random.vector6(1.0, 1.0).normalized() * 2.5;
    double good = 0.0, bad = 1.0;
    if (test::slowWalk(device, model.homeAngles, elevations, direction, 2e-3).arrived) continue;
    for (int k = 0; k < 20; ++k) {
      const double middle = 0.5 * (good + bad);
      const bool arrived = test::slowWalk(device, model.homeAngles, elevations, middle * direction, 2e-3).arrived;
      (arrived ? good : bad) = middle;
    }
    ++folds;
    TauConfiguration c;
    const Vec6 behind = model.homeAngles + std::min(1.0, bad * 1.02 + 1e-3) * direction;
    CHECK(forwardKinematicsFromHome(model, behind, c).status != Status::ok);
  }
  CHECK(folds > 2);
}

}  // namespace enamel::test_forward_kinematics
