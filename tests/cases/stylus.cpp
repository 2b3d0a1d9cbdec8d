// A stylus that senses six axes and drives three, as most desktop devices do.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/device/cartesian/mechanism.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_stylus {

namespace {

// Return a device file with six sensed axes. `more`: further lines before its tables.
std::string file(const std::string& more) {
  return "kind = \"cartesian\"\nname = \"stylus\"\naxes = 6\nhalf_widths = [0.08, 0.06, 0.035]\nmax_force = 3.3\n"
         "position_step = 5e-6\nangle_step = 2e-4\n" +
         more + "\n[platform]\nmass = 0.1\ninertia = [4e-5, 4e-5, 2e-5]\n";
}

bool isRead(const std::string& text) {
  try {
    (void)CartesianMechanism(parseCartesian(text, "stylus.toml"));
    return true;
  } catch (const Error&) {
    return false;
  }
}

struct Press {
  bool finished = false;
  double depth = 0.0;  // of the ball, largest after 0.3 s, m
  double force = 0.0;  // of the wall, largest after 0.3 s, N
};

// A hand presses a ball against a wall with 1.5 N and holds the axes of the stylus. The ball is `arm` (m) beside the
// TCP.
Press press(const CartesianMechanism& stylus, double arm) {
  PositionControlRenderer controller(positionControlFor(stylus, 1e-3, 0, 0));
  LoopSetup setup;
  setup.tool.parts[0].a = setup.tool.parts[0].b = Vec3(arm, 0.0, 1e-3);
  setup.tool.parts[0].radius = 1e-3;
  setup.start.position.z() = 1e-3;
  setup.encoders.quantised = true;
  VirtualLoop loop(stylus, controller, setup);
  TickRecord record;
  Press result;
  for (int i = 0; i < 1500; ++i) {
    const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = guidingWrench(pose, twist, setup.start, Vec3::UnitZ());
      wrench.z() -= 1.5 + 4.0 * twist.z();
      return wrench;
    };
    if (loop.tick(hand, record) != Status::ok) return result;
    if (i < 300) continue;
    result.depth = std::max(result.depth, -record.nearest.gap);
    result.force = std::max(result.force, record.normalForce);
  }
  result.finished = true;
  return result;
}

CartesianMechanism withMomentsUpTo(double moment) {
  return CartesianMechanism(parseCartesian(file("max_moment = " + std::to_string(moment)), "stylus.toml"));
}

// A workaround in a driver: three joints, with the sensed rotation of the stylus written into the pose.
class TurningStylus final : public Mechanism {
 public:
  TurningStylus() : Mechanism("turning stylus", {JointVector::Constant(3, 3.3), JointVector::Constant(3, 5e-6)}) {
    setHome();
  }
  void turn(const Mat3& rotation) { turn_ = rotation; }

  Status track(const JointVector& q, const JointVector& rates, bool withInertia,
               Kinematics& kinematics) const noexcept override {
    const Status status = translating_.track(q, rates, withInertia, kinematics);
    if (status == Status::ok) kinematics.pose.rotation = turn_;
    return status;
  }
  Status reach(const Pose& pose, const Vec6& twist, bool withInertia, Kinematics& kinematics) const noexcept override {
    return translating_.reach({pose.position, Mat3::Identity()}, twist, withInertia, kinematics);
  }
  Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                    Vec6& acceleration) const noexcept override {
    return translating_.accelerate({pose.position, Mat3::Identity()}, twist, torque, wrench, acceleration);
  }
  std::vector<Bar> bars(const Pose&) const override { return {}; }

 private:
  static CartesianParameters threeAxes() {
    CartesianParameters p;
    p.name = "turning stylus";
    p.mass = 0.1;
    p.halfWidths = {0.08, 0.06, 0.035};
    p.maxForce = 3.3;
    p.positionStep = 5e-6;
    return p;
  }
  CartesianMechanism translating_{threeAxes()};
  Mat3 turn_ = Mat3::Identity();
};

struct Turning {
  double depth = 0.0;                     // largest after 0.3 s, m
  GuardReason fault = GuardReason::none;  // at the end
};

// A hand presses the ball against the wall with 1.5 N and turns the stylus to and fro by `angle` (rad) once per second.
// This lifts and lowers the ball's centre, 10 mm beside the TCP. The plant is a mass on three axes.
Turning turnOnTheWall(double angle) {
  TurningStylus stylus;
  const Scene scene = flatWall();
  const Vec3 arm(0.01, 0.0, 1e-3);  // in P, m
  Tool tool;
  tool.parts[0] = {arm, arm, 1e-3};
  PositionControlRenderer controller(positionControlFor(stylus, 1e-3, 0, 0));
  Pose start;
  start.position.z() = 4e-3;
  HapticTick tick(stylus, scene, tool, controller, 1e-3, start);
  Measurement sample;
  Command command;
  Vec3 position = start.position, velocity = Vec3::Zero();
  Turning result;
  for (int i = 0; i < 2000; ++i) {
    const Mat3 rotation = test::rotationAbout(Vec3::UnitY(), angle * std::sin(2.0 * M_PI * 1e-3 * i));
    stylus.turn(rotation);
    sample.time = 1e-3 * (i + 1);
    sample.q = position;
    sample.rates = velocity;
    (void)tick(sample, command);
    constexpr int kSteps = 10;
    for (int k = 0; k < kSteps; ++k) {
      const Vec3 hand(-300.0 * position.x(), -300.0 * position.y(), -1.5);
      velocity += 1e-3 / kSteps * (hand - 4.0 * velocity + Vec3(command.effort)) / 0.1;
      position += 1e-3 / kSteps * velocity;
    }
    const double height = (position + rotation * arm).z() - tool.parts[0].radius;
    if (i > 300) result.depth = std::max(result.depth, -height);
  }
  result.fault = tick.guard().fault();
  return result;
}

}  // namespace

TEST_CASE("stylus: with motors on all six axes the wall is stiff beside the tip", "[cases]") {
  REQUIRE(isRead(file("max_moment = 1.0")));
  const Press result = press(withMomentsUpTo(1.0), 0.01);
  CHECK(result.finished);
  CHECK(result.depth < 0.2e-3);
  CHECK(result.force > 1.0);
}

TEST_CASE("case 21: a device file describes six sensed and three driven axes; the wall is stiff beside the tip",
          "[cases]") {
  const CartesianMechanism stylus(parseCartesian(file("driven = [1, 1, 1, 0, 0, 0]\n"), "stylus.toml"));
  for (const double arm : {0.0, 0.01, 0.03}) {
    const Press result = press(stylus, arm);
    INFO(arm << " m beside the TCP: " << result.depth << " m, " << result.force << " N");
    CHECK(result.finished);
    CHECK(result.depth < 0.2e-3);
    CHECK(result.force > 1.0);
  }
}

TEST_CASE(
    "case 21: a stylus that is almost without moments still holds a wall beside its tip "
    "(expected failure, it leaves its workspace)",
    "[!shouldfail][cases]") {
  const Press result = press(withMomentsUpTo(1e-3), 0.01);
  CAPTURE(result.depth, result.force);
  CHECK(result.finished);
}

TEST_CASE("case 22: a stylus that does not turn rests on the wall", "[cases]") {
  const Turning result = turnOnTheWall(0.0);
  CHECK(result.fault == GuardReason::none);
  CHECK(result.depth < 0.2e-3);
}

TEST_CASE("case 22: a hand that turns a stylus against the wall is no fault", "[cases]") {
  const Turning result = turnOnTheWall(0.2);
  CAPTURE(toString(result.fault), result.depth);
  CHECK(result.fault == GuardReason::none);
}

}  // namespace enamel::test_stylus
