// The Cartesian device: rotation vectors, their Jacobian, the body's motion, strict files.
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "enamel/core/error.hpp"
#include "enamel/device/cartesian/mechanism.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/relative_error.hpp"
#include "support/run_length.hpp"

namespace enamel::test_cartesian {
using test::relativeError;

namespace {

CartesianParameters shipped(int axes) {
  return loadCartesian(test::deviceFile("cartesian-" + std::to_string(axes) + ".toml"));
}

// Return a device with 6 axes, a full tensor, damping and weight.
CartesianParameters crooked(std::uint64_t seed) {
  test::Random random(seed);
  CartesianParameters device = shipped(6);
  device.gravity = 9.81 * random.direction();
  device.inertia = test::randomInertia(random, device.mass, 0.05);
  device.damping = random.vector6(2.0, 0.01).cwiseAbs();
  return device;
}

JointVector joints(const Vec3& position, const Vec3& turn) {
  JointVector q(6);
  q << position, turn;
  return q;
}

Mat3 rotationOf(const Vec3& turn) {
  return turn.norm() > 0.0 ? test::rotationAbout(turn.normalized(), turn.norm()) : Mat3(Mat3::Identity());
}

}  // namespace

TEST_CASE("cartesian, 3 axes: position in, force out", "[cartesian]") {
  CartesianParameters device = shipped(3);
  device.gravity = {0.0, -2.0, 0.0};
  device.damping.head<3>() = Vec3(1.0, 2.0, 3.0);
  const CartesianMechanism mechanism(device);
  JointVector q(3), rates(3), force(3);
  q << 0.01, -0.02, 0.03;
  rates << 0.1, 0.2, -0.3;
  force << 1.0, -2.0, 0.5;
  Kinematics k = mechanism.home();
  REQUIRE(mechanism.track(q, rates, true, k) == Status::ok);
  CHECK(k.pose.position == Vec3(0.01, -0.02, 0.03));
  CHECK(k.pose.rotation == Mat3::Identity());
  Vec6 twist;
  twist << 0.1, 0.2, -0.3, 0.0, 0.0, 0.0;
  CHECK(k.twist == twist);
  CHECK(k.jacobian == Eigen::MatrixXd::Identity(6, 3));
  CHECK(k.inverseTransposed == Eigen::MatrixXd::Identity(6, 3));
  CHECK(k.gravity == Vec3(0.0, 2.0 * device.mass, 0.0));
  CHECK(k.inertia == device.mass * Mat3::Identity());
  CHECK(mechanism.limits().effort == Vec3::Constant(3.3));
  CHECK(mechanism.limits().encoderStep == Vec3::Constant(5.5e-5));
  CHECK(effectiveMass(k, Vec3::Zero(), Vec3(0.6, 0.0, 0.8)) == Approx(device.mass).epsilon(1e-14));

  // m v' = f + F + m g - D v; the device supports a moment.
  Vec6 wrench, acceleration;
  wrench << 0.3, 0.4, 0.5, 9.0, 9.0, 9.0;
  REQUIRE(mechanism.accelerate(k.pose, twist, force, wrench, acceleration) == Status::ok);
  Vec6 expected = Vec6::Zero();
  for (int i = 0; i < 3; ++i)
    expected[i] = (force[i] + wrench[i] - device.damping[i] * twist[i]) / device.mass + device.gravity[i];
  CHECK(relativeError(acceleration, expected) < 1e-14);
}

TEST_CASE("cartesian: the workspace and the largest turn", "[cartesian]") {
  for (const int axes : {3, 6}) {
    const CartesianParameters device = shipped(axes);
    const CartesianMechanism mechanism(device);
    const JointVector none = JointVector::Zero(axes);
    Kinematics k = mechanism.home();
    Vec6 acceleration;
    for (int i = 0; i < 3; ++i)
      for (const double way : {-1.0, 1.0})
        for (const double share : {1.0, 1.0 + 1e-12}) {
          const Status expected = share > 1.0 ? Status::unreachable : Status::ok;
          JointVector q = none;
          q[i] = way * share * device.halfWidths[i];
          Pose pose;
          pose.position[i] = q[i];
          CHECK(mechanism.track(q, none, false, k) == expected);
          CHECK(mechanism.reach(pose, Vec6::Zero(), false, k) == expected);
          CHECK(mechanism.accelerate(pose, Vec6::Zero(), none, Vec6::Zero(), acceleration) == expected);
        }
  }
  const CartesianMechanism mechanism(shipped(6));
  Kinematics k;
  test::Random random(911);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 axis = random.direction();
    for (const double angle : {2.499999, 2.500001, 2.8, M_PI - 1e-9, M_PI}) {
      const Status expected = angle < kMaxCartesianTurn ? Status::ok : Status::unreachable;
      CHECK(mechanism.reach({Vec3::Zero(), rotationOf(angle * axis)}, Vec6::Zero(), false, k) == expected);
      CHECK(mechanism.track(joints(Vec3::Zero(), angle * axis), JointVector::Zero(6), false, k) == expected);
    }
  }
}

TEST_CASE("cartesian, 6 axes: rotation vectors of every size", "[cartesian]") {
  constexpr std::uint64_t seed = 912;
  INFO("seed " << seed);
  const CartesianMechanism mechanism(crooked(seed));
  test::Random random(seed);
  for (int i = 0; i < test::count(3000, 100000); ++i) {
    // Angles from 1e-12 to 2.49 rad, evenly in their logarithm, so that every branch of the series is used.
    const double angle = 2.49 * std::pow(10.0, -random.uniform(0.0, 12.0));
    const Vec3 turn = angle * random.direction();
    const JointVector q = joints(random.vector(0.06), turn);
    const Vec3 velocity = random.vector(0.5), rate = random.vector(3.0);
    const JointVector rates = joints(velocity, rate);
    Kinematics k;
    REQUIRE(mechanism.track(q, rates, true, k) == Status::ok);
    CHECK((k.pose.rotation - rotationOf(turn)).cwiseAbs().maxCoeff() < 1e-15);  // rounding of numbers up to 1
    CHECK((k.pose.rotation * k.pose.rotation.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 2e-15);
    const Mat3 e = k.jacobian.bottomRightCorner<3, 3>(), inverse = k.inverseTransposed.block<3, 3>(3, 3).transpose();
    CHECK((e * inverse - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-14);  // |E^-1| up to 2
    CHECK(e.determinant() == Approx(std::pow(std::sin(0.5 * angle) / (0.5 * angle), 2)).epsilon(1e-14));
    CHECK((e * turn - turn).norm() < 1e-15 * (1.0 + angle));  // a rotation about its own axis

    Kinematics back;
    REQUIRE(mechanism.reach(k.pose, k.twist, true, back) == Status::ok);
    // From a matrix: rounding of numbers of size 1, and sin 2.49 = 0.6.
    for (int j = 0; j < 6; ++j) {
      CHECK(std::abs(back.q[j] - q[j]) < 2e-15);
      CHECK(std::abs(back.rates[j] - rates[j]) < 1e-13);
    }
  }
}

TEST_CASE("cartesian, 6 axes: V = J q' is the motion of the pose", "[cartesian]") {
  constexpr std::uint64_t seed = 913;
  INFO("seed " << seed);
  const CartesianMechanism mechanism(crooked(seed));
  test::Random random(seed);
  for (int i = 0; i < test::count(1000, 20000); ++i) {
    const Vec3 turn = random.ofLength(0.0, 2.4), rate = random.vector(3.0);
    Kinematics k;
    REQUIRE(mechanism.track(joints(Vec3::Zero(), turn), joints(Vec3(0.1, 0.2, 0.3), rate), false, k) == Status::ok);
    CHECK(k.twist.head<3>() == Vec3(0.1, 0.2, 0.3));
    // [w]x = R' R^T by fourth-order differences: truncation h^4 3^5 / 30 = 1e-11, rounding 1e-16 / h = 1e-13.
    const double h = 1e-3;
    const auto at = [&](double t) { return rotationOf(turn + t * rate); };
    const Mat3 slope = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
    const Vec3 spin = k.twist.tail<3>();
    CHECK((slope * k.pose.rotation.transpose() - crossMatrix(spin)).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("cartesian, 6 axes: a body turns as Euler says", "[cartesian]") {
  constexpr std::uint64_t seed = 914;
  INFO("seed " << seed);
  test::Random random(seed);
  for (int i = 0; i < test::count(500, 10000); ++i) {
    const CartesianParameters device = crooked(random.uniform(0.0, 1.0) < 0.5 ? 1 : 2);
    const CartesianMechanism mechanism(device);
    Pose pose{random.vector(0.06), rotationOf(random.ofLength(0.0, 2.4))};
    const Vec6 twist = random.vector6(0.5, 5.0), wrench = random.vector6(10.0, 0.3);
    const Vec3 push = random.vector(10.0), moment = random.vector(0.3);
    const JointVector torque = joints(push, moment);
    Kinematics k;
    REQUIRE(mechanism.reach(pose, twist, true, k) == Status::ok);
    Vec6 acceleration;
    REQUIRE(mechanism.accelerate(pose, twist, torque, wrench, acceleration) == Status::ok);
    // In the axes of W: I w' + w x I w = E^-T tau + M - D w.
    const Mat3 inertia = pose.rotation * device.inertia * pose.rotation.transpose();
    const Vec3 spin = twist.tail<3>();
    const Vec6 net = wrenchOf(k, torque) + wrench - device.damping.cwiseProduct(twist);
    const Vec3 expected = inertia.inverse() * (net.tail<3>() - spin.cross(inertia * spin));
    CHECK(relativeError(acceleration.tail<3>(), expected) < 1e-12);  // condition number of the tensor
    CHECK(relativeError(acceleration.head<3>(), net.head<3>() / device.mass + device.gravity) < 1e-14);
    const Mat3 e = k.jacobian.bottomRightCorner<3, 3>();
    CHECK(relativeError(k.inertia.bottomRightCorner<3, 3>(), e.transpose() * inertia * e) < 1e-13);
    CHECK(k.inertia.topLeftCorner<3, 3>() == device.mass * Mat3::Identity());
    CHECK(k.inertia.topRightCorner<3, 3>() == Mat3::Zero());
  }
}

namespace {

std::string edited(const std::string& from, const std::string& to) {
  std::string text =
      "kind = \"cartesian\"\n"
      "name = \"test\"\n"
      "axes = 6\n"
      "half_widths = [0.1, 0.2, 0.3]\n"
      "max_force = 20\n"
      "max_moment = 0.4\n"
      "position_step = 1e-6\n"
      "angle_step = 1e-4\n"
      "[platform]\n"
      "mass = 0.2\n"
      "inertia = [4e-4, 4e-4, 2e-4]\n";
  if (from.empty()) return text;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

void requireRefused(const std::string& from, const std::string& to, const std::string& message) {
  INFO(from << " -> " << to);
  try {
    parseCartesian(edited(from, to), "device.toml");
    FAIL("accepted");
  } catch (const ConfigurationError& error) {
    CHECK(std::string(error.what()) == message);
  }
}

}  // namespace

TEST_CASE("cartesian: a bad file is refused with file, line, key, value and limit", "[cartesian]") {
  const CartesianParameters plain = parseCartesian(edited("", ""), "device.toml");
  CHECK(plain.gravity == Vec3::Zero());
  CHECK(plain.damping == Vec6::Zero());
  CHECK(parseCartesian(edited("mass = 0.2", "mass = 0.2\ndamping = [1, 2, 3, 4, 5, 6]"), "f").damping[5] == 6.0);
  CHECK(parseCartesian(edited("axes = 6", "axes = 6\ngravity = [0, -1, 0]"), "f").gravity.y() == -1.0);
  requireRefused("kind = \"cartesian\"", "kind = \"delta\"",
                 "device.toml:1: kind: is \"delta\", must be \"cartesian\" here");
  requireRefused("axes = 6", "axes = 4", "device.toml:3: axes: is 4, must be 3 or 6");
  requireRefused("axes = 6", "axes = 3",
                 "device.toml:6: max_moment: is not allowed with axes = 3: only a device of 6 axes turns");
  requireRefused("0.2, 0.3]", "0, 0.3]", "device.toml:4: half_widths[1]: is 0, must be greater than 0 m and finite");
  requireRefused("max_force = 20", "max_force = -20",
                 "device.toml:5: max_force: is -20, must be greater than 0 N and finite");
  requireRefused("max_moment = 0.4\n", "", "device.toml:1: max_moment: is missing");
  requireRefused("max_moment = 0.4", "max_moment = 0",
                 "device.toml:6: max_moment: is 0, must be greater than 0 N m and finite");
  requireRefused("position_step = 1e-6", "position_step = 0",
                 "device.toml:7: position_step: is 0, must be greater than 0 m and finite");
  requireRefused("angle_step = 1e-4", "angle_step = 0",
                 "device.toml:8: angle_step: is 0, must be greater than 0 rad and finite");
  requireRefused("mass = 0.2", "mass = 0", "device.toml:10: platform.mass: is 0, must be greater than 0 kg and finite");
  requireRefused("mass = 0.2", "mass = 0.2\ndamping = [1, 2, 3, 4, 5, -6]",
                 "device.toml:11: platform.damping[5]: is -6, must be at least 0 N m s/rad and finite");
  requireRefused("mass = 0.2", "mass = 0.2\ncom = [0, 0, 0]",
                 "device.toml:11: platform.com: is not a known key; possible are damping, inertia, mass, mass_table");
  requireRefused("[4e-4, 4e-4, 2e-4]", "[4e-4, 4e-4, 0]",
                 "device.toml:11: platform.inertia: has the principal moment 0, must be greater than 0 kg m^2 for a "
                 "device of 6 axes");
  requireRefused(
      "[4e-4, 4e-4, 2e-4]", "[4e-5, 4e-5, 1e-4]",
      "device.toml:11: platform.inertia: is physically impossible: the largest principal moment is 1e-04, must "
      "be at most the sum of the others, 8e-05 kg m^2");
  CartesianParameters device = shipped(3);
  device.axes = 5;
  CHECK_THROWS_WITH(CartesianMechanism(device), "device \"Cartesian, 3 axes\": axes: is 5, must be 3 or 6");
  device = shipped(3);
  device.mass = std::nan("");
  CHECK_THROWS_AS(CartesianMechanism(device), ConfigurationError);
}

namespace {

std::string stylusFile(const std::string& more, const std::string& platform) {
  return "kind = \"cartesian\"\nname = \"stylus\"\naxes = 6\nhalf_widths = [0.08, 0.06, 0.035]\nmax_force = 3.3\n"
         "position_step = 5e-6\nangle_step = 2e-4\n" +
         more + "\n[platform]\ninertia = [4e-5, 4e-5, 2e-5]\n" + platform;
}

}  // namespace

TEST_CASE("cartesian: imperfections of the drives", "[cartesian]") {
  const auto file = [](const std::string& root, const std::string& imperfections) {
    return "kind = \"cartesian\"\nname = \"driven\"\naxes = 3\nhalf_widths = [0.1, 0.1, 0.1]\nmax_force = 8\n"
           "position_step = 1e-5\n" +
           root + "\n[platform]\nmass = 0.15\n[imperfections]\n" + imperfections;
  };
  const CartesianParameters device =
      parseCartesian(file("rotor_mass = 0.03",
                          "cable_stiffness = 2e5\ncable_damping = 8\ncoulomb_friction = 0.3\n"
                          "current_bandwidth = 1000\nbacklash = 1e-5"),
                     "f");
  const Drive drive = CartesianMechanism(device).limits().drive;
  CHECK(drive.stiffness == 2e5);
  CHECK(drive.damping == 8.0);
  CHECK(drive.rotorInertia == 0.03);
  CHECK(drive.bandwidth == 1000.0);
  CHECK(drive.disturbance == Approx(0.1));
  const auto refuse = [&](const std::string& root, const std::string& imperfections, const std::string& message) {
    CHECK_THROWS_WITH(parseCartesian(file(root, imperfections), "f"), test::ContainsSubstring(message));
  };
  refuse("rotor_mass = 0.15", "", "rotor_mass: is 0.15, must be less than the apparent mass, 0.15 kg");
  refuse("", "cable_stiffness = 2e5", "imperfections.cable_stiffness: needs a rotor_mass greater than 0");
  refuse("", "cable_stiffness = 2e7", "imperfections.cable_stiffness: is 2e+07, must be in 0 to 1e+06 N/m");
  refuse("", "coulomb_friction = -1", "imperfections.coulomb_friction: is -1, must be in 0 to 10 N");
  refuse("", "length_error = 0.01", "imperfections.length_error: is not allowed: a Cartesian device has no lengths");
  refuse("rotor_mass = 0.03\ndriven = [1, 1, 0]", "cable_stiffness = 2e5",
         "imperfections.cable_stiffness: needs axes = 3 with a motor on each of them");
  const auto turning = [](const std::string& keys) {
    return parseCartesian(edited("[platform]", "[imperfections]\n" + keys + "\n[platform]"), "f");
  };
  CHECK(turning("current_bandwidth = 500\njitter = 0.1").imperfections.jitter == 0.1);
  CHECK_THROWS_WITH(turning("cogging = 0.1"), test::ContainsSubstring("not allowed if a rotation has a motor"));
  CHECK_THROWS_WITH(turning("encoder_offset = 1e-3"), test::ContainsSubstring("needs axes = 3: it is in m"));
}

TEST_CASE("axes without a motor are sensed and not driven", "[cartesian]") {
  const std::string driven = "driven = [1, 1, 1, 0, 0, 0]";
  const CartesianMechanism stylus(parseCartesian(stylusFile(driven, "mass = 0.1"), "stylus.toml"));
  CHECK(stylus.joints() == 6);
  CHECK(stylus.limits().effort == (JointVector(6) << 3.3, 3.3, 3.3, 0.0, 0.0, 0.0).finished());
  const JointVector& limits = stylus.limits().effort;
  CHECK(largestForce(stylus.home(), limits, Vec3(0.01, 0.0, 0.0), Vec3::UnitZ()) == 3.3);  // also beside the tip
  const auto refuses = [](const std::string& more, const std::string& words) {
    REQUIRE_THROWS_WITH(parseCartesian(stylusFile(more, "mass = 0.1"), "stylus.toml"), test::ContainsSubstring(words));
  };
  refuses("driven = [1, 1, 1]", "has 3 numbers, must have one for each of the 6 axes");
  refuses("driven = [1, 1, 1, 0, 0, 0.5]", "must be 1 (the axis has a motor) or 0");
  refuses("driven = [0, 0, 0, 0, 0, 0]", "is 0 for every axis, at least one must be 1 (with a motor)");
  refuses("driven = [1, 1, 1, 0, 0, 1]", "max_moment");
}

TEST_CASE("an apparent mass that depends on the position", "[cartesian]") {
  // 50 g on the left, 150 g on the right: linear in x.
  const std::string table = "mass_counts = [2, 2, 2]\nmass_table = [0.05, 0.15, 0.05, 0.15, 0.05, 0.15, 0.05, 0.15]";
  const CartesianMechanism device(parseCartesian(stylusFile("max_moment = 1.0", table), "stylus.toml"));
  const auto massAt = [&](const Vec3& position) {
    Kinematics k;
    REQUIRE(device.reach({position, Mat3::Identity()}, Vec6::Zero(), true, k) == Status::ok);
    return k.inertia(0, 0);
  };
  CHECK(massAt(Vec3::Zero()) == Approx(0.10).epsilon(1e-12));
  CHECK(massAt({-0.08, 0.05, 0.0}) == Approx(0.05).epsilon(1e-12));
  CHECK(massAt({0.04, -0.06, 0.035}) == Approx(0.125).epsilon(1e-12));
  // Kinetic energy changes by the work of the force only, even if the mass changes along the path.
  Pose pose;
  Vec6 twist = (Vec6() << 0.3, 0.1, -0.05, 0.0, 0.0, 0.0).finished();
  const auto energy = [&] { return 0.5 * massAt(pose.position) * twist.head<3>().squaredNorm(); };
  const double before = energy();
  double work = 0.0;
  const Vec6 wrench = (Vec6() << 0.4, -0.2, 0.1, 0.0, 0.0, 0.0).finished();
  constexpr double kStep = 1e-6;
  for (int i = 0; i < 100000; ++i) {
    Vec6 acceleration;
    REQUIRE(device.accelerate(pose, twist, JointVector::Zero(6), wrench, acceleration) == Status::ok);
    const Vec6 half = twist + 0.5 * kStep * acceleration;
    work += kStep * wrench.dot(half);
    pose.position += kStep * half.head<3>();
    twist += kStep * acceleration;
  }
  CHECK(energy() - before == Approx(work).epsilon(1e-4));  // steps of 1 us, of first order
  const auto refuses = [](const std::string& platform, const std::string& words) {
    REQUIRE_THROWS_WITH(parseCartesian(stylusFile("max_moment = 1.0", platform), "stylus.toml"),
                        test::ContainsSubstring(words));
  };
  refuses("mass = 0.1\n" + table, "is given together with mass_table");
  refuses("mass_counts = [2, 2, 3]\nmass_table = [0.1, 0.1]", "has 2 masses, must have the 12 of mass_counts");
  refuses("mass_counts = [1, 2, 2]\nmass_table = [0.1, 0.1]", "whole numbers in 2 to 64");
  refuses("mass_counts = [2, 2, 2]\nmass_table = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, -0.1]", "greater than 0 kg");
}

}  // namespace enamel::test_cartesian
