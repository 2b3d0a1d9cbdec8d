// Inverse and forward kinematics and the Jacobians: reference rows, properties, refusals.
#include "enamel/device/tau/kinematics.hpp"

#include <complex>

#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/reference.hpp"

namespace enamel::test_kinematics {

using test::relativeError;

namespace {

TauConfiguration configurationAt(const TauModel& model, const Pose& pose) {
  TauConfiguration c;
  REQUIRE(inverseKinematics(model, pose, c) == Status::ok);
  return c;
}

bool finite(const TauConfiguration& c) {
  bool all = c.pose.position.allFinite() && c.pose.rotation.allFinite();
  for (const auto& chain : c.chain) all = all && chain.tip.allFinite() && chain.arm.allFinite();
  return all;
}

}  // namespace

TEST_CASE("Euler angles go to a rotation and back", "[kinematics]") {
  test::Random random(11);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 euler = random.vector(1.5);
    const Mat3 rotation = rotationFromEuler(euler);
    const Mat3 product = test::rotationAbout(Vec3::UnitZ(), euler.z()) * test::rotationAbout(Vec3::UnitY(), euler.y()) *
                         test::rotationAbout(Vec3::UnitX(), euler.x());
    CHECK((rotation - product).cwiseAbs().maxCoeff() < 1e-15);    // a few rounding errors of numbers up to 1
    CHECK((eulerFromRotation(rotation) - euler).norm() < 1e-14);  // conditioning: cos 1.5 = 0.07
  }
  const Vec3 locked = eulerFromRotation(rotationFromEuler({0.3, M_PI / 2, 0.8}));
  CHECK((rotationFromEuler(locked) - rotationFromEuler({0.3, M_PI / 2, 0.8})).norm() < 1e-10);
}

TEST_CASE("kinematics agree with independent engines", "[kinematics]") {
  for (const std::string name : {"tau-nominal", "tau-detailed"}) {
    const TauModel model = makeModel(loadTau(test::deviceFile(name + ".toml")));
    for (const test::ReferenceState& row : test::referenceStates(name)) {
      Pose pose;
      pose.position = row.position;
      pose.rotation = rotationFromEuler(row.euler);
      const TauConfiguration c = configurationAt(model, pose);
      // The engines agree to 2e-15; ours has a few more rounding errors.
      CHECK(relativeError(jointAngles(c), row.q) < 1e-14);
      CHECK(relativeError(elbowAngles(c), row.elbow) < 1e-14);
      CHECK(relativeError(jacobian(model, c), row.jacobian) < 5e-14);
      TauConfiguration solved;
      REQUIRE(forwardKinematicsFromHome(model, row.q, solved).status == Status::ok);
      CHECK((solved.pose.position - pose.position).norm() < 1e-14);
      CHECK(angleBetween(solved.pose.rotation, pose.rotation) < 1e-13);
    }
  }
}

TEST_CASE("the chain closes: base, knee and tip have the right distances", "[kinematics]") {
  for (const TauParameters& device : test::someDevices()) {
    const TauModel model = makeModel(device);
    test::Random random(5);
    for (int i = 0; i < 200; ++i) {
      const TauConfiguration c = configurationAt(model, random.workspacePose(0.3));
      const Vec6 q = jointAngles(c);
      const Vec3 elbow = elbowAngles(c);
      for (int k = 0; k < 3; ++k) {
        const double a = q[2 * k], b = q[2 * k + 1];
        const Vec3 u(std::sin(a), 0.0, std::cos(a));
        const Vec3 knee =
            device.chain[k].base + device.chain[k].link1.length * (std::cos(b) * u + std::sin(b) * Vec3::UnitY());
        const Vec3 tip =
            knee + device.chain[k].link2.length * (std::cos(b + elbow[k]) * u + std::sin(b + elbow[k]) * Vec3::UnitY());
        CHECK((tip - c.pose.position - c.pose.rotation * device.chain[k].platform).norm() < 1e-15);
        CHECK(elbow[k] * device.chain[k].elbow > 0.0);
      }
    }
  }
}

TEST_CASE("the Jacobian is the derivative of the inverse kinematics", "[kinematics]") {
  for (const TauParameters& device : test::someDevices()) {
    const TauModel model = makeModel(device);
    test::Random random(6);
    for (int i = 0; i < 50; ++i) {
      const Pose pose = random.workspacePose(0.3);
      const TauConfiguration c = configurationAt(model, pose);
      Mat6 differences;
      // Fourth-order central differences: truncation is h^4 / 30 times the fifth derivative (1 / length^5, about 1e6),
      // 3e-11 of the entries (about 10). Rounding is 1e-16 / h = 1e-13.
      const double h = 1e-4;
      for (int k = 0; k < 6; ++k) {
        const auto at = [&](double step) {
          Pose moved = pose;
          if (k < 3)
            moved.position[k] += step;
          else
            moved.rotation = test::rotationAbout(Vec3::Unit(k - 3), step) * pose.rotation;
          return jointAngles(configurationAt(model, moved));
        };
        differences.col(k) = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
      }
      const Mat6 inverse = inverseJacobian(model, c);
      CHECK(relativeError(inverse, differences) < 1e-9);
      const Mat6 j = jacobian(model, c);
      CHECK(relativeError(j * inverse, Mat6::Identity()) < 1e-12);  // condition number up to a few hundred
      const Vec6 rates = random.vector6(3.0, 3.0);
      const Vec6 twist = twistFromRates(model, c, rates);
      CHECK(relativeError(twist, j * rates) < 1e-13);
      CHECK(relativeError(jointRates(model, c, twist), rates) < 1e-12);
      const Vec6 torque = random.vector6(2.0, 2.0);
      CHECK(relativeError(j.transpose() * wrenchFromTorques(model, c, torque), torque) < 1e-12);
    }
  }
}

TEST_CASE("the envelope of the nominal device", "[kinematics]") {
  // 27 positions x 9 orientations: corners, faces and centre of the cube, 0 and +-10 deg about pairs of axes.
  const TauModel model = makeModel(test::nominal());
  double worstCondition = 1.0, worstElbow = 1.0;
  for (int p = 0; p < 27; ++p)
    for (int o = 0; o < 9; ++o) {
      Pose pose;
      pose.position = 0.025 * Vec3(p % 3 - 1, p / 3 % 3 - 1, p / 9 - 1);
      const double ten = 10.0 * M_PI / 180.0;
      const Vec3 euler = o == 0
                             ? Vec3(Vec3::Zero())
                             : Vec3(ten * (o - 1 & 1 ? 1 : -1), ten * (o - 1 & 2 ? 1 : -1), ten * (o - 1 & 4 ? 1 : -1));
      pose.rotation = rotationFromEuler(euler);
      const TauConfiguration c = configurationAt(model, pose);
      worstCondition = std::min(worstCondition, inverseCondition(jacobian(model, c), 0.04));
      worstElbow = std::min(worstElbow, singularity(model, c).elbow);
    }
  CHECK(worstCondition == Approx(0.275).margin(0.001));
  CHECK(worstElbow == Approx(0.67).margin(0.01));
}

TEST_CASE("singularities are measured and refused", "[kinematics]") {
  const TauModel model = makeModel(test::nominal());
  const TauConfiguration home = model.home;
  CHECK(singularity(model, home).elbow > 0.9);
  CHECK(singularity(model, home).parallel > 0.1);

  TauConfiguration c = home;
  Pose far;
  far.position = {0.5, 0.0, 0.0};
  CHECK(inverseKinematics(model, far, c) == Status::unreachable);
  CHECK(c.pose.position == home.pose.position);  // unchanged

  // A tip on its yaw axis: move the platform point of chain 1 above its base.
  Pose above;
  above.position = model.chain[0].base + Vec3(0.0, 0.12, 0.0) - model.chain[0].platform;
  CHECK(inverseKinematics(model, above, c) == Status::singular);

  // A straight elbow: move the tip of chain 3 out along the line from its base.
  const Vec3 reach = model.chain[2].platform - model.chain[2].base;
  Pose straight;
  straight.position = reach.normalized() * (model.chain[2].length1 + model.chain[2].length2) - reach;
  CHECK(inverseKinematics(model, straight, c) == Status::singular);
}

TEST_CASE("bad input gets a status and leaves the output", "[kinematics]") {
  const TauModel model = makeModel(test::nominal());
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    for (int k = 0; k < 6; ++k) {
      Vec6 q = model.homeAngles;
      q[k] = bad;
      TauConfiguration c = model.home;
      CHECK(forwardKinematics(model, q, c).status == Status::notFinite);
      CHECK(forwardKinematicsFromHome(model, q, c).status == Status::notFinite);
      CHECK(finite(c));
    }
    for (int k = 0; k < 3; ++k) {
      Pose pose;
      pose.position[k] = bad;
      Vec6 q = model.homeAngles;
      CHECK(inverseKinematics(model, pose, q) == Status::notFinite);
      CHECK(q == model.homeAngles);
    }
  }
  Vec6 huge = Vec6::Constant(1e300);
  TauConfiguration c = model.home;
  CHECK(forwardKinematics(model, huge, c).status != Status::notFinite);
  CHECK(finite(c));
}

TEST_CASE("joint angles may wind: whole turns change nothing", "[kinematics]") {
  const TauModel model = makeModel(test::nominal());
  test::Random random(8);
  const Pose pose = random.workspacePose();
  const Vec6 q = jointAngles(configurationAt(model, pose));
  TauConfiguration c;
  Vec6 wound = q;
  wound[0] += 2.0 * M_PI;
  wound[5] -= 4.0 * M_PI;
  REQUIRE(forwardKinematicsFromHome(model, wound, c).status == Status::ok);
  CHECK((c.pose.position - pose.position).norm() < 1e-14);
}

}  // namespace enamel::test_kinematics
