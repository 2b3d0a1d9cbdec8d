// The renderers' control laws, their states, and invalid inputs.
#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_renderers {

using test::frameAt;
using test::poseAtDepth;
using test::relativeError;

namespace {

std::vector<unsigned char> stateOf(const Renderer& renderer) {
  std::vector<unsigned char> state(renderer.stateSize());
  renderer.saveState(state.data());
  return state;
}

}  // namespace

TEST_CASE("impedance: spring and damper along the normal, never pulling", "[renderers]") {
  const TauMechanism device(test::nominal());
  ImpedanceRenderer renderer({6000.0, 2.0});
  renderer.activate(1e-3);
  TickOutput output;
  const auto forceAt = [&](double depth, double speed, double time) {
    Vec6 twist = Vec6::Zero();
    twist[2] = speed;
    const TickFrame input = frameAt(device, poseAtDepth(depth), time, twist);
    REQUIRE(renderer.step(input, output) == Status::ok);
    // From the TAU's own functions, not from those that the renderer uses.
    TauConfiguration c;
    REQUIRE(inverseKinematics(device.model(), input.kinematics.pose, c) == Status::ok);
    return wrenchFromTorques(device.model(), c, Vec6(output.torque) - gravityTorque(device.model(), c));
  };
  // Forces pass through J^T and J^-T: a few hundred rounding errors.
  Vec6 expected = Vec6::Zero();
  expected[2] = 6000.0 * 1e-3 + 2.0 * 0.1;
  CHECK(relativeError(forceAt(1e-3, -0.1, 1.0), expected) < 1e-12);
  CHECK(output.normalForce == Approx(expected[2]).epsilon(1e-14));
  CHECK(output.mode == RenderMode::contact);
  CHECK(forceAt(1e-4, 1.0, 2.0).norm() < 1e-12);  // the damper would pull: no force
  CHECK(forceAt(-1e-3, -0.1, 3.0).norm() < 1e-12);
  CHECK(output.mode == RenderMode::free);
}

TEST_CASE("impedance: forces at contacts away from the TCP have their moments, and add up", "[renderers]") {
  const TauMechanism device(test::nominal());
  const TauModel& model = device.model();
  ImpedanceRenderer renderer({1000.0, 0.0});
  renderer.activate(1e-3);
  TickFrame input = frameAt(device, Pose{}, 1.0);
  const Vec3 points[2] = {{0.01, 0.02, -0.05}, {-0.02, 0.0, 0.01}};
  const Vec3 normals[2] = {Vec3(0.0, 0.6, 0.8), Vec3::UnitX()};
  Vec6 expected = Vec6::Zero();
  input.contacts.count = 2;
  for (int i = 0; i < 2; ++i) {
    Contact contact;
    contact.point = points[i];
    contact.normal = normals[i];
    contact.gap = -1e-3 * (i + 1);
    input.contacts.contacts[i] = contact;
    expected.head<3>() += 1000.0 * 1e-3 * (i + 1) * normals[i];
    expected.tail<3>() += 1000.0 * 1e-3 * (i + 1) * points[i].cross(normals[i]);
  }
  TickOutput output;
  REQUIRE(renderer.step(input, output) == Status::ok);
  CHECK(relativeError(Vec6(output.torque), staticTorque(model, model.home, expected)) < 1e-12);
}

TEST_CASE("impedance: the bound of eq. 16 is computed", "[renderers]") {
  CHECK(requiredDamping({6000.0, 0.0}, 1e-3) == Approx(3.0).epsilon(1e-15));
  CHECK(requiredDamping({6000.0, 2.0}, 1e-3) == Approx(5.0).epsilon(1e-15));
  CHECK(requiredDamping({6000.0, 2.0}, 5e-4) == Approx(3.5).epsilon(1e-15));
}

TEST_CASE("position control: gravity in free space, the servo law in contact", "[renderers]") {
  const TauMechanism device(test::nominal());
  const TauModel& model = device.model();
  HoldRenderer renderer = test::holdRenderer(test::asInThePaper());
  renderer.activate(1e-3);
  TickOutput output;
  const TickFrame outside = frameAt(device, poseAtDepth(-1e-3), 0.0);
  REQUIRE(renderer.step(outside, output) == Status::ok);
  CHECK(output.mode == RenderMode::free);
  TauConfiguration c;
  REQUIRE(inverseKinematics(model, outside.kinematics.pose, c) == Status::ok);
  CHECK(relativeError(Vec6(output.torque), gravityTorque(model, c)) < 1e-14);

  // First touch at 0.1 mm: the measured angles become the reference, so that only the rates count.
  Vec6 twist = Vec6::Zero();
  twist[2] = -0.05;
  const TickFrame touch = frameAt(device, poseAtDepth(1e-4), 1e-3, twist);
  REQUIRE(renderer.step(touch, output) == Status::ok);
  CHECK(output.mode == RenderMode::contact);
  REQUIRE(inverseKinematics(model, touch.kinematics.pose, c) == Status::ok);
  const Eigen::Matrix<double, 6, 18> gain = test::referenceGain();
  Vec6 expected = gravityTorque(model, c) - gain.leftCols<6>() * Vec6(touch.kinematics.rates);
  CHECK(relativeError(Vec6(output.torque), expected) < 1e-13);
  CHECK(output.normalForce > 0.0);

  // Deeper: the error counts; one tick later its integral, too.
  const TickFrame deeper = frameAt(device, poseAtDepth(2e-4), 2e-3);
  const Vec6 error = deeper.kinematics.q - touch.kinematics.q;
  REQUIRE(renderer.step(deeper, output) == Status::ok);
  expected = gravityTorque(model, c) - gain.middleCols<6>(6) * error;
  CHECK(relativeError(Vec6(output.torque), expected) < 1e-12);
  TickFrame next = deeper;
  next.time = 3e-3;
  REQUIRE(renderer.step(next, output) == Status::ok);
  expected += gain.rightCols<6>() * (1e-3 * error);
  CHECK(relativeError(Vec6(output.torque), expected) < 1e-12);
}

TEST_CASE("position control: release ends the hold, and the next touch refers to the surface", "[renderers]") {
  const TauMechanism device(test::nominal());
  HoldOptions options;
  options.releaseForce = 0.3;
  HoldRenderer renderer = test::holdRenderer(options);
  renderer.activate(1e-3);
  TickOutput output;
  double time = 0.0;
  const auto tick = [&](double depth, double speed) {
    Vec6 twist = Vec6::Zero();
    twist[2] = speed;
    REQUIRE(renderer.step(frameAt(device, poseAtDepth(depth), time += 1e-3, twist), output) == Status::ok);
    return output.mode;
  };
  CHECK(tick(-1e-3, -0.1) == RenderMode::free);
  // The reference is the pose of touch, projected to z = 0: at rest at 0.1 mm the wall pushes out.
  CHECK(tick(1e-4, 0.0) == RenderMode::contact);
  CHECK(output.normalForce > 0.5);
  // Pulled 0.2 mm out, it would pull: it is released.
  CHECK(tick(-2e-4, 0.0) == RenderMode::free);
  CHECK(output.normalForce == 0.0);
  CHECK(tick(-1e-4, 0.0) == RenderMode::free);
  CHECK(tick(1e-5, -0.1) == RenderMode::contact);
  // Released while still inside (moving out fast): free until it moves inwards again or has left.
  CHECK(tick(1e-5, 0.5) == RenderMode::free);
  CHECK(tick(1e-5, 0.1) == RenderMode::free);
  CHECK(tick(1e-5, -0.01) == RenderMode::contact);
}

TEST_CASE("position control: anti-windup stops the integrators while a motor saturates", "[renderers]") {
  const TauMechanism device(test::nominal());
  for (const bool antiWindup : {false, true}) {
    HoldOptions options = test::asInThePaper();
    options.antiWindup = antiWindup;
    HoldRenderer renderer = test::holdRenderer(options);
    renderer.activate(1e-3);
    TickOutput output;
    REQUIRE(renderer.step(frameAt(device, Pose{}, 0.0), output) == Status::ok);
    for (int i = 1; i <= 5; ++i) {
      REQUIRE(renderer.step(frameAt(device, poseAtDepth(0.02), 1e-3 * i), output) == Status::ok);
      CHECK(output.saturated);
      CHECK(output.torque.cwiseAbs().maxCoeff() <= test::nominal().motor.maxTorque);
    }
    // Back at the reference, only the integral remains.
    REQUIRE(renderer.step(frameAt(device, Pose{}, 0.01), output) == Status::ok);
    const double left = (output.torque - device.home().gravity).norm();
    CHECK((antiWindup ? left < 1e-12 : left > 0.1));
  }
}

TEST_CASE("renderers: reset gives the first tick again, a saved state continues bit for bit", "[renderers]") {
  const TauMechanism device(test::nominal());
  HoldRenderer servo = test::holdRenderer();
  PositionControlRenderer surface = test::positionControl(device);
  ImpedanceRenderer spring({6000.0, 1.0});
  for (Renderer* renderer :
       {static_cast<Renderer*>(&servo), static_cast<Renderer*>(&surface), static_cast<Renderer*>(&spring)}) {
    renderer->activate(1e-3);
    const auto fresh = stateOf(*renderer);
    const auto sequence = [&](int from, int to) {
      std::vector<JointVector> torques;
      for (int i = from; i < to; ++i) {
        TickOutput output;
        Vec6 twist = Vec6::Zero();
        twist[2] = 0.01 * std::cos(0.3 * i);
        REQUIRE(renderer->step(frameAt(device, poseAtDepth(1e-4 * std::sin(0.3 * i)), 1e-3 * i, twist), output) ==
                Status::ok);
        torques.push_back(output.torque);
      }
      return torques;
    };
    const auto first = sequence(0, 50);
    const auto middle = stateOf(*renderer);
    const auto second = sequence(50, 100);
    renderer->loadState(middle.data());
    CHECK(stateOf(*renderer) == middle);
    CHECK(sequence(50, 100) == second);
    renderer->reset();
    CHECK(stateOf(*renderer) == fresh);
    CHECK(sequence(0, 50) == first);
  }
}

TEST_CASE("renderers: bad input gets a status, a zero torque, and leaves the state", "[renderers]") {
  const TauMechanism device(test::nominal());
  HoldRenderer servo = test::holdRenderer();
  PositionControlRenderer surface = test::positionControl(device);
  ImpedanceRenderer spring({6000.0, 0.0});
  for (Renderer* renderer :
       {static_cast<Renderer*>(&servo), static_cast<Renderer*>(&surface), static_cast<Renderer*>(&spring)}) {
    TickOutput output;
    TickFrame good = frameAt(device, poseAtDepth(1e-4), 1.0);
    CHECK(renderer->step(good, output) == Status::inactive);
    renderer->activate(1e-3);
    REQUIRE(renderer->step(good, output) == Status::ok);
    const auto before = stateOf(*renderer);
    const auto refuse = [&](Status status, auto change) {
      TickFrame bad = good;
      bad.time = 2.0;
      change(bad);
      output.torque.setConstant(7.0);
      CHECK(renderer->step(bad, output) == status);
      CHECK(output.torque == JointVector::Zero(bad.kinematics.q.size()));
      CHECK(output.mode == RenderMode::fault);
      CHECK(stateOf(*renderer) == before);
    };
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.q[3] = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.rates[0] = HUGE_VAL; });
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.pose.rotation(1, 1) = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { in.contacts.contacts[0].gap = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { in.time = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { in.maxTorque[5] = std::nan(""); });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.q[0] = 1e6; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.twist[1] = 1e3; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.twist[4] = 1001.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.rates[2] = 1001.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.pose.position.x() = 10.1; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.contacts.contacts[0].point.y() = 10.1; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.contacts.contacts[0].gap = 101.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.contacts.contacts[0].obstacleVelocity.z() = 101.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.pose.rotation *= 1.1; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.pose.rotation.col(0) *= -1.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.contacts.contacts[0].normal *= 2.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.contacts.count = kMaxContacts + 1; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.contacts.count = -1; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.maxTorque[2] = -1.0; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.jacobian(2, 1) = 2e3; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.inverseTransposed(2, 1) = 2e9; });
    refuse(Status::stale, [](TickFrame& in) { in.time = 1.0; });
    refuse(Status::stale, [](TickFrame& in) { in.time = 0.5; });
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.jacobian(4, 5) = HUGE_VAL; });
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.inverseTransposed(0, 0) = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.gravity[1] = -HUGE_VAL; });
    refuse(Status::notFinite, [](TickFrame& in) { in.kinematics.inertia(2, 3) = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { (*in.applied)[0] = std::nan(""); });
    refuse(Status::notFinite, [](TickFrame& in) { in.command = std::nan("") * in.maxTorque; });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.q.conservativeResize(5); });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.q.resize(0); });
    refuse(Status::outOfRange, [](TickFrame& in) { in.kinematics.jacobian.conservativeResize(6, 3); });
    refuse(Status::outOfRange, [](TickFrame& in) { in.applied->conservativeResize(1); });
    refuse(Status::outOfRange, [](TickFrame& in) { in.command = in.maxTorque.head(1); });
    renderer->deactivate();
    CHECK(renderer->step(good, output) == Status::inactive);
  }
}

TEST_CASE("position control: an inertia that is none is refused and leaves the state", "[renderers]") {
  const TauMechanism device(test::nominal());
  PositionControlRenderer servo = test::positionControl(device);
  servo.activate(1e-3);
  TickOutput output;
  REQUIRE(servo.step(frameAt(device, poseAtDepth(1e-4), 1.0), output) == Status::ok);
  const auto before = stateOf(servo);
  const auto stepped = [&](TickFrame& frame) {
    CHECK(fillContactRows(frame) == Status::outOfRange);
    return servo.step(frame, output);
  };
  for (const double impossible : {1e-100, 1e7}) {
    TickFrame frame = frameAt(device, poseAtDepth(1e-4), 1.001);
    frame.kinematics.inertia(1, 1) = impossible;
    CHECK(stepped(frame) == Status::outOfRange);
  }
  TickFrame bad = frameAt(device, poseAtDepth(1e-4), 1.001);
  bad.kinematics.inertia.setZero();
  CHECK(stepped(bad) == Status::outOfRange);
  bad.kinematics.inertia.resize(0, 0);
  CHECK(stepped(bad) == Status::outOfRange);
  CHECK(output.torque == JointVector::Zero(6));
  CHECK(stateOf(servo) == before);
}

TEST_CASE("renderers: a bad configuration is refused", "[renderers]") {
  CHECK_THROWS_WITH(ImpedanceRenderer({-1.0, 0.0}),
                    "impedance renderer: stiffness is -1, must be at least 0 N/m and finite");
  CHECK_THROWS_AS(ImpedanceRenderer({1.0, std::nan("")}), Error);
  ServoGain gain = test::referenceGain();
  CHECK_THROWS_WITH(HoldRenderer(gain.leftCols(12), 1e-3, {}), "hold renderer: the gain K is 6 x 12, must be n x 3n");
  HoldRenderer renderer(gain, 1e-3, {});
  CHECK_THROWS_WITH(renderer.activate(2e-3),
                    "hold renderer: activated for a period of 0.002 s, but its gain was designed for 0.001 s");
  CHECK_THROWS_WITH(renderer.activate(0.0), "renderer: the period is 0, must be in 1e-05 to 0.1 s");
  gain(0, 0) = std::nan("");
  CHECK_THROWS_AS(HoldRenderer(gain, 1e-3, {}), Error);
  HoldOptions options;
  options.releaseForce = -1.0;
  CHECK_THROWS_AS(HoldRenderer(test::referenceGain(), 1e-3, options), Error);
}

TEST_CASE("renderers: a renderer's answer is checked as its input is", "[renderers]") {
  // Returns what it is told.
  class Parrot final : public Renderer {
   public:
    JointVector torque = JointVector::Zero(6);
    double normalForce = 0.0;

   private:
    void prepare(double) override {}
    Status render(const TickFrame&, TickOutput& output) noexcept override {
      output.torque = torque;
      output.normalForce = normalForce;
      output.mode = RenderMode::contact;
      return Status::ok;
    }
    void resetState() noexcept override {}
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  };
  const TauMechanism device(test::nominal());
  Parrot parrot;
  parrot.activate(1e-3);
  double time = 0.0;
  const auto answer = [&](Status status) {
    TickOutput output;
    CHECK(parrot.step(frameAt(device, Pose{}, time += 1e-3), output) == status);
    if (status != Status::ok) CHECK(output.torque == JointVector::Zero(6));
    return output;
  };
  parrot.torque.setConstant(1.0);
  CHECK(answer(Status::ok).torque == JointVector::Constant(6, 1.0));
  parrot.torque[3] = std::nan("");
  answer(Status::notFinite);
  parrot.torque[3] = HUGE_VAL;
  answer(Status::notFinite);
  parrot.torque.setConstant(1e308);
  answer(Status::outOfRange);
  parrot.torque = JointVector::Zero(6);
  parrot.normalForce = -1e7;
  answer(Status::outOfRange);
  parrot.normalForce = 0.0;
  // Above a motor's limit the wrench is scaled down and keeps its direction.
  const Kinematics& home = device.home();
  parrot.torque = staticTorque(home, 100.0 * Vec6::Unit(1));
  const TickOutput cut = answer(Status::ok);
  CHECK(cut.saturated);
  CHECK((cut.torque.cwiseAbs() - device.limits().effort).maxCoeff() == Approx(0.0).margin(1e-15));
  const Vec6 wrench = wrenchOf(home, cut.torque - home.gravity);
  CHECK(wrench[1] > 10.0);
  CHECK((wrench - wrench[1] * Vec6::Unit(1)).norm() < 1e-9);
  parrot.torque = JointVector::Zero(5);
  answer(Status::notFinite);
  parrot.torque = JointVector::Zero(6);
  parrot.normalForce = std::nan("");
  answer(Status::notFinite);
}

TEST_CASE("position control: a gain for another number of joints is refused in the tick", "[renderers]") {
  const TauMechanism device(test::nominal());
  HoldRenderer renderer(ServoGain::Zero(3, 9), 1e-3, {});
  renderer.activate(1e-3);
  TickOutput output;
  CHECK(renderer.step(frameAt(device, poseAtDepth(1e-4), 1.0), output) == Status::outOfRange);
  CHECK(output.torque == JointVector::Zero(6));
}

TEST_CASE("position control: the reference at a deep touch is the surface's, to second order in the depth",
          "[renderers]") {
  const TauMechanism device(test::nominal());
  for (const double depth : {1e-5, 1e-4, 1e-3}) {
    HoldRenderer renderer = test::holdRenderer();
    renderer.activate(1e-3);
    TickOutput output;
    REQUIRE(renderer.step(frameAt(device, poseAtDepth(depth), 1.0), output) == Status::ok);
    REQUIRE(renderer.holding());
    Kinematics surface = device.home();
    REQUIRE(device.track(renderer.reference(), JointVector::Zero(6), false, surface) == Status::ok);
    // Links of about 0.1 m: depth^2 / 0.1 m.
    CHECK(surface.pose.position.norm() < 10.0 * depth * depth);
    CHECK(angleBetween(surface.pose.rotation, Mat3::Identity()) < 200.0 * depth * depth);
  }
}

TEST_CASE("renderers: state bytes from elsewhere never become a torque that cannot be", "[renderers]") {
  const TauMechanism device(test::nominal());
  HoldRenderer servo = test::holdRenderer();
  PositionControlRenderer surface = test::positionControl(device, 0, 3);
  ImpedanceRenderer spring({6000.0, 1.0});
  test::Random random(33);
  for (Renderer* renderer :
       {static_cast<Renderer*>(&servo), static_cast<Renderer*>(&surface), static_cast<Renderer*>(&spring)}) {
    renderer->activate(1e-3);
    const auto fresh = stateOf(*renderer);
    int ok = 0;
    for (int i = 0; i < 2000; ++i) {
      auto bytes = fresh;
      if (i % 2 == 0) {  // any bytes, or doubles of any size
        for (auto& byte : bytes) byte = static_cast<unsigned char>(random.uniform(0.0, 256.0));
      } else {
        for (std::size_t at = 0; at + 8 <= bytes.size(); at += 8) {
          const double share = random.uniform(-1.0, 1.0), value = share * random.power(-10.0, 308.0);
          std::memcpy(&bytes[at], &value, 8);
        }
      }
      if (i % 4 < 2) std::memcpy(bytes.data(), fresh.data(), 8);  // time of the last tick
      renderer->loadState(bytes.data());
      for (int tick = 0; tick < 3; ++tick) {
        TickOutput output;
        const Status status = renderer->step(frameAt(device, poseAtDepth(1e-4), 1.0 + 1e-3 * tick), output);
        ok += status == Status::ok;
        REQUIRE(output.torque.allFinite());
        REQUIRE((output.torque.cwiseAbs() - device.limits().effort).maxCoeff() <= 0.0);
        REQUIRE(std::abs(output.normalForce) <= 1e6);
      }
    }
    CHECK(ok > 1000);
  }
}

}  // namespace enamel::test_renderers
