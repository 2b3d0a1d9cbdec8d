// Properties of every mechanism: the shipped devices of all kinds, through the interface only.
#include "enamel/device/mechanism.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <utility>

#include "enamel/core/error.hpp"
#include "enamel/device/cartesian/mechanism.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/mechanisms.hpp"
#include "support/relative_error.hpp"
#include "support/run_length.hpp"

namespace enamel::test_mechanism {
using test::ContainsSubstring;
using test::relativeError;

namespace {

// Return the largest entry. Everything that is compared bit by bit uses this one reduction of dynamic size.
double largest(const Eigen::MatrixXd& m) { return m.cwiseAbs().maxCoeff(); }

bool same(const Kinematics& a, const Kinematics& b) {
  return a.q == b.q && a.rates == b.rates && a.pose.position == b.pose.position && a.pose.rotation == b.pose.rotation &&
         a.twist == b.twist && a.jacobian == b.jacobian && a.inverseTransposed == b.inverseTransposed &&
         a.gravity == b.gravity && a.inertia == b.inertia;
}

Kinematics reached(const Mechanism& mechanism, const Pose& pose, const Vec6& twist) {
  Kinematics k;
  REQUIRE(mechanism.reach(pose, twist, true, k) == Status::ok);
  return k;
}

Pose moved(const Pose& pose, const Vec6& by) {
  Pose result = pose;
  result.position += by.head<3>();
  const Vec3 turn = by.tail<3>();
  if (turn.norm() > 0.0) result.rotation = test::rotationAbout(turn.normalized(), turn.norm()) * pose.rotation;
  return result;
}

void setFriction(TauParameters& p, double friction) { p.motor.viscousFriction = friction; }
void setFriction(DeltaParameters& p, double friction) { p.motor.viscousFriction = friction; }
void setFriction(CartesianParameters&, double) {}

// Gravity if a file leaves it to the vendor, and no friction: the balances below assume both.
std::shared_ptr<const Mechanism> frictionless(const test::Shipped& shipped) {
  DeviceParameters parameters = shipped.parameters();
  std::visit(
      [](auto& p) {
        setFriction(p, 0.0);
        p.gravity = {0.3, -9.7, 1.1};
      },
      parameters);
  return makeMechanism(parameters);
}

// A mechanism with three axes and one error.
class Spoilt final : public Mechanism {
 public:
  using Change = std::function<void(Kinematics&, bool isTrack)>;
  explicit Spoilt(Change change, int motors = 3)
      : Mechanism("spoilt", JointLimits{JointVector::Ones(motors), JointVector::Ones(3)}),
        sound_(loadCartesian(test::deviceFile("cartesian-3.toml"))) {
    setHome();
    change_ = std::move(change);
  }
  Status track(const JointVector& q, const JointVector& rates, bool withInertia,
               Kinematics& kinematics) const noexcept override {
    const Status status = sound_.track(q, rates, withInertia, kinematics);
    if (status == Status::ok && change_) change_(kinematics, true);
    return status;
  }
  Status reach(const Pose& pose, const Vec6& twist, bool withInertia, Kinematics& kinematics) const noexcept override {
    const Status status = sound_.reach(pose, twist, withInertia, kinematics);
    if (status == Status::ok && change_) change_(kinematics, false);
    return status;
  }
  Status accelerate(const Pose&, const Vec6&, const JointVector&, const Vec6&, Vec6&) const noexcept override {
    return Status::inactive;
  }
  std::vector<Bar> bars(const Pose&) const override { return {}; }

 private:
  CartesianMechanism sound_;
  Change change_;
};

}  // namespace

TEST_CASE("every mechanism passes its check; a wrong one is refused with the quantity that is wrong", "[mechanism]") {
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto mechanism = shipped.mechanism();
    checkMechanism(*mechanism, Pose{});
    test::Random random(41);
    for (int i = 0; i < 20; ++i) checkMechanism(*mechanism, shipped.pose(random));
  }
  const double bad = std::nan("");
  using Wrong = std::pair<const char*, Spoilt::Change>;
  for (const auto& [text, change] : {
           Wrong{"reach() at the start pose: the Jacobian has 6 x 2 numbers, must have 6 x 3",
                 [](Kinematics&k, bool) { k.jacobian.setOnes(6, 2); }},
           Wrong{"the Jacobian is zero, so the motors cannot push", [](Kinematics&k, bool) { k.jacobian.setZero(); }},
           Wrong{"the Jacobian is not finite", [bad](Kinematics&k, bool) { k.jacobian(0, 0) = bad; }},
           Wrong{"the transposed inverse of the Jacobian has 6 x 0 numbers",
                 [](Kinematics&k, bool) { k.inverseTransposed.resize(6, 0); }},
           Wrong{"the inverse does not belong to the Jacobian",
                 [](Kinematics&k, bool) { k.inverseTransposed.setZero(); }},
           Wrong{"the inverse does not belong to the Jacobian", [](Kinematics&k, bool) { k.jacobian *= 2.0; }},
           Wrong{"the vector of joint coordinates has 2 numbers, must have 3",
                 [](Kinematics&k, bool) { k.q.setZero(2); }},
           Wrong{"the vector of joint rates is not finite", [bad](Kinematics&k, bool) { k.rates[2] = bad; }},
           Wrong{"the gravity torque has 4 numbers", [](Kinematics&k, bool) { k.gravity.setZero(4); }},
           Wrong{"the rotation is not", [](Kinematics&k, bool) { k.pose.rotation *= 2.0; }},
           Wrong{"the position is not finite", [bad](Kinematics&k, bool) { k.pose.position[1] = bad; }},
           Wrong{"the twist is not finite", [bad](Kinematics&k, bool) { k.twist[4] = bad; }},
           Wrong{"the mass matrix has 0 x 0 numbers", [](Kinematics&k, bool) { k.inertia.resize(0, 0); }},
           Wrong{"the mass matrix is not positive definite", [](Kinematics&k, bool) { k.inertia.setZero(); }},
           Wrong{"track() at the start pose: the joints that reach() gives lead to another pose, 0.01 m",
                 [](Kinematics&k, bool isTrack) { k.pose.position[0] += isTrack ? 0.01 : 0.0; }},
           Wrong{"track() at the start pose: the twist differs from Jacobian times joint rates by 1",
                 [](Kinematics&k, bool) { k.twist *= 2.0; }},
       })
    CHECK_THROWS_WITH(checkMechanism(Spoilt(change), Pose{}), ContainsSubstring(text));
  CHECK_THROWS_WITH(checkMechanism(Spoilt({}), Pose{Vec3(5.0, 0.0, 0.0), Mat3::Identity()}),
                    ContainsSubstring("reach() at the start pose: the status is \"unreachable\""));
  CHECK_THROWS_WITH(checkMechanism(Spoilt({}, 2), Pose{}),
                    ContainsSubstring("the vector of largest efforts has 2 numbers, must have 3"));
  CHECK_NOTHROW(checkMechanism(Spoilt({}), Pose{}));
}

TEST_CASE("every mechanism: home is P = W, at rest, with inertia, and limits that fit its joints", "[mechanism]") {
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto mechanism = shipped.mechanism();
    const int n = mechanism->joints();
    CHECK((shipped.turn > 0.0 ? n == 6 : n == 3));
    CHECK(!mechanism->name().empty());
    CHECK(mechanism->name() == nameOf(shipped.parameters()));
    const Kinematics& home = mechanism->home();
    CHECK(home.pose.position == Vec3::Zero());
    CHECK(home.pose.rotation == Mat3::Identity());
    CHECK(home.rates == JointVector::Zero(n));
    CHECK(home.twist == Vec6::Zero());
    CHECK(home.inertia.rows() == n);
    CHECK(mechanism->limits().effort.size() == n);
    CHECK(mechanism->limits().encoderStep.size() == n);
    for (int i = 0; i < n; ++i) {
      CHECK(mechanism->limits().effort[i] > 0.0);
      CHECK(mechanism->limits().encoderStep[i] > 0.0);
    }
    // A push of the effective mass needs this force: F = m a along the direction.
    const double mass = effectiveMass(home, Vec3::Zero(), Vec3::UnitZ());
    Vec6 push = Vec6::Zero(), acceleration;
    push[2] = 2.0;
    REQUIRE(mechanism->accelerate(home.pose, Vec6::Zero(), home.gravity, push, acceleration) == Status::ok);
    CHECK(acceleration[2] == Approx(2.0 / mass).epsilon(1e-12));
    // The largest force: one motor is at its limit and none above, in both directions.
    for (const double way : {1.0, -1.0}) {
      const double force = largestForce(home, mechanism->limits().effort, home.pose.position, way * Vec3::UnitZ());
      push.setZero();
      push[2] = way * force;
      const JointVector needed = torqueOf(home.jacobian, push) + home.gravity;
      double fullest = 0.0;
      for (int i = 0; i < n; ++i) fullest = std::max(fullest, std::abs(needed[i]) / mechanism->limits().effort[i]);
      CHECK(fullest == Approx(1.0).epsilon(1e-12));
      if (n < 6) continue;  // a lever needs a moment, and therefore six joints
      const Vec3 tip(0.06, 0.0, -0.02);
      const double there =
          largestForce(home, mechanism->limits().effort, home.pose.position + tip, way * Vec3::UnitZ());
      push.tail<3>() = tip.cross(Vec3(way * there * Vec3::UnitZ()));
      push[2] = way * there;
      const JointVector atTip = torqueOf(home.jacobian, push) + home.gravity;
      fullest = 0.0;
      for (int i = 0; i < n; ++i) fullest = std::max(fullest, std::abs(atTip[i]) / mechanism->limits().effort[i]);
      CHECK(fullest == Approx(1.0).epsilon(1e-12));
    }
  }
}

TEST_CASE("every mechanism: track undoes reach", "[mechanism]") {
  constexpr std::uint64_t seed = 711;
  for (const test::Shipped& shipped : test::shippedDevices()) {
    const auto mechanism = shipped.mechanism();
    test::Random random(seed);
    INFO(shipped.file << ", seed " << seed);
    for (int i = 0; i < test::count(1000, 20000); ++i) {
      const Pose pose = shipped.pose(random);
      const Vec6 twist = shipped.twist(random);
      const Kinematics there = reached(*mechanism, pose, twist);
      CHECK(there.pose.position == pose.position);
      CHECK(there.twist == twist);
      Kinematics back = mechanism->home();
      REQUIRE(mechanism->track(there.q, there.rates, true, back) == Status::ok);
      // The limit for the platform's position is 1e-12 m; for angles 1e-11 rad (TAU platforms of 75 mm). Everything
      // else follows from the pose with condition numbers below 100 over lengths of 60 mm.
      CHECK((back.pose.position - pose.position).norm() < 1e-12);
      CHECK(angleBetween(back.pose.rotation, pose.rotation) < 1e-11);
      CHECK(back.q == there.q);
      CHECK(back.rates == there.rates);
      CHECK(largest(back.twist - twist) < 1e-10);
      CHECK(relativeError(back.jacobian, there.jacobian) < 1e-9);
      CHECK(relativeError(back.inverseTransposed, there.inverseTransposed) < 1e-9);
      CHECK(relativeError(back.inertia, there.inertia) < 1e-9);
      CHECK(largest(back.gravity - there.gravity) < 1e-9 * (1.0 + largest(there.gravity)));
      Kinematics brief = mechanism->home();
      REQUIRE(mechanism->track(there.q, there.rates, false, brief) == Status::ok);
      CHECK(brief.inertia.size() == 0);
      brief.inertia = back.inertia;
      CHECK(same(brief, back));
    }
  }
}

TEST_CASE("every mechanism: J is the derivative, and its inverse is one", "[mechanism]") {
  constexpr std::uint64_t seed = 712;
  for (const test::Shipped& shipped : test::shippedDevices()) {
    const auto mechanism = shipped.mechanism();
    const int n = mechanism->joints();
    test::Random random(seed);
    INFO(shipped.file << ", seed " << seed);
    for (int i = 0; i < test::count(300, 5000); ++i) {
      const Pose pose = shipped.pose(random);
      const Kinematics k = reached(*mechanism, pose, Vec6::Zero());
      // Fourth-order differences as in kinematics.cpp. The truncation, h^4 / 30 times the fifth derivative, is 1e-8 of
      // the entries at h = 0.1 mm in the corners of the delta's cube; here it falls to 1e-10. Rounding is 1e-16 / h =
      // 3e-12.
      const double h = 3e-5;
      Eigen::MatrixXd differences(n, n);
      for (int j = 0; j < n; ++j) {
        const auto at = [&](double step) {
          return reached(*mechanism, moved(pose, step * Vec6::Unit(j)), Vec6::Zero()).q;
        };
        differences.col(j) = (8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h);
      }
      CHECK(relativeError(k.inverseTransposed.topRows(n).transpose(), differences) < 1e-9);
      const Eigen::MatrixXd identity = k.jacobian.topRows(n) * k.inverseTransposed.topRows(n).transpose();
      CHECK(largest(identity - Eigen::MatrixXd::Identity(n, n)) < 1e-11);  // condition number up to a few hundred
      if (n < 6) {
        CHECK(k.jacobian.bottomRows(6 - n).isZero(0.0));
        CHECK(k.inverseTransposed.bottomRows(6 - n).isZero(0.0));
      }
      const JointVector torque = test::randomJoints(random, n, 2.0);
      CHECK(relativeError(torqueOf(k.jacobian, wrenchOf(k, torque)), torque) < 1e-11);
    }
  }
}

TEST_CASE("every mechanism: gravity balances, and the inertia is what accelerates", "[mechanism]") {
  constexpr std::uint64_t seed = 713;
  for (const test::Shipped& shipped : test::shippedDevices()) {
    const auto mechanism = frictionless(shipped);
    const int n = mechanism->joints();
    test::Random random(seed);
    INFO(shipped.file << ", seed " << seed);
    for (int i = 0; i < test::count(1000, 20000); ++i) {
      const Pose pose = i == 0 ? Pose{} : shipped.pose(random);
      const Kinematics k = reached(*mechanism, pose, Vec6::Zero());
      CHECK(k.inertia == k.inertia.transpose());
      CHECK(k.inertia.llt().info() == Eigen::Success);
      Vec6 acceleration;
      REQUIRE(mechanism->accelerate(pose, Vec6::Zero(), k.gravity, Vec6::Zero(), acceleration) == Status::ok);
      // Forces of up to 10 N cancel to 1e-15 of them; times 1 / (0.1 kg) and 1 / (1e-4 kg m^2).
      CHECK(largest(acceleration) < 1e-9);

      const JointVector torque = test::randomJoints(random, n, 1.0);
      const Vec6 wrench = random.vector6(5.0, n == 6 ? 0.2 : 0.0);
      REQUIRE(mechanism->accelerate(pose, Vec6::Zero(), torque, wrench, acceleration) == Status::ok);
      // At rest V' = J q'': M q'' = torque - gravity + J^T F.
      const JointVector second = torqueOf(k.inverseTransposed, acceleration);
      const JointVector net = torque - k.gravity + torqueOf(k.jacobian, wrench);
      CHECK(relativeError(k.inertia * second, net) < 1e-10);  // condition numbers of M up to 1e3
    }
  }
}

TEST_CASE("every mechanism: the energy of a free motion changes by the work of torque, wrench and weight",
          "[mechanism]") {
  constexpr std::uint64_t seed = 714;
  for (const test::Shipped& shipped : test::shippedDevices()) {
    const auto mechanism = frictionless(shipped);
    const int n = mechanism->joints();
    test::Random random(seed);
    INFO(shipped.file << ", seed " << seed);
    for (int i = 0; i < test::count(300, 3000); ++i) {
      Pose pose = shipped.pose(random);
      pose.position *= 0.9;  // the motion stays inside
      const Vec6 twist = shipped.twist(random);
      const JointVector torque = test::randomJoints(random, n, 1.0);
      const Vec6 wrench = random.vector6(5.0, n == 6 ? 0.2 : 0.0);
      Vec6 acceleration;
      REQUIRE(mechanism->accelerate(pose, twist, torque, wrench, acceleration) == Status::ok);
      const Kinematics k = reached(*mechanism, pose, twist);
      double power = wrench.dot(twist);
      for (int j = 0; j < n; ++j) power += (torque[j] - k.gravity[j]) * k.rates[j];
      // dT/dt by fourth-order differences along the second-order expansion of the motion, whose error does not affect
      // the first derivative. Truncation is (h / 10 ms)^4 of the power at the largest rates; rounding is 1e-16 T / h =
      // 1e-12 W.
      const auto energyAt = [&](double t) {
        const Vec6 by = t * twist + 0.5 * t * t * acceleration;
        const Kinematics there = reached(*mechanism, moved(pose, by), twist + t * acceleration);
        return 0.5 * there.rates.dot(there.inertia * there.rates);
      };
      const double h = 2e-5;
      const double rate = (8.0 * (energyAt(h) - energyAt(-h)) - (energyAt(2 * h) - energyAt(-2 * h))) / (12.0 * h);
      CHECK(rate == Approx(power).epsilon(1e-6).margin(1e-6));
    }
  }
}

TEST_CASE("every mechanism: damping, friction and mass that are added act where they should", "[mechanism]") {
  constexpr std::uint64_t seed = 715;
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file << ", seed " << seed);
    test::Random random(seed);
    DeviceParameters parameters = shipped.parameters();
    const auto before = makeMechanism(parameters);
    const int n = before->joints();
    Vec6 damping;
    damping << 2.0, 3.0, 4.0, 0.01, 0.02, 0.03;
    const double friction = 0.02;
    addDamping(parameters, damping);
    addFriction(parameters, friction);
    const auto after = makeMechanism(parameters);
    const bool cartesian = std::holds_alternative<CartesianParameters>(parameters);
    for (int i = 0; i < 50; ++i) {
      const Pose pose = shipped.pose(random);
      const Vec6 twist = shipped.twist(random);
      const JointVector torque = test::randomJoints(random, n, 1.0);
      Vec6 free, damped;
      REQUIRE(before->accelerate(pose, twist, torque, Vec6::Zero(), free) == Status::ok);
      REQUIRE(after->accelerate(pose, twist, torque, Vec6::Zero(), damped) == Status::ok);
      const Kinematics k = reached(*before, pose, twist);
      const Vec6 opposing = damping.cwiseProduct(twist) + (cartesian ? Vec6(friction * twist) : Vec6(Vec6::Zero()));
      JointVector expected = torqueOf(k.jacobian, opposing);
      if (!cartesian) expected += friction * k.rates;
      const JointVector lost = k.inertia * torqueOf(k.inverseTransposed, free - damped);
      CHECK(relativeError(lost, expected) < 1e-9);  // differences of accelerations 1e3 times as large
    }
    const double push = effectiveMass(before->home(), Vec3::Zero(), Vec3::UnitX());
    addMass(parameters, 0.5);
    const double heavy = effectiveMass(makeMechanism(parameters)->home(), Vec3::Zero(), Vec3::UnitX());
    CHECK(heavy > push + (n == 3 ? 0.5 - 1e-12 : 0.05));  // a platform that turns yields
  }
}

TEST_CASE("every mechanism: pictures have bars where the device can be, and none elsewhere", "[mechanism]") {
  test::Random random(716);
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto mechanism = shipped.mechanism();
    for (int i = 0; i < 50; ++i) {
      const std::vector<Bar> bars = mechanism->bars(shipped.pose(random));
      CHECK(bars.size() >= 3);
      for (const Bar& bar : bars) {
        CHECK(bar.from.allFinite());
        CHECK((bar.to - bar.from).norm() > 1e-3);
        CHECK(bar.chain >= -1);
        CHECK(bar.chain < 3);
      }
    }
    Pose far;
    far.position.x() = 1.0;
    CHECK(mechanism->bars(far).empty());
  }
}

TEST_CASE("every mechanism: what it cannot take gets a status and leaves the output", "[mechanism]") {
  for (const test::Shipped& shipped : test::shippedDevices()) {
    INFO(shipped.file);
    const auto mechanism = shipped.mechanism();
    const int n = mechanism->joints();
    const Kinematics& home = mechanism->home();
    Kinematics k = home;
    Vec6 acceleration = Vec6::Constant(7.0);
    const Vec6 zero = Vec6::Zero();
    const JointVector none = JointVector::Zero(n);

    for (int size = 0; size <= kMaxJoints; ++size) {
      if (size == n) continue;
      const JointVector wrong = JointVector::Zero(size);
      CHECK(mechanism->track(wrong, none, true, k) == Status::outOfRange);
      CHECK(mechanism->track(home.q, wrong, true, k) == Status::outOfRange);
      CHECK(mechanism->accelerate(Pose{}, zero, wrong, zero, acceleration) == Status::outOfRange);
    }
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      for (int i = 0; i < n; ++i) {
        JointVector q = home.q, rates = none, torque = none;
        q[i] = rates[i] = torque[i] = bad;
        CHECK(mechanism->track(q, none, true, k) == Status::notFinite);
        CHECK(mechanism->track(home.q, rates, true, k) == Status::notFinite);
        CHECK(mechanism->accelerate(Pose{}, zero, torque, zero, acceleration) == Status::notFinite);
      }
      for (int i = 0; i < 6; ++i) {
        Vec6 twist = zero;
        twist[i] = bad;
        CHECK(mechanism->reach(Pose{}, twist, true, k) == Status::notFinite);
        CHECK(mechanism->accelerate(Pose{}, twist, none, zero, acceleration) == Status::notFinite);
        CHECK(mechanism->accelerate(Pose{}, zero, none, twist, acceleration) == Status::notFinite);
      }
      for (int i = 0; i < 12; ++i) {
        Pose pose;
        (i < 3 ? pose.position[i] : pose.rotation(i / 3 - 1, i % 3)) = bad;
        CHECK(mechanism->reach(pose, zero, true, k) == Status::notFinite);
        CHECK(mechanism->accelerate(pose, zero, none, zero, acceleration) == Status::notFinite);
      }
    }
    Pose far;
    far.position.x() = 1.0;
    CHECK(mechanism->reach(far, zero, true, k) == Status::unreachable);
    CHECK(mechanism->accelerate(far, zero, none, zero, acceleration) == Status::unreachable);
    if (n == 3) {
      Pose turned;
      turned.rotation = test::rotationAbout(Vec3::UnitY(), 1e-6);
      CHECK(mechanism->reach(turned, zero, true, k) == Status::unreachable);
      CHECK(mechanism->accelerate(turned, zero, none, zero, acceleration) == Status::unreachable);
      CHECK(mechanism->bars(turned).empty());
      for (int i = 3; i < 6; ++i) {
        CHECK(mechanism->reach(Pose{}, 1e-6 * Vec6::Unit(i), true, k) == Status::unreachable);
        CHECK(mechanism->accelerate(Pose{}, 1e-6 * Vec6::Unit(i), none, zero, acceleration) == Status::unreachable);
      }
      Kinematics rounded = home;
      turned.rotation = test::rotationAbout(Vec3::UnitY(), 1e-12);
      CHECK(mechanism->reach(turned, 1e-12 * Vec6::Unit(4), true, rounded) == Status::ok);
      CHECK(same(rounded, home));
    }
    CHECK(same(k, home));
    CHECK(acceleration == Vec6::Constant(7.0));

    // The start of the search, even an invalid one, does not affect the result.
    Kinematics lost = home;
    lost.pose.position = Vec3::Constant(std::nan(""));
    const Status status = mechanism->track(home.q, none, true, lost);
    CHECK((status == Status::ok || status == Status::notFinite));
    if (status == Status::ok) CHECK(lost.pose.position.norm() < 1e-12);
  }
}

}  // namespace enamel::test_mechanism
