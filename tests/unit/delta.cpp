// The delta: geometry and dynamics compared with an assembled closed-loop system, the workspace of the shipped device,
// singularities, strict files.
#include <algorithm>

#include "enamel/core/error.hpp"
#include "enamel/device/delta/dynamics.hpp"
#include "enamel/device/delta/mechanism.hpp"
#include "support/assembled_delta.hpp"
#include "support/catch.hpp"
#include "support/deltas.hpp"
#include "support/relative_error.hpp"
#include "support/run_length.hpp"

namespace enamel::test_delta {
using test::AssembledDelta;
using test::relativeError;

namespace {

DeltaConfiguration configurationAt(const DeltaModel& model, const Vec3& position) {
  DeltaConfiguration c;
  REQUIRE(inverseKinematics(model, position, c) == Status::ok);
  return c;
}

// Return the smallest of the distances from the singularities.
double regularity(const DeltaConfiguration& c) {
  double least = c.parallel;
  for (const DeltaLeg& leg : c.leg) least = std::min({least, leg.sinElbow, leg.sin3});
  return least;
}

// Visit a grid of positions in a cube about home.
template <typename Visit>
void overCube(double halfWidth, Visit visit) {
  constexpr int steps = 11;
  for (int i = 0; i < steps * steps * steps; ++i)
    visit(halfWidth * Vec3(i % steps - 5, i / steps % steps - 5, i / steps / steps - 5) / 5.0);
}

}  // namespace

TEST_CASE("delta: the loops close, and the rates are those of the closed loops", "[delta]") {
  constexpr std::uint64_t seed = 811;
  test::Random random(seed);
  for (const auto& [device, cube] : test::someDeltas()) {
    INFO(device.name << ", seed " << seed);
    const DeltaModel model = makeModel(device);
    for (int i = 0; i < test::count(200, 2000); ++i) {
      const Vec3 position = random.vector(cube), velocity = random.vector(0.5);
      const DeltaConfiguration c = configurationAt(model, position);
      const AssembledDelta assembled(device, jointAngles(c), position, velocity, Vec3::Zero(), Mat3::Zero());
      CHECK(assembled.closureError() < 1e-14);  // lengths of 0.2 m, rates of 20 rad/s times 0.1 m
      const Vec3 rates = assembled.drivenRates();
      for (int k = 0; k < 3; ++k) CHECK(c.leg[k].row.dot(velocity) == Approx(rates[k]).epsilon(1e-11).margin(1e-11));
      CHECK(relativeError(jacobian(c) * rates, velocity) < 1e-11);
    }
  }
}

TEST_CASE("delta: forward dynamics equal an assembled system with loop closures", "[delta]") {
  constexpr std::uint64_t seed = 812;
  test::Random random(seed);
  for (const auto& [device, cube] : test::someDeltas()) {
    INFO(device.name << ", seed " << seed);
    const DeltaMechanism mechanism(device);
    double worst = 0.0;
    for (int i = 0; i < test::count(100, 2000); ++i) {
      Pose pose;
      pose.position = random.vector(cube);
      Vec6 twist;
      twist << random.vector(1.0), Vec3::Zero();
      const Vec3 torque = random.vector(1.0);
      // The assembled platform could turn. It has a tensor, an eccentric centre of mass, and moments act on it.
      const Vec6 wrench = random.vector6(10.0, 0.3);
      const Vec3 com = random.vector(0.03);
      const Mat3 inertia = test::randomInertia(random, device.platform.mass, 0.03);
      Kinematics k;
      REQUIRE(mechanism.reach(pose, twist, true, k) == Status::ok);
      const AssembledDelta assembled(device, k.q, pose.position, twist.head<3>(), com, inertia);
      const Eigen::Matrix<double, 9, 1> reference = assembled.accelerations(torque, wrench);
      CHECK(assembled.freedoms() == 3);
      Vec6 acceleration;
      REQUIRE(mechanism.accelerate(pose, twist, torque, wrench, acceleration) == Status::ok);
      // A null space of 24 x 21, and a condition number of the inertia of 10: 1e3 rounding errors and some more.
      const double error = relativeError(acceleration.head<3>(), reference.segment<3>(3));
      worst = std::max(worst, error);
      CHECK(error < 1e-11);
      CHECK(acceleration.tail<3>() == Vec3::Zero());
      CHECK(reference.tail<3>().norm() < 1e-8 * reference.segment<3>(3).norm());  // rad compared with m
      // q'' of both: J q'' = v' - J' q', from differences of the rates along the motion.
      const auto ratesAt = [&](double t) {
        Pose moved = pose;
        moved.position += t * twist.head<3>() + 0.5 * t * t * acceleration.head<3>();
        Kinematics there;
        REQUIRE(mechanism.reach(moved, twist + t * acceleration, false, there) == Status::ok);
        return there.rates;
      };
      const double h = 1e-5;
      const JointVector second = (8.0 * (ratesAt(h) - ratesAt(-h)) - (ratesAt(2 * h) - ratesAt(-2 * h))) / (12.0 * h);
      CHECK(relativeError(second, reference.head<3>()) < 1e-7);  // rounding 1e-15 / h of accelerations of 100 rad/s^2
      CHECK(0.5 * k.rates.dot(k.inertia * k.rates) == Approx(assembled.kineticEnergy()).epsilon(1e-11));
    }
    UNSCOPED_INFO("worst relative error " << worst);
  }
}

TEST_CASE("delta: the force that balances gravity is the slope of the potential energy", "[delta]") {
  constexpr std::uint64_t seed = 813;
  test::Random random(seed);
  for (const auto& [device, cube] : test::someDeltas()) {
    INFO(device.name << ", seed " << seed);
    const DeltaModel model = makeModel(device);
    for (int i = 0; i < 50; ++i) {
      const Vec3 position = random.vector(0.9 * cube);
      const auto energyAt = [&, &parameters = device](const Vec3& p) {
        return AssembledDelta(parameters, jointAngles(configurationAt(model, p)), p, Vec3::Zero(), Vec3::Zero(),
                              Mat3::Zero())
            .potentialEnergy();
      };
      Vec3 slope;
      const double h = 3e-5;  // truncation as in the Jacobian's test; rounding 1e-16 J / h
      for (int k = 0; k < 3; ++k) {
        const auto at = [&](double step) { return energyAt(position + step * Vec3::Unit(k)); };
        slope[k] = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
      }
      CHECK(relativeError(gravityForce(model, configurationAt(model, position)), slope) < 1e-8);
    }
  }
}

TEST_CASE("delta: three equal legs 120 deg apart make a device of that symmetry", "[delta]") {
  const DeltaMechanism mechanism(test::desktopDelta());
  const JointVector home = mechanism.home().q;
  for (int i = 0; i < 3; ++i) CHECK(home[i] == Approx(home[0]).epsilon(1e-14));
  test::Random random(814);
  const Mat3 third = test::rotationAbout(Vec3::UnitZ(), -2.0 * M_PI / 3.0);  // rotation from leg to leg
  for (int i = 0; i < 100; ++i) {
    Pose pose, turned;
    pose.position = random.vector(0.025);
    turned.position = third * pose.position;
    Kinematics k, other;
    REQUIRE(mechanism.reach(pose, Vec6::Zero(), true, k) == Status::ok);
    REQUIRE(mechanism.reach(turned, Vec6::Zero(), true, other) == Status::ok);
    for (int j = 0; j < 3; ++j) CHECK(other.q[(j + 1) % 3] == Approx(k.q[j]).margin(1e-14));
  }
}

TEST_CASE("delta: the envelope that the shipped file promises", "[delta]") {
  const DeltaParameters device = test::desktopDelta();
  const DeltaModel model = makeModel(device);
  const DeltaMechanism mechanism(device);
  double least60 = 1.0, least80 = 1.0, weakest = 1e9, atHome = 1e9;
  const auto force = [&](const Vec3& position, double least) {
    Kinematics k;
    REQUIRE(mechanism.reach({position, Mat3::Identity()}, Vec6::Zero(), false, k) == Status::ok);
    for (int axis = 0; axis < 3; ++axis)
      for (const double way : {1.0, -1.0})
        least = std::min(least, largestForce(k, mechanism.limits().effort, k.pose.position, way * Vec3::Unit(axis)));
    return least;
  };
  overCube(0.03, [&](const Vec3& p) {
    least60 = std::min(least60, regularity(configurationAt(model, p)));
    weakest = force(p, weakest);
  });
  overCube(0.04, [&](const Vec3& p) { least80 = std::min(least80, regularity(configurationAt(model, p))); });
  atHome = force(Vec3::Zero(), atHome);
  INFO("60 mm: " << least60 << ", 80 mm: " << least80 << ", force " << weakest << " N, at home " << atHome << " N");
  CHECK(least60 > 0.5);
  CHECK(least80 > 0.25);
  CHECK(atHome > 9.0);
  CHECK(weakest > 5.0);
}

TEST_CASE("delta: singularities are approached and refused", "[delta]") {
  for (const auto& [device, cube] : test::someDeltas()) {
    INFO(device.name);
    const DeltaModel model = makeModel(device);
    test::Random random(815);
    int singular = 0, unreachable = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec3 direction = random.direction();
      double good = 0.0, bad = 1.0;
      DeltaConfiguration c = configurationAt(model, Vec3::Zero());
      REQUIRE(inverseKinematics(model, bad * direction, c) == Status::unreachable);
      CHECK(c.position == Vec3::Zero());  // unchanged
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (good + bad);
        (inverseKinematics(model, middle * direction, c) == Status::ok ? good : bad) = middle;
      }
      CHECK(good > cube);
      // At the edge the pose is just regular, and outside of the edge the reason is reported.
      CHECK(regularity(configurationAt(model, good * direction)) >= kSmallestDeltaMeasure);
      ++(inverseKinematics(model, bad * direction, c) == Status::singular ? singular : unreachable);
      const DeltaConfiguration edge = configurationAt(model, good * direction);
      for (const DeltaLeg& leg : edge.leg) CHECK(leg.row.allFinite());
      CHECK(jacobian(edge).allFinite());
      CHECK(forwardDynamics(model, edge, Vec3::Ones(), Vec3::Ones(), Vec3::Ones()).allFinite());
    }
    INFO("singular " << singular << ", unreachable " << unreachable);
    CHECK(singular > 100);  // the edge is a singularity; at other places a lower link would lean away from the user
  }
}

TEST_CASE("delta: joint angles may wind, and the search does not depend on its start", "[delta]") {
  constexpr std::uint64_t seed = 816;
  for (const auto& [device, cube] : test::someDeltas()) {
    INFO(device.name << ", seed " << seed);
    const DeltaModel model = makeModel(device);
    test::Random random(seed);
    for (int i = 0; i < 200; ++i) {
      const Vec3 position = random.vector(cube);
      Vec3 q = jointAngles(configurationAt(model, position));
      q[i % 3] += 2.0 * M_PI * (i % 5 - 2);
      DeltaConfiguration c;
      c.position = i % 7 == 0 ? Vec3(Vec3::Constant(std::nan(""))) : random.vector(i % 2 == 0 ? 0.05 : 10.0);
      REQUIRE(forwardKinematics(model, q, c) == Status::ok);
      CHECK((c.position - position).norm() < 1e-12);
    }
  }
}

TEST_CASE("delta: joint vectors beyond what closes get a status", "[delta]") {
  const DeltaMechanism mechanism(test::desktopDelta());
  Kinematics k = mechanism.home();
  const JointVector none = JointVector::Zero(3);
  // Arms straight out and forearms inwards past each other: the knees are too far from the axis for the lower links.
  DeltaParameters wide = test::desktopDelta();
  wide.geometry.r = 0.150;
  const DeltaMechanism other(wide);
  Kinematics wideHome = other.home();
  CHECK(other.track(Vec3(0.0, 0.0, 0.0), none, true, wideHome) == Status::unreachable);
  CHECK(wideHome.q == other.home().q);
  // Two arms up and in, one down: the branch of home has no such pose.
  CHECK(mechanism.track(Vec3(-M_PI / 2, -M_PI / 2, M_PI / 2), none, true, k) != Status::ok);
  CHECK(mechanism.track(Vec3(1e300, -1e300, 1e300), none, true, k) != Status::notFinite);
}

namespace {

std::string edited(const std::string& from, const std::string& to) {
  std::string text =
      "kind = \"delta\"\n"
      "name = \"test\"\n"
      "gravity = [0.0, -9.81, 0.0]\n"
      "home_distance = 0.110\n"
      "[geometry]\n"
      "a = 0.060\n"
      "b = 0.1025\n"
      "c = 0.014\n"
      "d = 0.01125\n"
      "e = 0.01125\n"
      "f = -0.025\n"
      "r = 0.03723\n"
      "s = -0.02733\n"
      "phi_deg = [105.0, -15.0, -135.0]\n"
      "[upper_link]\n"
      "mass = 0.050\n"
      "com = 0.020\n"
      "inertia = 3.0e-5\n"
      "[bar]\n"
      "mass = 0.010\n"
      "spacing = 0.030\n"
      "[platform]\n"
      "mass = 0.110\n"
      "[motor]\n"
      "max_torque = 0.8\n"
      "rotor_inertia = 1.2e-4\n"
      "encoder_counts = 9881\n";
  if (from.empty()) return text;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

void requireRefused(const std::string& from, const std::string& to, const std::string& message) {
  INFO(from << " -> " << to);
  try {
    parseDelta(edited(from, to), "device.toml");
    FAIL("accepted");
  } catch (const ConfigurationError& error) {
    CHECK(std::string(error.what()) == message);
  }
}

}  // namespace

TEST_CASE("delta: a bad file is refused with file, line, key, value and limit", "[delta]") {
  const DeltaParameters plain = parseDelta(edited("", ""), "device.toml");
  CHECK(plain.platform.damping == Vec3::Zero());
  CHECK(plain.geometry.phi[1] == Approx(-M_PI / 12.0).epsilon(1e-15));
  CHECK(parseDelta(edited("mass = 0.110", "mass = 0.110\ndamping = [1, 2, 3]"), "f").platform.damping ==
        Vec3(1.0, 2.0, 3.0));
  requireRefused("kind = \"delta\"", "kind = \"tau\"", "device.toml:1: kind: is \"tau\", must be \"delta\" here");
  requireRefused("kind = \"delta\"\n", "", "device.toml:1: kind: is \"tau\", must be \"delta\" here");
  requireRefused("a = 0.060", "a = 0", "device.toml:6: geometry.a: is 0, must be greater than 0 m and finite");
  requireRefused("d = 0.01125", "d = -0.01125",
                 "device.toml:9: geometry.d: is -0.01125, must be at least 0 m and finite");
  requireRefused("r = 0.03723\n", "", "device.toml:5: geometry.r: is missing");
  requireRefused("s = -0.02733", "s = -0.02733\ng = 1",
                 "device.toml:14: geometry.g: is not a known key; possible are a, b, c, d, e, f, phi_deg, r, s");
  requireRefused("105.0, ", "", "device.toml:14: geometry.phi_deg: has 2 elements, must be a list of 3 numbers");
  requireRefused("f = -0.025", "f = 0.1",
                 "device.toml:7: geometry.b: is 0.1025, must be greater than the offset |f - s| = 0.12733 m that the "
                 "bars span across a leg at home");
  requireRefused("home_distance = 0.110", "home_distance = -0.110",
                 "device.toml:4: home_distance: is -0.11, must be greater than 0 m and finite");
  requireRefused("mass = 0.050", "mass = 0",
                 "device.toml:16: upper_link.mass: is 0, must be greater than 0 kg and finite");
  requireRefused("inertia = 3.0e-5", "inertia = -1e-5",
                 "device.toml:18: upper_link.inertia: is -1e-05, must be at least 0 kg m^2 and finite");
  requireRefused("mass = 0.010", "mass = -1", "device.toml:20: bar.mass: is -1, must be greater than 0 kg and finite");
  requireRefused("mass = 0.110", "mass = 0.110\ndamping = [1, -2, 3]",
                 "device.toml:24: platform.damping[1]: is -2, must be at least 0 N s/m and finite");
  requireRefused("max_torque = 0.8", "max_torque = 0",
                 "device.toml:25: motor.max_torque: is 0, must be greater than 0 N m and finite");
  DeltaParameters device = test::desktopDelta();
  device.homeDistance = 0.25;
  CHECK_THROWS_WITH(DeltaMechanism(device),
                    test::ContainsSubstring("device \"Delta desktop\": home_distance: is 0.25, the "
                                            "platform joints are then"));
  device = test::desktopDelta();
  device.geometry.phi[2] = device.geometry.phi[1];  // two legs in one place: nothing holds the platform
  CHECK_THROWS_WITH(DeltaMechanism(device), "device \"Delta desktop\": the home pose is singular");
}

}  // namespace enamel::test_delta
