// Position control in difficult cases: corners, slots, impacts, motors at their limits, tools far from the TCP, teeth.
#include "enamel/render/position_control.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <iostream>

#include "enamel/collision/scene_file.hpp"
#include "enamel/collision/tool_sweep.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "enamel/study/wall_design.hpp"
#include "enamel/study/wall_trials.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_position_control {

namespace {

constexpr double kPeriod = 1e-3;

struct Setting {
  Scene scene;
  Tool tool;
  Pose start;
  int delay = 0;
};

// Run the loop; force(time, pose, twist) is the person's on the TCP, `seen` is called at every tick. Return false if
// lost.
using Force = std::function<Vec3(double, const Pose&, const Vec6&)>;
bool run(const Mechanism& device, Renderer& renderer, const Setting& setting, double duration, const Force& force,
         const std::function<void(const TickRecord&)>& seen) {
  LoopSetup setup;
  setup.scene = setting.scene;
  setup.tool = setting.tool;
  setup.start = setting.start;
  setup.delay = {setting.delay, setting.delay};
  setup.encoders = {true, RateSource::difference};
  VirtualLoop loop(device, device, renderer, setup);
  const auto load = [&](double time, const Pose& pose, const Vec6& twist) {
    Vec6 wrench;
    wrench << force(time, pose, twist), holdingMoment(pose.rotation, setup.start.rotation, twist.tail<3>());
    return wrench;
  };
  TickRecord tick;
  for (int i = 0; i < std::lround(duration / kPeriod); ++i) {
    if (loop.tick(load, tick) != Status::ok || tick.status != Status::ok) return false;
    seen(tick);
  }
  return true;
}

PositionControlRenderer servoFor(const Mechanism& device, int delay) {
  return PositionControlRenderer(positionControlFor(device, kPeriod, delay, delay));
}

Scene wallsWith(const std::vector<Vec3>& normals) {
  Scene scene;
  for (const Vec3& n : normals) {
    const std::string name = std::to_string(scene.obstacles().size());
    scene.add(halfSpace(name, Vec3::Zero(), n.normalized()));
  }
  return scene;
}

Tool ball(double radius, const Vec3& centre = Vec3::Zero()) {
  Tool tool;
  tool.parts[0] = {centre, centre, radius};
  return tool;
}

// Return the amplitude of a motor torque's strongest oscillation above 20 Hz, N m: the largest line of the spectrum.
double strongestLine(const std::vector<JointVector>& torques) {
  const auto count = static_cast<int>(torques.size());
  double strongest = 0.0;
  for (Eigen::Index joint = 0; joint < torques[0].size(); ++joint)
    for (int line = 20 * count / 1000; line < count / 2; line += 2) {
      double c = 0.0, s = 0.0;
      for (int i = 0; i < count; ++i) {
        const double phase = 2.0 * M_PI * line * i / count;
        c += torques[static_cast<std::size_t>(i)][joint] * std::cos(phase);
        s += torques[static_cast<std::size_t>(i)][joint] * std::sin(phase);
      }
      strongest = std::max(strongest, 2.0 / count * std::hypot(c, s));
    }
  return strongest;
}

// Return the rms deviation of the motors' force on a tool from its mean over a second, N. A hand with a tremor of 0.2 N
// presses the tool against walls. `end`: where the tool is at the end.
double chatterAmong(const Mechanism& device, const Scene& walls, const Tool& tool, const Vec3& start, const Vec3& push,
                    int delay, Vec3* end = nullptr) {
  PositionControlRenderer servo = servoFor(device, delay);
  test::Random random(31);
  double square = 0.0, count = 0.0;
  Vec3 sum = Vec3::Zero();
  REQUIRE(run(
      device, servo, {walls, tool, {start, Mat3::Identity()}, delay}, 2.0,
      [&](double time, const Pose&, const Vec6& twist) {
        return Vec3(std::min(1.0, time / 0.2) * push + random.vector(0.2) - 3.6 * twist.head<3>());
      },
      [&](const TickRecord& tick) {
        if (end != nullptr) *end = tick.pose.position;
        if (tick.time < 1.0) return;
        const Vec3 force = tick.rendered.head<3>();
        square += force.squaredNorm();
        sum += force;
        count += 1.0;
      }));
  return std::sqrt(square / count - (sum / count).squaredNorm());
}

}  // namespace

// Walls hold the tool in one direction or in two. Two that chatter alike give 1.4 times one.
TEST_CASE("among several walls the motors chatter hardly more than at one", "[hard]") {
  const TauMechanism device(test::nominal());
  struct Case {
    std::string name;
    Scene walls;
    Vec3 start;
  };
  std::vector<Case> cases;
  cases.push_back({"corner", wallsWith({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), {0.003, 0.003, 0.003}});
  for (const double degrees : {90.0, 60.0, 30.0}) {
    const double half = 0.5 * degrees * M_PI / 180.0;
    cases.push_back({std::to_string(degrees) + " deg",
                     wallsWith({{std::cos(half), 0, std::sin(half)}, {-std::cos(half), 0, std::sin(half)}}),
                     {0, 0, 0.003 / std::sin(half)}});
  }
  for (const double clearance : {0.0, -5e-6, 20e-6}) {
    Scene slot;
    slot.add(halfSpace("left", {-0.003 - 0.5 * clearance, 0, 0}, Vec3::UnitX()));
    slot.add(halfSpace("right", {0.003 + 0.5 * clearance, 0, 0}, -Vec3::UnitX()));
    slot.add(halfSpace("floor", Vec3::Zero(), Vec3::UnitZ()));
    cases.push_back({"slot, clearance " + std::to_string(1e6 * clearance) + " um", slot, {0, 0, 0.003}});
  }
  const Vec3 push(0, 0, -2);
  for (int delay = 0; delay <= 2; delay += test::count(2, 1)) {
    const double one = chatterAmong(device, wallsWith({{0, 0, 1}}), ball(0.003), {0, 0, 0.003}, push, delay);
    for (const Case& c : cases) {
      const double several = chatterAmong(device, c.walls, ball(0.003), c.start, push, delay);
      INFO(c.name << ", delay " << delay << ": " << several << " N, at a plane " << one << " N");
      CHECK(several < 1.5 * one);
    }
  }
}

// The bottom of a fissure holds the tool in three directions: 1.7 times the chatter of one, or 1.5 times that of two.
// Friction must not hold again what the walls hold, which would give 2.2 to 2.7 times.
TEST_CASE("in a fissure of a molar the motors chatter as in three directions", "[hard]") {
  const TauMechanism device(test::nominal());
  const SceneFile molar = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/molar.toml");
  const auto withFriction = [](const Scene& scene, double friction) {
    Scene same;
    for (Obstacle obstacle : scene.obstacles()) {
      obstacle.material.friction = obstacle.material.slidingFriction = friction;
      same.add(obstacle);
    }
    return same;
  };
  const Vec3 push(0, 0, -2);
  Vec3 bottom;
  chatterAmong(device, withFriction(molar.scene, 0.0), molar.tool, {0.0008, 0.0002, 0.003}, push, 0, &bottom);
  bottom.z() += 1e-4;
  for (int delay = 0; delay <= 2; delay += test::count(2, 1))
    for (const double friction : {0.0, 0.2}) {
      const double one =
          chatterAmong(device, withFriction(wallsWith({{0, 0, 1}}), friction), ball(0.003), {0, 0, 0.003}, push, delay);
      const double fissure = chatterAmong(device, withFriction(molar.scene, friction), molar.tool, bottom, push, delay);
      INFO("friction " << friction << ", delay " << delay << ": " << fissure << " N, at a plane " << one << " N");
      CHECK(fissure > one);
      CHECK(fissure < 1.5 * std::sqrt(1.5) * one);
    }
}

TEST_CASE("corners, valleys and slots hold without oscillation", "[hard]") {
  const TauMechanism device(test::nominal());
  const double steep = 15.0 * M_PI / 180.0;
  struct Case {
    const char* name;
    Setting setting;
    Vec3 push;
    double depth;  // allowed, m
  };
  std::vector<Case> cases;
  const auto add = [&](const char* name, const Scene& scene, const Vec3& start, const Vec3& push, double depth) {
    cases.push_back({name, {scene, ball(0.003), {start, Mat3::Identity()}, 0}, push, depth});
  };
  add("90 deg", wallsWith({{1, 0, 0}, {0, 0, 1}}), {0.006, 0, 0.006}, {-7, 0, -7}, 1e-4);
  add("30 deg", wallsWith({{std::cos(steep), 0, std::sin(steep)}, {-std::cos(steep), 0, std::sin(steep)}}),
      {0, 0, 0.02}, {0, 0, -10}, 1e-4);
  add("three walls", wallsWith({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), {0.006, 0.006, 0.006}, {-6, -6, -6}, 1e-4);
  add("dependent walls", wallsWith({{0, 0, 1}, {2e-4, 0, 1}, {-2e-4, 0, 1}, {0, 1e-4, 1}}), {0, 0, 0.004}, {0, 0, -10},
      1e-4);
  for (const double narrow : {0.0, 1e-4, 2e-4}) {  // every pose penetrates: half of the overlap on each side
    Scene scene;
    scene.add(halfSpace("left", {-0.003 + 0.5 * narrow, 0, 0}, Vec3::UnitX()));
    scene.add(halfSpace("right", {0.003 - 0.5 * narrow, 0, 0}, -Vec3::UnitX()));
    scene.add(halfSpace("floor", {0, 0, -0.004}, Vec3::UnitZ()));
    add("slot", scene, {0, 0, 0.004}, {0, 0, -8}, 1e-4 + 0.5 * narrow);
  }
  for (int delay = 0; delay <= 3; delay += test::count(3, 1))
    for (Case& c : cases) {
      c.setting.delay = delay;
      PositionControlRenderer servo = servoFor(device, delay);
      std::vector<JointVector> torques;
      double deepest = 0.0;
      const bool stayed = run(
          device, servo, c.setting, 3.0,
          [&](double time, const Pose&, const Vec6& twist) {
            return Vec3(std::min(1.0, time / 0.2) * c.push - 3.6 * twist.head<3>());
          },
          [&](const TickRecord& tick) {
            if (tick.time > 1.0) deepest = std::max(deepest, -tick.nearest.gap);
            if (tick.time >= 2.0) torques.push_back(tick.command);
          });
      INFO(c.name << ", delay " << delay);
      REQUIRE(stayed);
      CHECK(strongestLine(torques) < 0.02);
      CHECK(deepest < c.depth);
    }
}

// Limits that the controller misses; the next test checks them.
bool isMissed(const WallFigure& f, int delay, double wrong) {
  return (f.trial == "overload" && (delay == 0 || delay == 3)) ||
         (f.trial == "slide" && f.figure == "rms depth" && wrong < 1.0 && delay > 0);
}

// Ordinary actions on a wall, also with a model whose inertia is wrong by 30 %. The limits are for a few dozen runs.
// Missed limits are listed with their values in lib/docs/limits.md.
TEST_CASE("steps, impacts, letting go, sliding and too much force are answered", "[hard]") {
  WallTrialSetup setup;
  setup.plant = std::make_shared<TauMechanism>(test::nominal());
  setup.runs = test::count(6, 200);
  struct Bar {
    const char* trial;
    const char* figure;
    double most[4];  // by delay
  };
  const Bar bars[] = {
      {"impact 0.05 m/s", "depth of the allowed", {100, 100, 100, 100}},
      {"impact 0.2 m/s", "depth of the allowed", {100, 100, 100, 100}},
      {"impact 0.5 m/s", "depth of the allowed", {100, 100, 100, 100}},
      {"impact 0.05 m/s", "bounce", {450, 450, 450, 450}},  // the goal is 200: rare runs
      {"impact 0.2 m/s", "bounce", {450, 450, 450, 450}},
      {"impact 0.5 m/s", "bounce", {450, 450, 450, 450}},
      {"release", "speed over the unavoidable", {1.25, 1.25, 1.25, 1.25}},  // goal 1.1
      {"release", "pull", {1e-3, 1e-3, 1e-3, 1e-3}},
      {"slide", "tangential force", {0.1, 0.1, 0.3, 0.4}},
      {"slide", "rms depth", {10, 20, 30, 50}},
      {"pulse", "torque of the limit", {100.001, 100.001, 100.001, 100.001}},
      {"pulse", "turned", {1, 1, 1, 1}},
      {"overload", "bounce", {60, 130, 280, 450}},  // goal 100, impossible with 2 and 3 ticks (limits.md)
  };
  for (const double wrong : {1.0, 0.7, 1.3}) {
    setup.model = withInertia(setup.plant, wrong);
    for (const int delay : {0, 1, 2, 3}) {
      setup.delay = {delay, delay};
      setup.renderer = [options = positionControlFor(*setup.plant, kPeriod, delay, delay)] {
        return std::make_unique<PositionControlRenderer>(options);
      };
      for (const WallFigure& f : runWallTrials(setup, "", 2)) {
        INFO("delay " << delay << ", model's inertia by " << wrong << ", " << f.trial << ": " << f.figure << " is "
                      << f.value << " " << f.unit);
        CHECK(f.lost == 0);
        CHECK(std::isfinite(f.value));
        // Too light a model: the mass is learnt in the tick after the first command. Otherwise 2.4 to 28 mm.
        if (wrong < 1.0 && f.trial == "impact 0.5 m/s" && f.figure == "bounce") CHECK(f.value < 450);
        // Too heavy a model: 3.3 and 3.9 mm with 2 and 3 ticks if the cap assumes that the mass is known.
        if (wrong > 1.0 && f.trial == "impact 0.5 m/s" && f.figure == "bounce") CHECK(f.value < 1000);
        for (const Bar& bar : bars)
          if (f.trial == bar.trial && f.figure == bar.figure && (wrong == 1.0 || f.trial == "slide") &&
              !isMissed(f, delay, wrong))
            CHECK(f.value < bar.most[delay]);
      }
    }
  }
}

TEST_CASE(
    "an overload and a slide with too light a model are answered "
    "(expected failure at 2 and 3 ticks, lib/docs/limits.md)",
    "[!shouldfail][hard]") {
  WallTrialSetup setup;
  setup.plant = std::make_shared<TauMechanism>(test::nominal());
  setup.runs = test::count(6, 200);
  const double overload[] = {60, 130, 280, 450}, slide[] = {10, 20, 30, 50};
  for (const int delay : {0, 1, 2, 3}) {
    setup.delay = {delay, delay};
    setup.renderer = [options = positionControlFor(*setup.plant, kPeriod, delay, delay)] {
      return std::make_unique<PositionControlRenderer>(options);
    };
    setup.model = setup.plant;
    for (const WallFigure& f : runWallTrials(setup, "overload", 2)) CHECK(f.value < overload[delay]);
    setup.model = withInertia(setup.plant, 0.7);
    for (const WallFigure& f : runWallTrials(setup, "slide", 2))
      if (f.figure == "rms depth") CHECK(f.value < slide[delay]);
  }
}

// The same with commands that come at random, are skipped and act again.
TEST_CASE("impacts and too much force are answered where the delay is random", "[hard]") {
  WallTrialSetup setup;
  setup.plant = std::make_shared<TauMechanism>(test::nominal());
  setup.runs = test::count(8, 400);
  for (const double wrong : {1.0, 0.7, 1.3}) {
    setup.model = withInertia(setup.plant, wrong);
    for (const Delay& delay : {Delay{0, 1}, Delay{0, 3}, Delay{1, 2}, Delay{2, 5}}) {
      setup.delay = delay;
      setup.renderer = [options = positionControlFor(*setup.plant, kPeriod, delay.low, delay.high)] {
        return std::make_unique<PositionControlRenderer>(options);
      };
      for (const WallFigure& f : runWallTrials(setup, "", 2)) {
        INFO("delay " << delay.low << " to " << delay.high << ", model's inertia by " << wrong << ", " << f.trial
                      << ": " << f.figure << " is " << f.value << " " << f.unit);
        CHECK(f.lost == 0);
        const bool depth = f.figure == "depth of the allowed", bounce = f.figure == "bounce";
        if (wrong == 1.0 && delay.high <= 3 && depth) CHECK(f.value < 120);
        // 25 mm for a controller based on the mean of the pending commands.
        if (wrong == 1.0 && delay.high <= 3 && bounce) CHECK(f.value < 8e3);
        if (f.figure == "pull") CHECK(f.value < 5e-3);
        if (f.figure == "turned") CHECK(f.value < 1.0);
      }
    }
  }
}

TEST_CASE("a tip 60 mm from the TCP is as good, as a share of its own limit", "[hard]") {
  const TauMechanism device(test::nominal());
  test::Random random(17);
  const Vec3 offset(0, 0, -0.06);
  for (int i = 0; i < test::count(12, 200); ++i) {
    const int delay = i % 4;
    const Vec3 normal = random.direction();
    Setting setting{Scene(), ball(0.0, offset), {random.vector(0.02), Mat3::Identity()}, delay};
    const Vec3 tip = setting.start.position + offset;
    setting.scene.add(halfSpace("wall", tip, normal));
    Kinematics k = device.home();
    REQUIRE(device.reach(setting.start, Vec6::Zero(), true, k) == Status::ok);
    Vec6 unit;
    unit << normal, offset.cross(normal);
    const JointVector torque = torqueOf(k.jacobian, unit);
    double most = 1e9;
    for (int j = 0; j < 6; ++j)
      most = std::min(most, (device.limits().effort[j] - std::copysign(k.gravity[j], torque[j] * k.gravity[j])) /
                                std::abs(torque[j]));
    const double preload = 0.05 * most, push = 0.35 * most;
    PositionControlRenderer servo = servoFor(device, delay);
    // The person holds the tip, so that the load is a separate wrench.
    LoopSetup setup;
    setup.scene = setting.scene;
    setup.tool = setting.tool;
    setup.start = setting.start;
    setup.delay = {delay, delay};
    setup.encoders = {true, RateSource::difference};
    VirtualLoop loop(device, device, servo, setup);
    double deepest = 0.0, rest = 0.0;
    TickRecord tick;
    for (int t = 0; t < 900; ++t) {
      const double pressed = t >= 600 ? push : preload;
      const auto load = [&](double, const Pose& pose, const Vec6& twist) {
        const Vec3 arm = pose.rotation * offset;
        const Vec3 pull = kGuideGrip.stiffness * (pose.position + arm - tip) +
                          kGuideGrip.damping * (twist.head<3>() + twist.tail<3>().cross(arm));
        const Vec3 force = -pressed * normal - (pull - normal.dot(pull) * normal);
        Vec6 wrench;
        wrench << force, arm.cross(force) + holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
        return wrench;
      };
      REQUIRE(loop.tick(load, tick) == Status::ok);
      if (t >= 500 && t < 600) rest += 0.01 * tick.nearest.gap;
      if (t >= 600) deepest = std::max(deepest, rest - tick.nearest.gap);
    }
    const double limit = firstImpactLimit(effectiveMass(k, tip, normal), kPeriod, delay, push, most, preload);
    INFO("case " << i << ": " << (push - preload) / deepest << " N/m of " << limit);
    CHECK((push - preload) / deepest > 0.3 * limit);
  }
}

// Return the highest place that a tool touches when it comes down near `around`.
Vec3 highestNear(const Scene& scene, const Tool& tool, const Vec3& around) {
  Vec3 highest(0, 0, -1.0);
  for (double x = -0.006; x <= 0.006; x += 0.0005)
    for (double y = -0.006; y <= 0.006; y += 0.0005) {
      const Vec3 place(around.x() + x, around.y() + y, 0.0);
      const ToolSweep hit = sweepTool(scene, tool, {place + Vec3(0, 0, 0.03), Mat3::Identity()},
                                      {place - Vec3(0, 0, 0.03), Mat3::Identity()}, nullptr);
      if (hit.hit && hit.contact.point.z() > highest.z()) highest = {place.x(), place.y(), hit.contact.point.z()};
    }
  return highest;
}

// A hand moves in circles over a tooth and presses against it. The tool slides, with both renderers.
TEST_CASE("a tool slides over teeth", "[hard]") {
  const TauMechanism device(test::nominal());
  for (const char* name : {"molar.toml", "jaw.toml"}) {
    const SceneFile file = loadScene(std::string(ENAMEL_SOURCE_DIR "/data/scenes/") + name);
    const Vec3 start = highestNear(file.scene, file.tool, file.start) + Vec3(0, 0, 5e-4);
    for (const double friction : {0.0, 0.2})
      for (const bool isServo : {true, false}) {
        PositionControlRenderer servo = servoFor(device, 0);
        ImpedanceRenderer spring({2000.0, 2.0});
        Renderer& renderer = isServo ? static_cast<Renderer&>(servo) : spring;
        Setting setting{Scene(), file.tool, {start, Mat3::Identity()}, 0};
        for (Obstacle obstacle : file.scene.obstacles()) {
          obstacle.material.friction = obstacle.material.slidingFriction = friction;
          setting.scene.add(obstacle);
        }
        // A target below the surface presses with 3 N. With friction 0.2 that would hold 1.5 mm of the hand's path,
        // more than the circle has. With friction, use half of that force.
        const double below = friction > 0.0 ? 3.75e-3 : 7.5e-3;
        double way = 0.0, deepest = 0.0, touching = 0.0, fastest = 0.0;
        Vec3 last = start;
        const double duration = test::longRun() ? 30.0 : 6.0;
        const bool stayed = run(
            device, renderer, setting, duration,
            [&](double time, const Pose& pose, const Vec6& twist) {
              const Vec3 led = start + Vec3(1e-3 * std::sin(4.0 * time), 1e-3 * (std::cos(4.0 * time) - 1.0), -below);
              return Vec3(400.0 * (led - pose.position) - 6.0 * twist.head<3>());
            },
            [&](const TickRecord& tick) {
              way += (tick.pose.position - last).norm();
              last = tick.pose.position;
              if (tick.time < 0.5) return;
              deepest = std::max(deepest, -tick.nearest.gap);
              fastest = std::max(fastest, tick.twist.head<3>().norm());
              if (tick.mode == RenderMode::contact) touching += kPeriod;
            });
        INFO(name << ", friction " << friction << (isServo ? ", servo" : ", spring"));
        REQUIRE(stayed);
        std::cout << name << ", friction " << friction << (isServo ? ", servo" : ", spring") << ": way " << 1e3 * way
                  << " mm, deepest " << 1e6 * deepest << " um, fastest " << fastest << " m/s, in contact "
                  << touching / (duration - 0.5) << "\n";
        CHECK(way > (friction > 0.0 ? 0.001 : 0.002) * duration);  // the hand moves at 4 mm/s
        CHECK(touching > 0.5 * (duration - 0.5));
        CHECK(fastest < 0.2);
        if (isServo) CHECK(deepest < 0.1e-3);
      }
  }
}

// Encoder counts make a light push flicker between zero and a multiple of its force, and rates jump by mm/s. A tool
// held by friction must not creep because of them.
TEST_CASE("friction holds a light push against the counts of encoders", "[hard]") {
  const TauMechanism device(test::nominal());
  const SceneFile molar = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/molar.toml");
  Scene wall;
  Obstacle floor = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());
  floor.material.friction = floor.material.slidingFriction = 0.2;
  wall.add(floor);
  const Vec3 top = highestNear(molar.scene, molar.tool, molar.start);
  struct Case {
    const char* name;
    Setting setting;
    double press, aside;  // N
  };
  const double duration = test::longRun() ? 10.0 : 1.5;
  for (const Case& c : {Case{"wall", {wall, ball(0.003), {{0, 0, 0.003}, Mat3::Identity()}, 0}, 1.0, 0.1},
                        Case{"wall", {wall, ball(0.003), {{0, 0, 0.003}, Mat3::Identity()}, 0}, 1.0, 0.3},
                        Case{"wall", {wall, ball(0.003), {{0, 0, 0.003}, Mat3::Identity()}, 1}, 2.0, 0.2},
                        Case{"molar", {molar.scene, molar.tool, {top, Mat3::Identity()}, 0}, 1.0, 0.0},
                        Case{"molar", {molar.scene, molar.tool, {top, Mat3::Identity()}, 0}, 3.0, 0.0}}) {
    PositionControlRenderer servo = servoFor(device, c.setting.delay);
    Vec3 settled = Vec3::Zero(), last = Vec3::Zero();
    const bool stayed = run(
        device, servo, c.setting, duration,
        [&](double time, const Pose&, const Vec6& twist) {
          return Vec3(Vec3(time < 0.2 ? 0.0 : c.aside, 0.0, -c.press) - 5.0 * twist.head<3>());
        },
        [&](const TickRecord& tick) {
          if (tick.time < 0.2) settled = tick.pose.position;
          last = tick.pose.position;
        });
    const double way = (last - settled).norm();
    INFO(c.name << ", " << c.press << " N, aside " << c.aside << " N, delay " << c.setting.delay << ": " << 1e6 * way
                << " um");
    std::cout << c.name << ", " << c.press << " N, aside " << c.aside << " N: " << 1e6 * way << " um\n";
    if (c.aside <= 0.2 * c.press) {
      CHECK(stayed);
      // The grip yields by about 10 um, plus a few counts of 4 um.
      CHECK(way < 30e-6);
    } else {
      CHECK((!stayed || way > 5e-3));
    }
  }
}

TEST_CASE("the servo runs on a delta as it comes", "[hard]") {
  const auto device = makeMechanism(idealOf(loadDevice(test::deviceFile("delta.toml"))));
  for (const int delay : {0, 1, 2, 3}) {
    PositionControlRenderer servo = servoFor(*device, delay);
    double deepest = 0.0;
    const bool stayed = run(
        *device, servo, {flatWall(), Tool(), Pose{}, delay}, 1.5,
        [&](double time, const Pose& pose, const Vec6& twist) {
          Vec3 force = -100.0 * pose.position - 3.6 * twist.head<3>();
          force.z() = time > 1.0 ? -4.0 : -1.0;
          return force;
        },
        [&](const TickRecord& tick) {
          if (tick.time > 0.5) deepest = std::max(deepest, -tick.nearest.gap);
        });
    INFO("delay " << delay);
    CHECK(stayed);
    CHECK(deepest < 2e-3);
  }
}

}  // namespace enamel::test_position_control
