// A million random ticks of invalid input for each renderer: outputs are always finite and within limits, and the
// status is right.
#include <iostream>

#include "support/catch.hpp"
#include "support/garbage.hpp"
#include "support/pushes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_renderers {

TEST_CASE("garbage into the renderers", "[hard]") {
  constexpr std::uint64_t seed = 71;
  const int ticks = test::count(200000, 1000000);
  const TauMechanism device(test::nominal());
  HoldRenderer hold = test::holdRenderer(), paper = test::holdRenderer(test::asInThePaper());
  PositionControlRenderer servo = test::positionControl(device, 0, 3);
  ImpedanceRenderer spring({6000.0, 5.0});
  for (Renderer* renderer : {static_cast<Renderer*>(&hold), static_cast<Renderer*>(&paper),
                             static_cast<Renderer*>(&servo), static_cast<Renderer*>(&spring)}) {
    test::Random random(seed);
    renderer->activate(1e-3);
    double lastTime = -HUGE_VAL;
    int ok = 0, refused = 0;
    for (int i = 0; i < ticks; ++i) {
      Vec6 twist = random.vector6(0.5, 5.0);
      TickFrame frame = test::frameAt(device, random.workspacePose(), 1e-3 * i, twist);
      const int damage = static_cast<int>(random.uniform(0.0, 8.0));
      Kinematics& k = frame.kinematics;
      double* numbers[] = {&frame.time,
                           k.q.data(),
                           k.rates.data(),
                           k.pose.position.data(),
                           k.pose.rotation.data(),
                           k.twist.data(),
                           k.jacobian.data(),
                           k.inverseTransposed.data(),
                           k.gravity.data(),
                           k.inertia.data(),
                           frame.applied->data(),
                           &frame.contacts.contacts[0].gap,
                           frame.contacts.contacts[0].normal.data(),
                           frame.maxTorque.data(),
                           frame.contacts.contacts[0].point.data(),
                           &frame.contacts.contacts[0].material.stiffness,
                           &frame.contacts.contacts[0].material.friction,
                           &frame.contacts.contacts[0].material.slidingFriction};
      const int sizes[] = {1, 6, 6, 3, 9, 6, 36, 36, 6, 36, 6, 1, 3, 6, 3, 1, 1, 1};
      for (int blow = 0; blow < damage; ++blow) {
        const int field = static_cast<int>(random.uniform(0.0, 18.0));
        numbers[field][static_cast<int>(random.uniform(0.0, sizes[field]))] = test::garbage(random);
      }
      if (random.uniform(0.0, 1.0) < 0.05) frame.contacts.count = static_cast<int>(random.uniform(-20.0, 20.0));
      (void)fillContactRows(frame);  // checkFrame() refuses damaged frames
      TickOutput output;
      output.torque.setConstant(6, std::nan(""));
      const Status status = renderer->step(frame, output);
      REQUIRE(output.torque.allFinite());
      REQUIRE(std::isfinite(output.normalForce));
      const Status expected = checkFrame(frame, lastTime);
      if (expected != Status::ok) {
        REQUIRE(status == expected);
      } else {  // a Jacobian of 1e308 gives impossible torques, and an inertia may be invalid
        REQUIRE((status == Status::ok || status == Status::notFinite || status == Status::outOfRange));
      }
      if (status == Status::ok) {
        ++ok;
        lastTime = frame.time;
        REQUIRE((output.torque.array().abs() <= frame.maxTorque.array()).all());
        REQUIRE(output.mode != RenderMode::fault);
        if (lastTime > 1e-3 * ticks) {  // invalid input has moved the clock far into the future: start again
          renderer->reset();
          lastTime = -HUGE_VAL;
        }
      } else {
        ++refused;
        REQUIRE(output.torque == JointVector::Zero(6));
        REQUIRE(output.mode == RenderMode::fault);
      }
    }
    std::cout << ticks << " ticks, seed " << seed << ": ok " << ok << ", refused " << refused << "\n";
    CHECK(ok > ticks / 50);
    CHECK(refused > ticks / 50);
  }
}

}  // namespace enamel::test_renderers
