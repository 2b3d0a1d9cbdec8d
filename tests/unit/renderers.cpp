// The renderers' laws, their states, and what they refuse.
#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/device/dynamics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_renderers {

using test::inputAt;
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
  const DeviceModel model = makeModel(test::nominal());
  ImpedanceRenderer renderer(model, {6000.0, 2.0, 4.0});
  renderer.activate(1e-3);
  TickOutput output;
  const auto forceAt = [&](double depth, double speed, double time) {
    Vec6 twist = Vec6::Zero();
    twist[2] = speed;
    const TickInput input = inputAt(model, poseAtDepth(depth), time, twist);
    REQUIRE(renderer.step(input, output) == Status::ok);
    Configuration c;
    REQUIRE(configure(model, input.pose, c) == Status::ok);
    return wrenchFromTorques(model, c, output.torque - gravityTorque(model, c));
  };
  // Forces pass through J^T and J^-T: a few hundred roundings.
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
  const DeviceModel model = makeModel(test::nominal());
  ImpedanceRenderer renderer(model, {1000.0, 0.0, 4.0});
  renderer.activate(1e-3);
  TickInput input = inputAt(model, Pose{}, 1.0);
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
  CHECK(relativeError(output.torque, staticTorque(model, model.home, expected)) < 1e-12);
}

TEST_CASE("impedance: the bound of eq. 16 is computed", "[renderers]") {
  const DampingBound met = dampingBound({6000.0, 0.0, 4.0}, 1e-3);
  CHECK(met.required == Approx(3.0).epsilon(1e-15));
  CHECK(met.met);
  CHECK_FALSE(dampingBound({8000.0, 0.0, 4.0}, 1e-3).met);  // equal is not enough
  CHECK(dampingBound({6000.0, 2.0, 4.0}, 1e-3).required == Approx(5.0).epsilon(1e-15));
}

TEST_CASE("position control: gravity in free space, the servo law in contact", "[renderers]") {
  const DeviceModel model = makeModel(test::nominal());
  PositionControlRenderer renderer = test::positionControl(model, test::asInThePaper());
  renderer.activate(1e-3);
  TickOutput output;
  const TickInput outside = inputAt(model, poseAtDepth(-1e-3), 0.0);
  REQUIRE(renderer.step(outside, output) == Status::ok);
  CHECK(output.mode == RenderMode::free);
  Configuration c;
  REQUIRE(configure(model, outside.pose, c) == Status::ok);
  CHECK(output.torque == gravityTorque(model, c));

  // First touch at 0.1 mm: the measured angles become the reference, so only the rates count.
  Vec6 twist = Vec6::Zero();
  twist[2] = -0.05;
  const TickInput touch = inputAt(model, poseAtDepth(1e-4), 1e-3, twist);
  REQUIRE(renderer.step(touch, output) == Status::ok);
  CHECK(output.mode == RenderMode::contact);
  REQUIRE(configure(model, touch.pose, c) == Status::ok);
  const PositionControlRenderer::Gain gain = test::referenceGain();
  Vec6 expected = gravityTorque(model, c) - gain.leftCols<6>() * touch.rates;
  CHECK(relativeError(output.torque, expected) < 1e-13);
  CHECK(output.normalForce > 0.0);

  // Deeper: the error counts; one tick later its integral too.
  const TickInput deeper = inputAt(model, poseAtDepth(2e-4), 2e-3);
  const Vec6 error = deeper.q - touch.q;
  REQUIRE(renderer.step(deeper, output) == Status::ok);
  expected = gravityTorque(model, c) - gain.middleCols<6>(6) * error;
  CHECK(relativeError(output.torque, expected) < 1e-12);
  TickInput next = deeper;
  next.time = 3e-3;
  REQUIRE(renderer.step(next, output) == Status::ok);
  expected += gain.rightCols<6>() * (1e-3 * error);
  CHECK(relativeError(output.torque, expected) < 1e-12);
}

TEST_CASE("position control: release ends the hold, and the next touch refers to the surface", "[renderers]") {
  const DeviceModel model = makeModel(test::nominal());
  PositionControlOptions options;
  options.releaseForce = 0.3;
  PositionControlRenderer renderer = test::positionControl(model, options);
  renderer.activate(1e-3);
  TickOutput output;
  double time = 0.0;
  const auto tick = [&](double depth, double speed) {
    Vec6 twist = Vec6::Zero();
    twist[2] = speed;
    REQUIRE(renderer.step(inputAt(model, poseAtDepth(depth), time += 1e-3, twist), output) == Status::ok);
    return output.mode;
  };
  CHECK(tick(-1e-3, -0.1) == RenderMode::free);
  // The reference is the touching pose projected to z = 0: at rest at 0.1 mm the wall pushes out.
  CHECK(tick(1e-4, 0.0) == RenderMode::contact);
  CHECK(output.normalForce > 0.5);
  // Pulled 0.2 mm out, it would pull: released.
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
  const DeviceModel model = makeModel(test::nominal());
  for (const bool antiWindup : {false, true}) {
    PositionControlOptions options = test::asInThePaper();
    options.antiWindup = antiWindup;
    PositionControlRenderer renderer = test::positionControl(model, options);
    renderer.activate(1e-3);
    TickOutput output;
    REQUIRE(renderer.step(inputAt(model, Pose{}, 0.0), output) == Status::ok);
    for (int i = 1; i <= 5; ++i) {
      REQUIRE(renderer.step(inputAt(model, poseAtDepth(0.02), 1e-3 * i), output) == Status::ok);
      CHECK(output.saturated);
      CHECK(output.torque.cwiseAbs().maxCoeff() <= model.maxTorque);
    }
    // Back at the reference only the integral is left.
    REQUIRE(renderer.step(inputAt(model, Pose{}, 0.01), output) == Status::ok);
    const double left = (output.torque - gravityTorque(model, model.home)).norm();
    CHECK((antiWindup ? left < 1e-12 : left > 0.1));
  }
}

TEST_CASE("renderers: reset gives the first tick again, a saved state continues bit for bit", "[renderers]") {
  const DeviceModel model = makeModel(test::nominal());
  PositionControlRenderer servo = test::positionControl(model);
  ImpedanceRenderer spring(model, {6000.0, 1.0, 4.0});
  for (Renderer* renderer : {static_cast<Renderer*>(&servo), static_cast<Renderer*>(&spring)}) {
    renderer->activate(1e-3);
    const auto fresh = stateOf(*renderer);
    const auto sequence = [&](int from, int to) {
      std::vector<Vec6> torques;
      for (int i = from; i < to; ++i) {
        TickOutput output;
        Vec6 twist = Vec6::Zero();
        twist[2] = 0.01 * std::cos(0.3 * i);
        REQUIRE(renderer->step(inputAt(model, poseAtDepth(1e-4 * std::sin(0.3 * i)), 1e-3 * i, twist), output) ==
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
  const DeviceModel model = makeModel(test::nominal());
  PositionControlRenderer servo = test::positionControl(model);
  ImpedanceRenderer spring(model, {6000.0, 0.0, 4.0});
  for (Renderer* renderer : {static_cast<Renderer*>(&servo), static_cast<Renderer*>(&spring)}) {
    TickOutput output;
    TickInput good = inputAt(model, poseAtDepth(1e-4), 1.0);
    CHECK(renderer->step(good, output) == Status::inactive);
    renderer->activate(1e-3);
    REQUIRE(renderer->step(good, output) == Status::ok);
    const auto before = stateOf(*renderer);
    const auto refuse = [&](Status status, auto change) {
      TickInput bad = good;
      bad.time = 2.0;
      change(bad);
      output.torque.setConstant(7.0);
      CHECK(renderer->step(bad, output) == status);
      CHECK(output.torque == Vec6::Zero());
      CHECK(output.mode == RenderMode::fault);
      CHECK(stateOf(*renderer) == before);
    };
    refuse(Status::notFinite, [](TickInput& in) { in.q[3] = std::nan(""); });
    refuse(Status::notFinite, [](TickInput& in) { in.rates[0] = HUGE_VAL; });
    refuse(Status::notFinite, [](TickInput& in) { in.pose.rotation(1, 1) = std::nan(""); });
    refuse(Status::notFinite, [](TickInput& in) { in.contacts.contacts[0].gap = std::nan(""); });
    refuse(Status::notFinite, [](TickInput& in) { in.time = std::nan(""); });
    refuse(Status::notFinite, [](TickInput& in) { in.maxTorque = std::nan(""); });
    refuse(Status::outOfRange, [](TickInput& in) { in.q[0] = 1e6; });
    refuse(Status::outOfRange, [](TickInput& in) { in.twist[1] = 1e3; });
    refuse(Status::outOfRange, [](TickInput& in) { in.pose.rotation *= 1.1; });
    refuse(Status::outOfRange, [](TickInput& in) { in.pose.rotation.col(0) *= -1.0; });
    refuse(Status::outOfRange, [](TickInput& in) { in.contacts.contacts[0].normal *= 2.0; });
    refuse(Status::outOfRange, [](TickInput& in) { in.contacts.count = kMaxContacts + 1; });
    refuse(Status::outOfRange, [](TickInput& in) { in.contacts.count = -1; });
    refuse(Status::outOfRange, [](TickInput& in) { in.maxTorque = -1.0; });
    refuse(Status::stale, [](TickInput& in) { in.time = 1.0; });
    refuse(Status::stale, [](TickInput& in) { in.time = 0.5; });
    refuse(Status::unreachable, [](TickInput& in) { in.pose.position.x() = 1.0; });
    renderer->deactivate();
    CHECK(renderer->step(good, output) == Status::inactive);
  }
}

TEST_CASE("renderers: a bad configuration is refused", "[renderers]") {
  const DeviceModel model = makeModel(test::nominal());
  CHECK_THROWS_WITH(ImpedanceRenderer(model, {-1.0, 0.0, 0.0}),
                    "impedance renderer: stiffness is -1, must be at least 0 N/m and finite");
  CHECK_THROWS_AS(ImpedanceRenderer(model, {1.0, std::nan(""), 0.0}), Error);
  PositionControlRenderer::Gain gain = test::referenceGain();
  PositionControlRenderer renderer(model, gain, 1e-3, {});
  CHECK_THROWS_WITH(
      renderer.activate(2e-3),
      "position-control renderer: activated for a period of 0.002 s, but its gain was designed for 0.001 s");
  CHECK_THROWS_WITH(renderer.activate(0.0), "renderer: the period is 0, must be in (0, 0.1] s");
  gain(0, 0) = std::nan("");
  CHECK_THROWS_AS(PositionControlRenderer(model, gain, 1e-3, {}), Error);
  PositionControlOptions options;
  options.releaseForce = -1.0;
  CHECK_THROWS_AS(PositionControlRenderer(model, test::referenceGain(), 1e-3, options), Error);
}

}  // namespace enamel::test_renderers
