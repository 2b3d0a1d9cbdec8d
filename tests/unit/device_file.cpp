// Strict device files: the accepted ones, and the message for every error.
#include "enamel/device/device_file.hpp"

#include <string>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/tau/model.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_device_file {

namespace {

// Return a device file with one piece of text replaced.
std::string edited(const std::string& from, const std::string& to) {
  std::string text =
      "name = \"test\"\n"
      "gravity = [0.0, -9.81, 0.0]\n"
      "[[chain]]\n"
      "base     = [ 0.115, -0.080, -0.050]\n"
      "platform = [ 0.037,  0.030, -0.014]\n"
      "link1 = { length = 0.088, mass = 0.045, radius = 0.004 }\n"
      "link2 = { length = 0.132, mass = 0.025, com = [0, 0, 0.066], inertia = [4e-5, 4e-5, 1e-6] }\n"
      "elbow = 1\n"
      "[[chain]]\n"
      "base     = [-0.115, -0.080, -0.050]\n"
      "platform = [-0.037,  0.030, -0.014]\n"
      "link1 = { length = 0.088, mass = 0.045, radius = 0.004 }\n"
      "link2 = { length = 0.132, mass = 0.025, radius = 0.004 }\n"
      "elbow = 1\n"
      "[[chain]]\n"
      "base     = [ 0.000,  0.014, -0.080]\n"
      "platform = [ 0.000, -0.024,  0.014]\n"
      "link1 = { length = 0.060, mass = 0.045, radius = 0.004 }\n"
      "link2 = { length = 0.095, mass = 0.025, radius = 0.004 }\n"
      "elbow = 1\n"
      "[platform]\n"
      "mass = 0.120\n"
      "com = [0.0, 0.0, 0.020]\n"
      "inertia = [6.0e-5, 6.0e-5, 3.0e-5]\n"
      "[motor]\n"
      "max_torque = 2.0\n"
      "rotor_inertia = 1.0e-4\n"
      "encoder_counts = 163840\n";
  if (from.empty()) return text;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

void requireRefused(const std::string& from, const std::string& to, const std::string& message) {
  INFO(from << " -> " << to);
  try {
    parseTau(edited(from, to), "device.toml");
    FAIL("accepted");
  } catch (const ConfigurationError& error) {
    INFO(error.what());
    CHECK(std::string(error.what()) == message);
  }
}

}  // namespace

TEST_CASE("the shipped device files load", "[device_file]") {
  const TauParameters nominal = test::nominal(), detailed = test::detailed();
  CHECK(nominal.name == "TAU nominal");
  CHECK(nominal.chain[0].link2.length == 0.132);
  CHECK(detailed.chain[1].link1.com == Vec3(-0.003, -0.002, 0.031));
  CHECK(detailed.platform.inertia(1, 2) == -9.0e-6);
  // A uniform rod: m (3 r^2 + L^2) / 12 across, m r^2 / 2 along, centre at half the length.
  CHECK(nominal.chain[0].link1.com == Vec3(0.0, 0.0, 0.044));
  CHECK(nominal.chain[0].link1.inertia(0, 0) ==
        Approx(0.045 * (3 * 0.004 * 0.004 + 0.088 * 0.088) / 12).epsilon(1e-15));
  CHECK(nominal.chain[0].link1.inertia(2, 2) == Approx(0.045 * 0.004 * 0.004 / 2).epsilon(1e-15));
  CHECK_NOTHROW(makeModel(nominal));
  CHECK_NOTHROW(makeModel(detailed));
}

TEST_CASE("optional keys default to zero and are read where they stand", "[device_file]") {
  const TauParameters plain = parseTau(edited("", ""), "device.toml");
  CHECK(plain.motor.viscousFriction == 0.0);
  CHECK(plain.platform.damping == Vec6::Zero());
  CHECK(parseTau(edited("max_torque = 2.0", "max_torque = 2.0\nviscous_friction = 0.01"), "f").motor.viscousFriction ==
        0.01);
  CHECK(parseTau(edited("mass = 0.120", "mass = 0.120\ndamping = [0, 0, 4, 0, 0, 0.5]"), "f").platform.damping[2] ==
        4.0);
}

TEST_CASE("a bad device file is refused with file, line, key, value and limit", "[device_file]") {
  requireRefused("elbow = 1", "elbow = 1\nelbwo = 1",
                 "device.toml:9: chain[0].elbwo: is not a known key; possible are base, elbow, link1, link2, platform");
  requireRefused("com = [0.0, 0.0, 0.020]", "com = [0.0, 0.0, 0.020]\ndampng = [0, 0, 4, 0, 0, 0]",
                 "device.toml:24: platform.dampng: is not a known key; is it damping?");
  requireRefused("mass = 0.120\n", "", "device.toml:21: platform.mass: is missing");
  for (const char* almost : {"mas", "masss", "mess", "amss", "mas s"})
    requireRefused("mass = 0.120\n", std::string("\"") + almost + "\" = 0.120\n",
                   std::string("device.toml:21: platform.mass: is missing; is it ") + almost + " of line 22?");
  requireRefused("mass = 0.120\n", "mast2 = 0.120\n", "device.toml:21: platform.mass: is missing");
  requireRefused("name = \"test\"", "name = 3", "device.toml:1: name: is an integer, must be a string");
  requireRefused("mass = 0.120", "mass = \"heavy\"", "device.toml:22: platform.mass: is a string, must be a number");
  requireRefused("mass = 0.120", "mass = nan", "device.toml:22: platform.mass: is nan, must be finite");
  requireRefused("length = 0.088", "length = 0.0",
                 "device.toml:6: chain[0].link1.length: is 0, must be greater than 0 m and finite");
  requireRefused("mass = 0.045", "mass = -0.045",
                 "device.toml:6: chain[0].link1.mass: is -0.045, must be greater than 0 kg and finite");
  requireRefused("radius = 0.004", "radius = 0.0",
                 "device.toml:6: chain[0].link1.radius: is 0, must be greater than 0 m");
  requireRefused("radius = 0.004", "radius = 0.004, com = [0, 0, 0]",
                 "device.toml:6: chain[0].link1.radius: is given together with com or inertia: give either radius "
                 "(a uniform rod) or com and inertia");
  requireRefused(
      "inertia = [4e-5, 4e-5, 1e-6]", "inertia = [4e-5, 4e-5, 1e-4]",
      "device.toml:7: chain[0].link2.inertia: is physically impossible: the largest principal moment is 1e-04, must be "
      "at most the sum of the others, 8e-05 kg m^2");
  requireRefused("inertia = [4e-5, 4e-5, 1e-6]", "inertia = [4e-5, 4e-5, -1e-6]",
                 "device.toml:7: chain[0].link2.inertia: has the principal moment -1e-06, must be at least 0 kg m^2");
  requireRefused(
      "inertia = [4e-5, 4e-5, 1e-6]", "inertia = [[4e-5, 1e-6, 0], [0, 4e-5, 0], [0, 0, 1e-5]]",
      "device.toml:7: chain[0].link2.inertia: is not symmetric: element (0,1) is 1e-06 and (1,0) is 0 kg m^2");
  requireRefused("elbow = 1", "elbow = 0", "device.toml:8: chain[0].elbow: is 0, must be 1 or -1");
  requireRefused("elbow = 1", "elbow = 1.0", "device.toml:8: chain[0].elbow: is a number, must be an integer");
  requireRefused("[ 0.037,  0.030, -0.014]", "[ 0.037,  0.030]",
                 "device.toml:5: chain[0].platform: has 2 elements, must be a list of 3 numbers");
  requireRefused("[ 0.037,  0.030, -0.014]", "[ 0.037,  true, -0.014]",
                 "device.toml:5: chain[0].platform[1]: is a boolean, must be a number");
  requireRefused("base     = [ 0.115, -0.080, -0.050]", "base     = [ 0.337, 0.030, -0.014]",
                 "device.toml:5: chain[0].platform: is [0.037, 0.03, -0.014] m, 0.30000000000000004 m from the base at "
                 "home: the links of this chain close between 0.04400000000000001 and 0.22 m");
  requireRefused("[ 0.000, -0.024,  0.014]", "[ 0.010, 0.030,  -0.014]",
                 "device.toml:17: chain[2].platform: is [0.01, 0.03, -0.014] m: the three platform points lie on one "
                 "line, they must span a plane");
  requireRefused("encoder_counts = 163840", "encoder_counts = 0",
                 "device.toml:28: motor.encoder_counts: is 0, must be greater than 0 per revolution and finite");
  requireRefused("[motor]", "[[chain]]\nbase = [0,0,0]\n[motor]",
                 "device.toml:3: chain: occurs 4 times, a TAU has exactly 3 chains");
}

TEST_CASE("imperfections are read, and refused beyond their range", "[device_file]") {
  const std::string motor = "encoder_counts = 163840\n";
  const auto with = [&](const std::string& keys) { return motor + "[imperfections]\n" + keys; };
  CHECK(parseTau(edited("", ""), "f").imperfections.cableStiffness == 0.0);
  const Imperfections read =
      parseTau(edited(motor, with("cable_stiffness = 200\nbacklash = 1e-4\njitter = 0.1\n")), "f").imperfections;
  CHECK(read.cableStiffness == 200.0);
  CHECK(read.backlash == 1e-4);
  CHECK(read.jitter == 0.1);
  requireRefused(motor, with("backlash = 1e-4\n"),
                 "device.toml:30: imperfections.backlash: needs a cable_stiffness greater than 0");
  requireRefused(motor, with("mass_error = 0.5\n"),
                 "device.toml:30: imperfections.mass_error: is 0.5, must be in 0 to 0.2 of the mass");
  requireRefused(motor, with("coulomb_friction = -1\n"),
                 "device.toml:30: imperfections.coulomb_friction: is -1, must be in 0 to 10 N m");
  requireRefused(
      motor, with("springs = 1\n"),
      "device.toml:30: imperfections.springs: is not a known key; possible are backlash, cable_damping, "
      "cable_stiffness, cogging, "
      "coulomb_friction, current_bandwidth, encoder_offset, jitter, length_error, lost_samples, mass_error, periods, "
      "torque_ripple, torque_step");
  TauParameters device = test::nominal();
  device.imperfections.cableStiffness = 200.0;
  CHECK_NOTHROW(checkTau(device));
  device.motor.rotorInertia = 0.0;
  CHECK_THROWS_WITH(checkTau(device), test::ContainsSubstring("motor.rotor_inertia greater than 0"));
}

TEST_CASE("malformed TOML and unreadable files are refused", "[device_file]") {
  try {
    parseTau("name = \"a\"\ngravity = [0, 1\n", "broken.toml");
    FAIL("accepted");
  } catch (const ConfigurationError& error) {
    CHECK(error.file() == "broken.toml");
    CHECK(error.line() >= 2);
    CHECK(std::string(error.what()).find("not valid TOML") != std::string::npos);
  }
  CHECK_THROWS_WITH(loadTau("no/such/file.toml"), "no/such/file.toml: cannot open the file: No such file or directory");
  CHECK_THROWS_AS(loadTau("."), ConfigurationError);
}

TEST_CASE("parameters that came from no file are checked alike", "[device_file]") {
  TauParameters device = test::nominal();
  device.chain[1].link2.mass = 0.0;
  CHECK_THROWS_WITH(makeModel(device),
                    "device \"TAU nominal\": chain[1].link2.mass: is 0, must be greater than 0 kg and finite");
  device = test::nominal();
  device.chain[1].elbow = 2;
  CHECK_THROWS_AS(makeModel(device), ConfigurationError);
  device = test::nominal();
  device.gravity[0] = std::nan("");
  CHECK_THROWS_AS(makeModel(device), ConfigurationError);
}

TEST_CASE("a device file says its kind", "[device_file]") {
  const auto load = [](const std::string& name) { return loadDevice(test::deviceFile(name)); };
  CHECK(std::holds_alternative<TauParameters>(load("tau-nominal.toml")));
  CHECK(std::holds_alternative<TauParameters>(load("tau-detailed.toml")));
  CHECK(std::holds_alternative<DeltaParameters>(load("delta.toml")));
  CHECK(std::get<CartesianParameters>(load("cartesian-3.toml")).axes == 3);
  CHECK(std::get<CartesianParameters>(load("cartesian-6.toml")).axes == 6);
  // Files without a kind describe a TAU.
  CHECK(std::holds_alternative<TauParameters>(parseDevice(edited("", ""), "f")));
  CHECK(std::holds_alternative<TauParameters>(parseDevice(edited("name =", "kind = \"tau\"\nname ="), "f")));
  CHECK_THROWS_WITH(parseDevice(edited("name =", "kind = \"stewart\"\nname ="), "device.toml"),
                    "device.toml:1: kind: is \"stewart\", must be \"tau\", \"delta\" or \"cartesian\"");
  CHECK_THROWS_WITH(loadDevice(ENAMEL_SOURCE_DIR "/data/scenes/molar.toml"),
                    test::ContainsSubstring(": obstacle: this is a scene file, a device file is needed"));
  CHECK_THROWS_WITH(parseDevice(edited("name =", "kind = 3\nname ="), "device.toml"),
                    "device.toml:1: kind: is an integer, must be a string");
  CHECK_THROWS_WITH(parseDevice(edited("name =", "kind = \"delta\"\nname ="), "device.toml"),
                    "device.toml:1: home_distance: is missing");
  CHECK_THROWS_WITH(loadTau(test::deviceFile("delta.toml")), test::ContainsSubstring("must be \"tau\" here"));
}

TEST_CASE("the shipped delta has the published dimensions", "[device_file]") {
  const DeltaParameters delta = loadDelta(test::deviceFile("delta.toml"));
  const DeltaGeometry& g = delta.geometry;
  CHECK(g.a == 0.060);
  CHECK(g.b == 0.1025);
  CHECK(g.c == 0.014);
  CHECK(g.d == 0.01125);
  CHECK(g.e == 0.01125);
  CHECK(g.f == -0.025);
  CHECK(g.r == 0.03723);
  CHECK(g.s == -0.02733);
  for (int i = 0; i < 3; ++i) CHECK(g.phi[i] == Approx((105.0 - 120.0 * i) * M_PI / 180.0).epsilon(1e-15));
}

TEST_CASE("damping, friction and mass are added to every kind", "[device_file]") {
  Vec6 damping;
  damping << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  for (const std::string file :
       {"tau-nominal.toml", "delta.toml", "cartesian-3.toml", "cartesian-6.toml", "stylus.toml"}) {
    INFO(file);
    const DeviceParameters before = loadDevice(test::deviceFile(file));
    DeviceParameters after = before;
    addDamping(after, damping);
    addFriction(after, 0.5);
    addMass(after, 0.25);
    if (const auto* tau = std::get_if<TauParameters>(&after)) {
      const TauParameters& plain = std::get<TauParameters>(before);
      CHECK(tau->platform.damping == plain.platform.damping + damping);
      CHECK(tau->motor.viscousFriction == plain.motor.viscousFriction + 0.5);
      CHECK(tau->platform.mass == plain.platform.mass + 0.25);
    } else if (const auto* delta = std::get_if<DeltaParameters>(&after)) {
      const DeltaParameters& plain = std::get<DeltaParameters>(before);
      CHECK(delta->platform.damping == plain.platform.damping + damping.head<3>());
      CHECK(delta->motor.viscousFriction == plain.motor.viscousFriction + 0.5);
      CHECK(delta->platform.mass == plain.platform.mass + 0.25);
    } else {
      const CartesianParameters& plain = std::get<CartesianParameters>(before);
      const CartesianParameters& device = std::get<CartesianParameters>(after);
      for (int i = 0; i < 6; ++i) CHECK(device.damping[i] == (i < plain.axes ? damping[i] + 0.5 : 0.0));
      CHECK(device.mass == plain.mass + 0.25);
      for (std::size_t i = 0; i < plain.massTable.mass.size(); ++i)
        CHECK(device.massTable.mass[i] == plain.massTable.mass[i] + 0.25);
    }
    CHECK_NOTHROW(makeMechanism(after));
  }
}

TEST_CASE("a handpiece in a device file is the one that a program adds", "[device_file]") {
  const std::string table =
      "\n[handpiece]\nmass = 0.085\ncom = [0.002, -0.001, 0.06]\ninertia = [8e-5, 8.2e-5, 5e-6]\n";
  Handpiece h;
  h.mass = 0.085;
  h.com = Vec3(0.002, -0.001, 0.06);
  h.inertia = Vec3(8e-5, 8.2e-5, 5e-6).asDiagonal();
  for (const std::string file : {"tau-nominal.toml", "delta.toml", "cartesian-3.toml"}) {
    INFO(file);
    const std::string text = readFile(test::deviceFile(file));
    DeviceParameters added = parseDevice(text, file);
    addHandpiece(added, h);
    const auto a = makeMechanism(added), b = makeMechanism(parseDevice(text + table, file));
    Pose pose;
    pose.position = Vec3(0.01, -0.02, 0.015);
    Kinematics one, two;
    REQUIRE(a->reach(pose, Vec6::Zero(), true, one) == Status::ok);
    REQUIRE(b->reach(pose, Vec6::Zero(), true, two) == Status::ok);
    CHECK(one.inertia == two.inertia);
    CHECK(one.gravity == two.gravity);
  }
  const std::string text = readFile(test::deviceFile("cartesian-6.toml"));
  CHECK_THROWS_WITH(parseDevice(text + "\n[handpiece]\nmass = -1.0\n", "d.toml"),
                    test::ContainsSubstring("d.toml:") && test::ContainsSubstring("mass is -1, must be at least 0 kg"));
  CHECK_THROWS_WITH(parseDevice(text + table, "d.toml"), test::ContainsSubstring("must have its mass at the TCP"));
  CHECK_THROWS_WITH(parseDevice(text + "\n[handpiece]\n", "d.toml"), test::ContainsSubstring("mass"));
  CHECK_THROWS_WITH(parseDevice(text + "\n[handpiece]\nmass = 0.1\nlength = 1.0\n", "d.toml"),
                    test::ContainsSubstring("length"));
}

TEST_CASE("a handpiece has its mass and its weight in the model", "[device_file]") {
  Handpiece h;
  h.mass = 0.085;
  h.com = Vec3(0.002, -0.001, 0.06);
  h.inertia = Vec3(8e-5, 8.2e-5, 5e-6).asDiagonal();
  for (const std::string file : {"tau-nominal.toml", "tau-detailed.toml", "delta.toml", "cartesian-3.toml"}) {
    INFO(file);
    const DeviceParameters before = loadDevice(test::deviceFile(file));
    DeviceParameters after = before;
    addHandpiece(after, h);
    const auto plain = makeMechanism(before), heavy = makeMechanism(after);
    Pose pose;
    pose.position = Vec3(0.01, -0.02, 0.015);
    if (plain->joints() == 6) pose.rotation = Eigen::AngleAxisd(0.2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
    Kinematics a, b;
    REQUIRE(plain->reach(pose, Vec6::Zero(), true, a) == Status::ok);
    REQUIRE(heavy->reach(pose, Vec6::Zero(), true, b) == Status::ok);
    // Kinetic energy: the body moves with the platform. Where that does not turn, its centre of mass moves as the TCP.
    const Mat3 R = a.pose.rotation;
    const Vec3 arm = R * h.com;
    Mat6 body = Mat6::Zero();
    Mat3 cross;
    cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
    body.topLeftCorner<3, 3>() = h.mass * Mat3::Identity();
    body.topRightCorner<3, 3>() = -h.mass * cross;
    body.bottomLeftCorner<3, 3>() = h.mass * cross;
    body.bottomRightCorner<3, 3>() = R * h.inertia * R.transpose() - h.mass * cross * cross;
    const Eigen::MatrixXd J = a.jacobian;
    const Eigen::MatrixXd difference = b.inertia - a.inertia, expected = J.transpose() * body * J;
    CHECK((difference - expected).norm() < 1e-9 * b.inertia.norm());
    Vec3 gravity = h.gravity;
    if (const auto* tau = std::get_if<TauParameters>(&before)) gravity = tau->gravity;
    if (const auto* delta = std::get_if<DeltaParameters>(&before)) gravity = delta->gravity;
    Vec6 weight;
    weight << h.mass * gravity, arm.cross(h.mass * gravity);
    const Eigen::VectorXd more = b.gravity - a.gravity, balance = -J.transpose() * weight;
    CHECK((more - balance).norm() < 1e-9 * (1.0 + balance.norm()));
  }
  DeviceParameters six = loadDevice(test::deviceFile("cartesian-6.toml"));
  CHECK_THROWS_WITH(addHandpiece(six, h), test::ContainsSubstring("must have its mass at the TCP"));
  h.com.setZero();
  h.inertia.setZero();
  CHECK_NOTHROW(addHandpiece(six, h));
  h.mass = -1.0;
  CHECK_THROWS_WITH(addHandpiece(six, h), test::ContainsSubstring("the handpiece: mass is -1, must be at least 0 kg"));
}

}  // namespace enamel::test_device_file
