// Position control: its guarantees within a tick.
#include "enamel/render/position_control.hpp"

#include <cmath>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "enamel/study/wall_design.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/mechanisms.hpp"
#include "support/pushes.hpp"
#include "support/run_length.hpp"
#include "support/silent_device.hpp"

namespace enamel::test_position_control {

namespace {

constexpr double kPeriod = 1e-3;

std::shared_ptr<const Mechanism> tau() { return std::make_shared<TauMechanism>(test::nominal()); }

PositionControlOptions optionsFor(const Mechanism& device, int delay) {
  return positionControlFor(device, kPeriod, delay, delay);
}

LoopSetup loopWith(const Scene& scene, int delay) {
  LoopSetup setup;
  setup.scene = scene;
  setup.delay = {delay, delay};
  setup.encoders = {true, RateSource::difference};
  return setup;
}

Scene wallOf(double stiffness, double friction, double sliding) {
  Obstacle wall = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());
  wall.material.stiffness = stiffness;
  wall.material.friction = friction;
  wall.material.slidingFriction = sliding;
  Scene scene;
  scene.add(wall);
  return scene;
}

// A hand that presses with `force` (W, N) and keeps the orientation.
struct Hand {
  Vec3 force;
  Vec6 operator()(double, const Pose& pose, const Vec6& twist) const noexcept {
    Vec6 wrench;
    wrench << force, holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
    return wrench;
  }
};

// The same, but it also keeps the TCP above the origin.
struct FirmHand {
  double force;
  Vec6 operator()(double, const Pose& pose, const Vec6& twist) const noexcept {
    Vec6 wrench = guidingWrench(pose, twist, Pose{}, Vec3::UnitZ());
    wrench[2] -= force;
    return wrench;
  }
};

WallDesignSetup setupFor(int delayLow, int delayHigh) {
  WallDesignSetup setup;
  setup.plant = tau();
  setup.delay = {delayLow, delayHigh};
  setup.runs = test::count(9, 60);
  return setup;
}

WallScore evaluate(const WallDesignSetup& setup) {
  const auto options = positionControlFor(*setup.plant, kPeriod, setup.delay.low, setup.delay.high);
  return evaluateWall(
      setup, [options] { return std::make_unique<PositionControlRenderer>(options); }, 7, 2);
}

}  // namespace

constexpr double kRamp[] = {25e-6, 60e-6, 120e-6, 220e-6}, kBounce = 0.2e-3;  // m

// The limits on the wall: K_z1, chatter, bounce, ramp. The paper's controller has 20 kN/m here without delay and is
// unstable from 2 ticks on.
TEST_CASE("the servo is stiff at every delay, with every inertia, and quiet", "[position_control]") {
  const double stiffness[] = {200e3, 70e3, 34e3, 18e3};
  for (int delay = 0; delay <= 3; ++delay)
    for (const double error : {0.0, 0.3}) {
      WallDesignSetup setup = setupFor(delay, delay);
      setup.inertiaError = error;
      const WallScore s = evaluate(setup);
      INFO("delay " << delay << ", inertia wrong by " << error << ": " << s.stiffness << " N/m, chatter " << s.chatter
                    << ", bounce " << s.bounce << ", ramp " << s.ramp);
      CHECK(s.lost == 0);
      // The goal is 1 for 20 runs per point of a study; the mean of nine at the worst point varies by a few per cent.
      CHECK(s.stiffness > (error > 0.0 ? 0.85 : 0.95) * stiffness[delay]);
      CHECK(s.chatter < 0.1);  // the goal is 0.05; the largest of a few dozen runs varies
      // A press on a wrong model at a delay: a thousand runs reach 0.246 and 0.122 mm.
      const bool isWrong = error > 0.0 && delay >= 2;
      CHECK(s.bounce < (isWrong ? 1.25 : 1.0) * kBounce);
      CHECK(s.ramp < (isWrong ? 1.05 : 1.0) * kRamp[delay]);
    }
}

TEST_CASE("a random delay loses no run", "[position_control]") {
  struct Range {
    int low, high;
    double ramp, deepest;  // m
  };
  for (const Range& r : {Range{0, 3, 0.25e-3, 1.7e-3}, Range{1, 2, 0.15e-3, 0.6e-3}, Range{2, 5, 0.5e-3, 2e-3}}) {
    const WallScore s = evaluate(setupFor(r.low, r.high));
    INFO(r.low << " to " << r.high << " ticks: deepest " << s.deepest << ", chatter " << s.chatter << ", ramp "
               << s.ramp);
    CHECK(s.lost == 0);
    // A controller based on the mean of the pending commands hops: 0.15 N m and 0.5 mm.
    CHECK(s.chatter < 0.08);
    CHECK(s.ramp < r.ramp);
    CHECK(s.deepest < r.deepest);
  }
}

TEST_CASE(
    "a press on a model that is wrong is quiet with 2 and 3 ticks, and random delays keep their depth "
    "(expected failure, 210 um instead of 200, and 1.6 mm instead of 0.85)",
    "[!shouldfail][position_control]") {
  constexpr int kRuns = 30;  // fewer do not reach the limits
  for (const int delay : {2, 3}) {
    WallDesignSetup setup = setupFor(delay, delay);
    setup.inertiaError = 0.3;
    setup.runs = std::max(setup.runs, kRuns);
    const WallScore s = evaluate(setup);
    CHECK(s.bounce < kBounce);
    CHECK(s.ramp < kRamp[delay]);
  }
  // The limit for 0 to 3 ticks is 0.8 mm, for 1000 runs; with a later command the depth grows with its square.
  WallDesignSetup setup = setupFor(0, 3);
  setup.runs = std::max(setup.runs, kRuns);
  CHECK(evaluate(setup).deepest < 0.85e-3);
}

TEST_CASE("a design's evaluation sees a tool slide off a ball", "[position_control]") {
  const auto ball = [](const std::string& friction) {
    return parseScene(
        "name = \"ball\"\nstart = [0.0, 0.0, 0.001]\n[[obstacle]]\nname = \"ball\"\nshape = \"sphere\"\nradius = "
        "0.008\n"
        "centre = [0.0, 0.0, -0.008]\nfriction = " +
            friction + "\n",
        "ball.toml");
  };
  for (int delay = 0; delay <= 3; ++delay) {
    WallDesignSetup setup = setupFor(delay, delay);
    const WallScore without = evaluate(setup);
    CHECK(without.drift == 0.0);
    setup.scene = ball("0.2");
    const WallScore held = evaluate(setup);
    INFO("delay " << delay << ": " << held.drift << " m");
    CHECK(held.drift > 0.0);
    CHECK(held.drift < 0.3e-3);
    CHECK(held.value == without.value);
    setup.scene = ball("0.0");
    const WallScore slides = evaluate(setup);
    CHECK(slides.drift > 3e-3);  // 4 mm are off
    CHECK(slides.value < held.value - 0.5);
  }
}

// Mass that the renderer has learnt of a plant that is heavier by `factor` than its model. The hand presses with 1 N
// and a tremor of 0.5 N.
struct Learnt {
  double share, mean;  // model's mass / plant's mass: true, and learnt on average
  int within, runs;    // runs whose 95 % interval contains the true value
};
Learnt learn(double factor, int late) {
  const auto model = tau();
  TauParameters heavier = test::nominal();
  heavier.platform.mass *= factor * factor;
  const TauMechanism plant(heavier);
  Learnt learnt{effectiveMass(model->home(), Vec3::Zero(), Vec3::UnitZ()) /
                    effectiveMass(plant.home(), Vec3::Zero(), Vec3::UnitZ()),
                0.0, 0, test::count(10, 40)};
  for (int run = 0; run < learnt.runs; ++run) {
    PositionControlRenderer servo(positionControlFor(*model, kPeriod, 0, late));
    LoopSetup setup = loopWith(flatWall(), 0);
    setup.delay = {0, late};
    setup.run = static_cast<std::uint32_t>(run);
    VirtualLoop loop(plant, *model, servo, setup);
    const RandomStream random(1, setup.run);
    TickRecord tick;
    for (std::uint64_t i = 0; i < 1500; ++i) {
      const FirmHand hand{1.0 + 0.5 * random.normal(RandomStream::Purpose::noise, i)};
      REQUIRE(loop.tick(hand, tick) == Status::ok);
    }
    const PositionControlState state = servo.state();
    learnt.mean += 1.0 / state.mass / learnt.runs;
    learnt.within += std::abs(std::log(state.mass * learnt.share)) < 1.96 * state.deviation;
    CHECK(state.deviation < 0.2);  // 0.3 before the first contact
  }
  return learnt;
}

// The servo's reaction to encoder counts looks like a lighter device; the effect of a random delay does not.
double tolerance(int late) { return late == 0 ? 0.12 : 0.06; }

TEST_CASE("the servo learns how heavy the device is", "[position_control]") {
  int within = 0, runs = 0;
  for (const int late : {0, 3})                     // none, or random up to 3 ticks
    for (const double factor : {0.75, 1.0, 1.3}) {  // of the plant
      const Learnt l = learn(factor, late);
      INFO("delay up to " << late << ", plant by " << factor << ": " << l.mean << " instead of " << l.share);
      if (factor <= 1.0) CHECK(l.mean == Approx(l.share).epsilon(tolerance(late)));
      if (factor != 1.0) CHECK((l.mean - 1.0) / (l.share - 1.0) > 0.3);
      within += l.within;
      runs += l.runs;
    }
  INFO(within << " of " << runs << " within the interval of 95 %");
  CHECK(within >= 0.9 * runs);
}

TEST_CASE("the servo learns a heavier device (expected failure, half of the error)",
          "[!shouldfail][position_control]") {
  for (const int late : {0, 3}) {
    const Learnt l = learn(1.3, late);
    CHECK(l.mean == Approx(l.share).epsilon(tolerance(late)));
  }
}

// Ticks until the renderer has learnt the true delay of a plant that is heavier than its model. The hand presses with
// 3 N and a tremor of 0.5 N. -1: not learnt for good within a second.
int ticksToLearn(Delay stated, Delay truth, double factor, bool reports, std::uint32_t run) {
  const auto model = tau();
  TauParameters heavier = test::nominal();
  heavier.platform.mass *= factor;
  const TauMechanism plant(heavier);
  PositionControlRenderer servo(positionControlFor(*model, kPeriod, stated.low, stated.high));
  LoopSetup setup = loopWith(flatWall(), 0);
  setup.delay = truth;
  setup.run = run;
  if (!reports) setup.wrapper = [](VirtualDevice& d) { return std::make_unique<test::SilentDevice>(d); };
  VirtualLoop loop(plant, *model, servo, setup);
  const RandomStream random(1, run);
  TickRecord tick;
  int learnt = -1;
  for (int i = 0; i < 1000; ++i) {
    const FirmHand hand{3.0 + 0.5 * random.normal(RandomStream::Purpose::noise, static_cast<std::uint64_t>(i))};
    REQUIRE(loop.tick(hand, tick) == Status::ok);
    const PositionControlState state = servo.state();
    const bool isRight = state.delayLow == truth.low && state.delayHigh == truth.high;
    if (!isRight) learnt = -1;
    if (isRight && learnt < 0) learnt = i;
  }
  return learnt;
}

TEST_CASE("the servo learns the delay from contact", "[position_control]") {
  int slowest = 0, sum = 0, runs = 0;
  for (const bool reports : {true, false})
    for (const double factor : {0.75, 1.0, 1.3})
      for (const auto& [stated, truth] : {std::pair{Delay{1, 1}, Delay{0, 0}},
                                          {Delay{1, 1}, Delay{1, 1}},
                                          {Delay{1, 1}, Delay{2, 2}},
                                          {Delay{1, 1}, Delay{3, 3}},
                                          {Delay{2, 2}, Delay{0, 0}},
                                          {Delay{0, 2}, Delay{0, 0}},
                                          {Delay{0, 2}, Delay{1, 1}},
                                          {Delay{0, 2}, Delay{2, 2}},
                                          {Delay{0, 2}, Delay{3, 3}},
                                          {Delay{0, 2}, Delay{0, 2}},
                                          {Delay{0, 1}, Delay{0, 1}}}) {
        if (!reports && stated.high == 2 && truth.high == 1) continue;  // its command is almost the mean of the range's
        for (std::uint32_t run = 0; run < static_cast<std::uint32_t>(test::count(2, 20)); ++run) {
          const int ticks = ticksToLearn(stated, truth, factor, reports, run);
          INFO("stated " << stated.low << ".." << stated.high << ", true " << truth.low << ".." << truth.high
                         << (reports ? ", reports" : ", no reports") << ", plant by " << factor << ", run " << run);
          CHECK(ticks >= 0);
          slowest = std::max(slowest, ticks);
          sum += ticks;
          ++runs;
        }
      }
  INFO("learnt after " << sum / runs << " ms on average, " << slowest << " ms at most");
  CHECK(slowest < 500);
  if (test::longRun()) WARN("learnt after " << sum / runs << " ms on average, " << slowest << " ms at most");
}

// Counts flicker, the servo reacts, and nothing else moves: this would look like the lightest possible device.
TEST_CASE("a tool at rest does not teach the servo a wrong inertia", "[position_control]") {
  const auto device = tau();
  for (const double noise : {0.0, 0.1}) {
    PositionControlRenderer servo(optionsFor(*device, 0));
    VirtualLoop loop(*device, *device, servo, loopWith(flatWall(), 0));
    const RandomStream random(1, 1);
    TickRecord tick;
    for (std::uint64_t i = 0; i < 1500; ++i) {
      const FirmHand hand{1.0 + noise * random.normal(RandomStream::Purpose::noise, i)};
      REQUIRE(loop.tick(hand, tick) == Status::ok);
    }
    INFO("a hand that trembles by " << noise << " N");
    CHECK(1.0 / servo.state().mass == Approx(1.0).epsilon(0.2));
  }
}

TEST_CASE("the servo never pulls, pushes along the normal only, and lets the tool slide", "[position_control]") {
  const auto device = tau();
  test::Random random(3);
  for (int direction = 0; direction < 10; ++direction) {
    const Vec3 normal = (Vec3::UnitZ() + 0.6 * random.vector(1.0)).normalized();
    const Vec3 along = normal.cross(Vec3::UnitX()).normalized();
    Scene scene;
    scene.add(halfSpace("wall", Vec3::Zero(), normal));
    PositionControlRenderer servo(optionsFor(*device, 0));
    VirtualLoop loop(*device, *device, servo, loopWith(scene, 0));
    TickRecord tick;
    double tangential = 0.0, pressed = 0.0, squares = 0.0, speed = 0.0;
    for (int i = 0; i < 600; ++i) {
      // Pressed with 10 N and pulled along at up to 0.1 m/s, then pulled off.
      const Vec3 drag = i < 100 ? Vec3::Zero() : Vec3(20.0 * (0.1 - along.dot(tick.twist.head<3>())) * along);
      const Hand hand{i < 500 ? Vec3(-10.0 * std::min(1.0, i / 50.0) * normal + drag) : Vec3(1.0 * normal)};
      REQUIRE(loop.tick(hand, tick) == Status::ok);
      const double force = normal.dot(tick.rendered.head<3>());
      CHECK(force > -1e-3);  // gravity of rounded joint angles
      if (i >= 200 && i < 500) {
        tangential += (tick.rendered.head<3>() - force * normal).norm();
        pressed += force;
        squares += tick.nearest.gap * tick.nearest.gap;
        speed = along.dot(tick.twist.head<3>());
      }
    }
    CHECK(tangential < 1e-3 * pressed);
    CHECK(std::sqrt(squares / 300.0) < 10e-6);
    CHECK(speed > 0.05);
    CHECK(tick.nearest.gap > 1e-3);  // it was released
    CHECK(tick.mode == RenderMode::free);
  }
}

TEST_CASE("friction holds below its limit and drags above it", "[position_control]") {
  const auto device = tau();
  for (const double pull : {2.0, 4.0}) {  // pressed with 10 N, mu_s = 0.3: it sticks, then slides
    PositionControlRenderer servo(optionsFor(*device, 0));
    VirtualLoop loop(*device, *device, servo, loopWith(wallOf(HUGE_VAL, 0.3, 0.25), 0));
    TickRecord tick;
    double along = 0.0, pressed = 0.0;
    for (int i = 0; i < 250; ++i) {
      REQUIRE(loop.tick(Hand{{i < 200 ? 0.0 : pull, 0, -10.0}}, tick) == Status::ok);
      if (i >= 220) {
        along -= tick.rendered[0];
        pressed += tick.rendered[2];
      }
    }
    if (pull < 3.0) {
      CHECK(std::abs(tick.pose.position.x()) < 0.3e-3);
      CHECK(along == Approx(0.2 * pressed).epsilon(0.1));
    } else {
      CHECK(tick.pose.position.x() > 2e-3);
      CHECK(along == Approx(0.25 * pressed).epsilon(0.1));
    }
  }
}

TEST_CASE("only the lower triangle of an inertia counts", "[position_control]") {
  const std::shared_ptr<const Mechanism> device = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  const auto stateWith = [&](double added) {  // to an element above the diagonal
    PositionControlRenderer renderer(positionControlFor(*device, 1e-3, 0, 0));
    renderer.activate(1e-3);
    TickFrame frame = test::frameAt(*device, test::poseAtDepth(1e-4), 1.0);
    frame.kinematics.inertia(0, 2) += added;
    TickOutput output;
    REQUIRE(fillContactRows(frame) == Status::ok);
    REQUIRE(renderer.step(frame, output) == Status::ok);
    std::vector<double> state(renderer.stateSize() / sizeof(double));
    renderer.saveState(state.data());
    return state;
  };
  CHECK(stateWith(1e-6) == stateWith(0.0));
}

TEST_CASE("a soft surface gives way by its stiffness", "[position_control]") {
  const auto device = tau();
  PositionControlRenderer servo(optionsFor(*device, 0));
  VirtualLoop loop(*device, *device, servo, loopWith(wallOf(2000.0, 0.0, 0.0), 0));
  TickRecord tick;
  for (int i = 0; i < 800; ++i) REQUIRE(loop.tick(FirmHand{4.0}, tick) == Status::ok);
  CHECK(-tick.nearest.gap == Approx(4.0 / 2000.0).epsilon(0.03));
}

TEST_CASE("a surface that is lowered is followed, one that vanishes has no force", "[position_control]") {
  const auto device = tau();
  PositionControlRenderer servo(optionsFor(*device, 0));
  servo.activate(kPeriod);
  TickFrame input;
  input.kinematics = device->home();
  input.maxTorque = device->limits().effort;
  input.contacts.count = 1;
  TickOutput output;
  for (int i = 0; i < 50; ++i) {
    input.time = kPeriod * i;
    input.contacts.contacts[0].gap = -1e-5;
    REQUIRE(fillContactRows(input) == Status::ok);
    REQUIRE(servo.step(input, output) == Status::ok);
  }
  CHECK(output.normalForce > 0.0);
  input.time += kPeriod;
  input.contacts.contacts[0].gap = 1e-3;
  REQUIRE(servo.step(input, output) == Status::ok);
  CHECK(output.normalForce == 0.0);
  CHECK(output.torque.isApprox(input.kinematics.gravity));
  input.time += kPeriod;
  input.contacts.count = 0;
  CHECK(servo.step(input, output) == Status::outOfRange);  // the number of rows differs from that of the contacts
  REQUIRE(fillContactRows(input) == Status::ok);
  REQUIRE(servo.step(input, output) == Status::ok);
  CHECK(output.mode == RenderMode::free);
}

TEST_CASE("a contact that vanishes does not follow the tool with its last velocity", "[position_control]") {
  const auto device = tau();
  for (const double speed : {0.05, 0.0, -0.05}) {  // of the surface towards the tool, m/s
    PositionControlRenderer servo(optionsFor(*device, 0));
    servo.activate(kPeriod);
    TickFrame input;
    input.kinematics = device->home();
    input.maxTorque = device->limits().effort;
    TickOutput output;
    const auto step = [&](int contacts) {
      input.time += kPeriod;
      input.contacts.count = contacts;
      input.contacts.contacts[0].gap = -3e-5;
      input.contacts.contacts[0].obstacleVelocity = speed * input.contacts.contacts[0].normal;
      REQUIRE(fillContactRows(input) == Status::ok);
      REQUIRE(servo.step(input, output) == Status::ok);
      return wrenchOf(input.kinematics, output.torque - input.kinematics.gravity)[2];
    };
    double force = 0.0;  // the tool does not move: a hand holds it
    for (int i = 0; i < 50; ++i) force = step(1);
    if (speed >= 0.0) REQUIRE(force > 1.0);
    for (int i = 0; i < 400; ++i) force = step(0);
    INFO("speed " << speed << " m/s");
    CHECK(std::abs(force) < 1e-9);
  }
}

TEST_CASE("a soft surface that vanishes while it is pressed does not push harder", "[position_control]") {
  const auto device = tau();
  PositionControlRenderer servo(optionsFor(*device, 0));
  VirtualLoop loop(*device, *device, servo, loopWith(wallOf(2000.0, 0.0, 0.0), 0));
  TickRecord tick;
  for (int i = 0; i < 1000; ++i) REQUIRE(loop.tick(Hand{{0.0, 0.0, -4.0}}, tick) == Status::ok);
  const auto forceOf = [&](const TickFrame& frame, const JointVector& torque) {
    return wrenchOf(frame.kinematics, torque - frame.kinematics.gravity)[2];
  };
  TickFrame frame = loop.frame();
  const double pressed = forceOf(frame, tick.command);
  REQUIRE(pressed == Approx(4.0).epsilon(0.2));
  frame.contacts.count = 0;
  REQUIRE(fillContactRows(frame) == Status::ok);
  TickOutput output;
  for (int i = 0; i < 20; ++i) {
    frame.time += kPeriod;
    REQUIRE(servo.step(frame, output) == Status::ok);
    INFO("tick " << i);
    CHECK(forceOf(frame, output.torque) < 1.2 * pressed);
  }
}

TEST_CASE("walls that face each other too near by micrometres do not hold the tool", "[position_control]") {
  const auto device = tau();
  Scene scene;
  for (const double side : {-1.0, 1.0}) {
    Obstacle wall =
        halfSpace(side > 0.0 ? "right" : "left", Vec3(-side * (1e-3 - 2e-6), 0.0, 0.0), side * Vec3::UnitX());
    wall.material.friction = wall.material.slidingFriction = 0.3;
    scene.add(wall);
  }
  LoopSetup setup = loopWith(scene, 0);
  setup.tool.parts[0].radius = 1e-3;
  PositionControlRenderer servo(optionsFor(*device, 0));
  VirtualLoop loop(*device, *device, servo, setup);
  TickRecord tick;
  double largest = 0.0;
  int contact = 0;                 // ticks
  for (int i = 0; i < 300; ++i) {  // pulled out between the walls with 2 N
    REQUIRE(loop.tick(Hand{{0.0, 0.0, i < 200 ? 0.0 : 2.0}}, tick) == Status::ok);
    largest = std::max(largest, tick.normalForce);
    contact += tick.mode == RenderMode::contact;
  }
  CHECK(contact > 250);
  CHECK(largest < 10.0);  // it was about 200 N, and the tool stuck
  CHECK(tick.pose.position.z() > 5e-3);
}

TEST_CASE("the servo's state can be copied: the same ticks, the same bits", "[position_control]") {
  const auto device = tau();
  PositionControlRenderer servo(optionsFor(*device, 2)), copy(optionsFor(*device, 2));
  VirtualLoop loop(*device, *device, servo, loopWith(wallOf(HUGE_VAL, 0.2, 0.2), 2));
  TickRecord tick;
  std::vector<TickFrame> inputs;
  std::vector<JointVector> torques;
  std::vector<char> state;
  for (int i = 0; i < 300; ++i) {
    REQUIRE(loop.tick(Hand{{std::sin(0.1 * i), 0, i < 150 ? -2.0 : -12.0}}, tick) == Status::ok);
    if (i == 100) {
      state.resize(servo.stateSize());
      servo.saveState(state.data());
    } else if (i > 100) {
      inputs.push_back(loop.frame());
      torques.push_back(tick.command);
    }
  }
  copy.activate(kPeriod);
  copy.loadState(state.data());
  TickOutput output;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    REQUIRE(copy.step(inputs[i], output) == Status::ok);
    REQUIRE(output.torque == torques[i]);
  }
}

TEST_CASE("the servo survives a state in which any one number is wrong", "[position_control]") {
  const auto device = tau();
  PositionControlRenderer servo(optionsFor(*device, 0));
  VirtualLoop loop(*device, *device, servo, loopWith(wallOf(HUGE_VAL, 0.2, 0.2), 0));
  TickRecord tick;
  for (int i = 0; i < 30; ++i) REQUIRE(loop.tick(Hand{{0.3, 0.0, i < 28 ? -2.0 : -9.0}}, tick) == Status::ok);
  std::vector<double> good(servo.stateSize() / sizeof(double));
  servo.saveState(good.data());
  const TickFrame begin = loop.frame();
  const JointVector& limits = device->limits().effort;
  for (std::size_t at = 0; at < good.size(); ++at)
    for (const double wrong : {0.0, -3.0, 5e-324, 1e300}) {
      std::vector<double> state = good;
      state[at] = wrong;
      servo.loadState(state.data());
      TickFrame frame = begin;
      TickOutput output;
      for (int i = 0; i < 3; ++i) {
        frame.time += kPeriod;
        const Status status = servo.step(frame, output);
        INFO("number " << at << " is " << wrong << ", tick " << i);
        REQUIRE(output.torque.allFinite());
        if (status == Status::ok) REQUIRE((output.torque.cwiseAbs() - limits).maxCoeff() <= 0.0);
      }
    }
}

TEST_CASE("the servo's options are checked", "[position_control]") {
  const auto device = tau();
  const PositionControlOptions good = optionsFor(*device, 0);
  const auto refuse = [&](const std::string& message, const auto& damage) {
    PositionControlOptions bad = good;
    damage(bad);
    CHECK_THROWS_WITH(PositionControlRenderer(bad), message);
  };
  refuse("position control: 0 encoder steps, must be 1 to 7", [](auto& o) { o.encoderStep.resize(0); });
  refuse("position control: encoder step 2 is 0, must be positive", [](auto& o) { o.encoderStep[2] = 0.0; });
  refuse("position control: 5 largest torques, must be one for each encoder step",
         [](auto& o) { o.effort.conservativeResize(5); });
  refuse("position control: largest torque 1 is -1, must be 0 or more", [](auto& o) { o.effort[1] = -1.0; });
  refuse("position control: delay is 0 to 9 ticks, must be within 0 to 8, the smallest first",
         [](auto& o) { o.delayHigh = 9; });
  refuse("position control: delay is 3 to 2 ticks, must be within 0 to 8, the smallest first",
         [](auto& o) { o.delayLow = 3, o.delayHigh = 2; });
  refuse("position control: period is nan s, must be in 1e-5 to 0.1 s", [](auto& o) { o.period = std::nan(""); });
  refuse("position control: a parameter of the drive is -1, must be zero or positive",
         [](auto& o) { o.drive.bandwidth = -1.0; });
  refuse("position control: a cable stiffness of 1000 requires a rotor inertia greater than 0",
         [](auto& o) { o.drive.stiffness = 1000.0; });
  PositionControlRenderer servo(good);
  CHECK_THROWS_AS(servo.activate(2e-3), Error);
  servo.activate(kPeriod);
  TickFrame input;
  TickOutput output;
  CHECK(servo.step(input, output) == Status::outOfRange);
}

}  // namespace enamel::test_position_control
