// The virtual coupling: the device feels its spring and damper, whatever the wall.
#include "enamel/render/virtual_coupling.hpp"

#include <limits>

#include "enamel/core/error.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_virtual_coupling {

namespace {

// Rest depth of a device that is pressed with `force` along -z, m, and the wall's force there, N.
struct Rest {
  double depth, force;
};

Rest restOn(const Scene& scene, Renderer& renderer, double force, const Vec3& start = Vec3::Zero()) {
  const TauMechanism device(test::dampedNominal());
  LoopSetup setup;
  setup.scene = scene;
  setup.start.position = start;
  setup.guarded = false;
  VirtualLoop loop(device, renderer, setup);
  TickRecord tick;
  for (int i = 0; i < 2000; ++i) {
    const auto push = [&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = guidingWrench(pose, twist, setup.start, Vec3::UnitZ());
      wrench[2] -= force;
      return wrench;
    };
    REQUIRE(loop.tick(push, tick) == Status::ok);
    REQUIRE(tick.status == Status::ok);
  }
  return {-tick.nearest.gap, tick.normalForce};
}

}  // namespace

TEST_CASE("a pressed device rests where the coupling carries the force") {
  for (const double stiffness : {1000.0, 5000.0}) {
    VirtualCouplingRenderer renderer({stiffness, 2.0, 0.02});
    const Rest rest = restOn(flatWall(), renderer, 6.0);
    CHECK(rest.depth == Approx(6.0 / stiffness).epsilon(1e-3));  // the rest of the oscillation
    CHECK(rest.force == Approx(6.0).epsilon(1e-3));
  }
  // A soft surface acts in series with it; in a corner both walls carry the load.
  Obstacle soft = flatWall().obstacles()[0];
  soft.material.stiffness = 2000.0;
  Scene scene;
  scene.add(soft);
  VirtualCouplingRenderer renderer({3000.0, 2.0, 0.02});
  CHECK(restOn(scene, renderer, 6.0).depth == Approx(6.0 / 3000.0 + 6.0 / 2000.0).epsilon(1e-3));
  Scene corner;
  for (const double side : {-1.0, 1.0})
    corner.add(halfSpace("side " + std::to_string(side), Vec3::Zero(), Vec3(side, 0.0, 1.0).normalized()));
  // The offset is 6 N / K along z; each wall sees its component along the normal.
  CHECK(restOn(corner, renderer, 6.0).depth == Approx(6.0 / 3000.0 * std::sqrt(0.5)).epsilon(1e-3));
}

TEST_CASE("a light virtual tool is the spring and damper of the impedance wall while in contact") {
  const TauMechanism device(test::dampedNominal());
  PushSetup setup;
  setup.hand.noise = 0.0;
  setup.hand.preload = 2.0;  // both remain in contact
  setup.guarded = false;
  std::vector<double> depths[2];
  VirtualCouplingRenderer coupling({3000.0, 1.0, 1e-9});
  ImpedanceRenderer wall({3000.0, 1.0});
  Renderer* const renderers[] = {&coupling, &wall};
  for (int i = 0; i < 2; ++i)
    REQUIRE(runPush(device, *renderers[i], setup, [&](const TickRecord& tick) {
              if (tick.time > 0.5) depths[i].push_back(-tick.nearest.gap);
            }).status == Status::ok);
  REQUIRE(depths[0].size() == depths[1].size());
  double worst = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < depths[0].size(); ++i) {
    worst = std::max(worst, std::abs(depths[0][i] - depths[1][i]));
    largest = std::max(largest, depths[1][i]);
  }
  CHECK(largest > 3e-3);
  CHECK(worst < 1e-4 * largest);  // the mass of 1 mg and the regularisation of 1e-6 make the difference
}

TEST_CASE("in the air one feels the virtual tool's mass, and nothing once it has caught up") {
  const TauMechanism device(test::nominal());
  VirtualCouplingRenderer renderer({3000.0, 5.0, 0.1});
  renderer.activate(1e-3);
  TickFrame input;
  input.kinematics = device.home();
  input.maxTorque = device.limits().effort;
  TickOutput output;
  double first = 0.0;
  for (int i = 0; i < 2000; ++i) {
    input.time = 1e-3 * i;
    input.kinematics.pose.position.z() = 1e-5 * i;  // 10 mm/s from the second tick on
    input.kinematics.twist[2] = i > 0 ? 0.01 : 0.0;
    REQUIRE(renderer.step(input, output) == Status::ok);
    CHECK(output.mode == RenderMode::free);
    const double drag = wrenchOf(input.kinematics, output.torque - input.kinematics.gravity)[2];
    if (i == 1) first = drag;
  }
  CHECK(first < -0.01);  // the tool is behind and pulls back
  CHECK(std::abs(wrenchOf(input.kinematics, output.torque - input.kinematics.gravity)[2]) < 1e-9);
}

TEST_CASE("a virtual coupling replays from its state, and refuses what it cannot be") {
  const TauMechanism device(test::nominal());
  VirtualCouplingRenderer one({2000.0, 1.0, 0.05}), other({2000.0, 1.0, 0.05});
  one.activate(1e-3);
  other.activate(1e-3);
  std::vector<unsigned char> state(one.stateSize());
  TickFrame input;
  input.kinematics = device.home();
  input.maxTorque = device.limits().effort;
  input.contacts.count = 1;
  TickOutput a, b;
  for (int i = 0; i < 200; ++i) {
    input.time = 1e-3 * i;
    input.kinematics.pose.position.z() = -1e-3 * std::sin(0.05 * i);
    Contact& contact = input.contacts.contacts[0];
    contact.normal = Vec3::UnitZ();
    contact.point = input.kinematics.pose.position;
    contact.gap = contact.point.z();
    one.saveState(state.data());
    other.loadState(state.data());
    REQUIRE(one.step(input, a) == Status::ok);
    REQUIRE(other.step(input, b) == Status::ok);
    CHECK(a.torque == b.torque);
  }
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const VirtualCouplingOptions& bad :
       {VirtualCouplingOptions{0.0, 1.0, 0.1}, {1e3, -1.0, 0.1}, {1e3, 1.0, 0.0}, {none, 1.0, 0.1}, {1e3, none, 0.1}})
    CHECK_THROWS_AS(VirtualCouplingRenderer(bad), Error);
}

}  // namespace enamel::test_virtual_coupling
