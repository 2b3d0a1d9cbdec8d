// A session is what its parts are: same bits. Changes while the loop runs: obstacles, tool, renderer, frames,
// recording.
#include "enamel/session/session.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <thread>

#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/sim/hand.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/eventually.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"
#include "support/session_bench.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_session {

using test::ball;
using test::Bench;
using test::ContainsSubstring;
using test::cube;
using test::definition;
using test::eventsOf;
using test::eventually;
using test::pushing;
using test::wallAt;

namespace {

constexpr double kPeriod = 1e-3;

}  // namespace

TEST_CASE("a session gives the same bits as the objects below it", "[session]") {
  SessionDef def = definition();
  def.scene = ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml";
  Bench bench(def);

  const auto mechanism = makeMechanism(DeviceParameters(test::nominal()));
  const SceneFile file = loadScene(def.scene);
  const auto renderer = makeLinked(kPositionControl, {}, mechanism, kPeriod);
  HapticTick tick(*mechanism, file.scene, file.tool, *renderer, kPeriod, *def.start);
  VirtualDevice device(*mechanism, Bench::setupOf(bench.session));
  for (int i = 0; i < 400; ++i) {
    bench.run(1);
    Measurement measurement;
    Command command;
    REQUIRE(device.measure(measurement) == Status::ok);
    REQUIRE(tick(measurement, command) == bench.status);
    REQUIRE(command.effort == bench.command.effort);
    REQUIRE(device.actuate(command) == Status::ok);
    REQUIRE(device.advance([&](double, const Pose& pose, const Vec6& twist) {
      return pushing(bench.force, *def.start, pose, twist);
    }) == Status::ok);
  }
  const Snapshot now = bench.session.snapshot();
  CHECK(now.tick.number == 399);
  CHECK(now.tick.mode == RenderMode::contact);
  CHECK(bench.meanForce(300)[2] == Approx(4.0).epsilon(0.05));
}

TEST_CASE("obstacles come and go while the tool presses one; the rendered force does not jump", "[session]") {
  Bench bench(definition());
  Session& session = bench.session;
  const ObstacleId wall = session.add(wallAt("wall", 0.0));
  bench.run(400);
  const double depth = bench.depth();
  REQUIRE(depth < 50e-6);
  REQUIRE(bench.last[2] > 2.0);

  bench.largestJump = 0.0;
  bench.run(200);
  const double usual = bench.largestJump;
  std::vector<ObstacleId> balls;
  for (int i = 0; i < 20; ++i) {
    balls.push_back(session.add(ball("ball " + std::to_string(i), {0.02 + 0.001 * i, 0.0, 0.0}, 1e-3)));
    bench.run(10);
  }
  for (std::size_t i = 0; i < balls.size(); i += 2) {
    session.remove(balls[i]);
    bench.run(10);
  }
  Material rough;
  rough.friction = rough.slidingFriction = 0.3;
  session.setMaterial(wall, rough);
  bench.run(100);
  CHECK(bench.largestJump < usual + 0.5);
  CHECK(std::abs(bench.depth() - depth) < 10e-6);
  CHECK(bench.session.snapshot().contacts.contacts[0].material.friction == 0.3);

  SECTION("a removed obstacle can no longer be named, also if its slot is used again") {
    const ObstacleId next = session.add(ball("another", {0.05, 0.0, 0.0}, 1e-3));
    CHECK(next.slot == balls[0].slot);
    CHECK_THROWS_WITH(session.move(balls[0], Pose{}), ContainsSubstring("it was removed"));
    CHECK(session.find("ball 0") == ObstacleId{});
    CHECK(session.find("another") == next);
    CHECK_THROWS_WITH(session.add(ball("another", Vec3::Zero(), 1e-3)), ContainsSubstring("occurs twice"));
    session.move(next, Pose{{0.06, 0.0, 0.0}, Mat3::Identity()});
    bench.run(150);
    CHECK(session.haptics().scene().scene().obstacles()[static_cast<std::size_t>(next.slot)].pose.position.x() ==
          Approx(0.06));
  }
  SECTION("without the wall, nothing holds the tool") {
    session.remove(wall);
    bench.run(200);
    CHECK(bench.depth() > 0.5e-3);
    CHECK(bench.session.snapshot().contacts.count == 0);
    const auto ends = eventsOf(session, EventKind::contactEnd);
    REQUIRE(ends.size() == 1);
    CHECK(ends[0].obstacle == wall);
    // In about a second, 4 N without the approach.
    CHECK(ends[0].impulse == Approx(4.0 * 1e-3 * static_cast<double>(ends[0].tick)).epsilon(0.2));
  }
  SECTION("an inactive wall can be touched again") {
    session.activate(wall, false);
    bench.run(3);
    session.activate(wall, true);
    bench.run(300);
    CHECK(bench.depth() < 50e-6);
  }
  SECTION("the wall moves the tool, also if its pose comes at 60 Hz") {
    for (int frame = 1; frame <= 30; ++frame) {
      Pose pose;
      pose.position.z() = 50e-6 * frame;
      session.move(wall, pose);
      bench.run(16);
    }
    bench.run(200);
    CHECK(bench.depth() == Approx(-1.5e-3).margin(50e-6));
    CHECK(bench.session.snapshot().fault == GuardReason::none);
  }
}

TEST_CASE("contacts begin and end once, whatever the encoders' steps do", "[session]") {
  Bench bench(definition());
  const ObstacleId wall = bench.session.add(wallAt("wall", 0.0));
  bench.run(500);
  bench.force = -4.0;
  bench.run(100);
  std::vector<SessionEvent> events;
  for (SessionEvent event; bench.session.nextEvent(event);) events.push_back(event);
  REQUIRE(events.size() == 2);
  CHECK(events[0].kind == EventKind::contactBegin);
  CHECK(events[0].obstacle == wall);
  CHECK(events[0].normal == Vec3::UnitZ());
  CHECK(events[0].speed > 0.0);
  CHECK(events[1].kind == EventKind::contactEnd);
  CHECK(events[1].impulse > 1.5);
}

TEST_CASE("the renderer and the tool change in contact", "[session]") {
  Bench bench(definition());
  Session& session = bench.session;
  (void)session.add(wallAt("wall", 0.0));
  bench.run(400);
  session.setRenderer(kImpedance, {{"stiffness", "2000"}});
  bench.run(1500);
  CHECK(bench.depth() == Approx(4.0 / 2000.0).epsilon(0.1));
  session.setRenderer(kPositionControl);
  bench.run(500);
  CHECK(bench.depth() < 100e-6);
  Tool tool;
  tool.parts[0].radius = 1e-3;
  session.setTool(tool);
  bench.run(500);
  CHECK(bench.depth() == Approx(-1e-3).margin(50e-6));
  CHECK(session.snapshot().fault == GuardReason::none);
  CHECK_THROWS_AS(session.setRenderer("no such renderer"), Error);
  CHECK_THROWS_AS(session.setRenderer(std::unique_ptr<Renderer>()), Error);
}

TEST_CASE("case 23: an effect that the session knows moves the tool little, also if the device reports no torque",
          "[session]") {
  for (const double amplitude : {1.98, 2.0, 2.02}) {
    SessionDef def = definition();
    def.beforeTick = [amplitude](TickAccess& access) {
      Vec6 wrench = Vec6::Zero();
      wrench[2] = amplitude * std::sin(2.0 * M_PI * 150.0 * access.measurement().time);
      access.setEffect(wrench);
    };
    Session session(def);
    (void)session.add(wallAt("wall", 0.0));
    VirtualDevice device(session.mechanism(), Bench::setupOf(session));
    Command command;
    double highest = -1.0;
    for (int i = 0; i < 1000; ++i) {
      Measurement measurement;
      REQUIRE(device.measure(measurement) == Status::ok);
      measurement.applied.reset();
      (void)session.tick(measurement, command);
      REQUIRE(device.actuate(command) == Status::ok);
      REQUIRE(device.advance([&](double time, const Pose& pose, const Vec6& twist) {
        return pushing(time < 0.05 ? 1.0 : 8.0, session.start(), pose, twist);
      }) == Status::ok);
      if (i > 500) highest = std::max(highest, device.state().position.z());
    }
    CAPTURE(amplitude);
    CHECK(highest < 50e-6);
    CHECK(session.snapshot().fault == GuardReason::none);
  }
}

TEST_CASE("with a scale, force at the hand and motion of the device are the same as without", "[session]") {
  // The scene is a tenth as large and turned: the device sees the same wall.
  for (const double scale : {0.1, 3.0}) {
    SessionDef plain = definition(), scaled = definition();
    WorkspaceMap map;
    map.scale = scale;
    map.base.position = {0.3, -0.2, 0.1};
    map.base.rotation = rotationFromEuler({0.3, -0.5, 0.7});
    scaled.map = map;
    const Vec3 normal = map.base.rotation * Vec3::UnitZ();
    scaled.start->position = map.base.position + scale * 0.5e-3 * normal;
    scaled.start->rotation = map.base.rotation;
    Bench one(plain), other(scaled);
    (void)one.session.add(wallAt("wall", 0.0));
    SessionObstacle wall;
    static_cast<Obstacle&>(wall) = halfSpace("wall", map.base.position, normal);
    (void)other.session.add(wall);
    const int soft = GENERATE(0, 1, 2);  // rigid, linear, a layer
    if (soft > 0) {
      Material material;
      material.stiffness = 3000.0;
      if (soft == 2) {
        material.exponent = 2.0;
        material.thickness = 2e-3;
        material.hysteresis = 2.0;
        material.puncture = 30.0;
      }
      one.session.setMaterial(one.session.find("wall"), material);
      material.stiffness /= std::pow(scale, material.exponent);  // the force at the hand per distance in the scene
      material.thickness *= scale;
      material.hysteresis /= scale;
      other.session.setMaterial(other.session.find("wall"), material);
    }
    double furthest = 0.0, strongest = 0.0;
    for (int i = 0; i < 600; ++i) {
      one.run(1);
      other.run(1);
      furthest = std::max(furthest, (one.device.state().position - other.device.state().position).norm());
      strongest = std::max(strongest, std::abs(one.session.snapshot().wrench.head<3>().norm() -
                                               other.session.snapshot().wrench.head<3>().norm()));
    }
    CAPTURE(scale, soft);
    CHECK(one.session.snapshot().contacts.count == 1);
    CHECK(furthest < 1e-6);
    CHECK(strongest < 0.2);
    const Vec3 inScene = map.base.position + scale * (map.base.rotation * other.device.kinematics().pose.position);
    CHECK((other.session.snapshot().tick.pose.position - inScene).norm() < scale * 5e-6);  // the encoders' steps
    CHECK(other.session.snapshot().fault == GuardReason::none);
  }
}

TEST_CASE("the clutch keeps the tool in the scene while the hand moves on", "[session]") {
  SessionDef def = definition();
  def.clutchButton = 1;
  def.start->position.z() = 10e-3;
  Bench bench(def);
  (void)bench.session.add(wallAt("wall", 0.0));
  Vec3 goal = {0.0, 0.0, 10e-3};
  bench.hand = [&](const Pose& pose, const Vec6& twist) {
    Vec6 wrench = guidingWrench(pose, twist, bench.session.start(), Vec3::UnitZ());
    wrench.head<3>() = 200.0 * (goal - pose.position) - 10.0 * twist.head<3>();
    return wrench;
  };
  bench.run(200);
  bench.buttons = 2;
  bench.run(50);  // ramps out
  const Vec3 before = bench.session.snapshot().tick.pose.position;
  goal = {8e-3, 0.0, 20e-3};
  bench.run(600);
  Snapshot now = bench.session.snapshot();
  CHECK(now.clutched);
  CHECK((now.tick.pose.position - before).norm() < 0.1e-3);
  CHECK((bench.device.kinematics().pose.position - goal).norm() < 1e-3);
  bench.buttons = 0;
  goal.z() -= 20e-3;  // 10 mm into the wall
  bench.run(800);
  now = bench.session.snapshot();
  CHECK_FALSE(now.clutched);
  CHECK(std::abs(now.tick.pose.position.z()) < 0.1e-3);
  CHECK(now.tick.pose.position.x() == Approx(before.x()).margin(0.3e-3));
  CHECK(now.fault == GuardReason::none);
  CHECK(bench.meanForce(300)[2] == Approx(200.0 * 10e-3).epsilon(0.1));
}

TEST_CASE("centring leads the hand back to the middle, and only while it moves", "[session]") {
  SessionDef def = definition();
  def.centring = 0.2;
  def.start->position.z() = 10e-3;
  Bench bench(def);
  Vec3 goal = {0.0, 0.0, 10e-3};
  const auto follow = [&](const Vec3& tool) {  // the person looks at the tool and moves it to a place in the scene
    return Vec3(200.0 * (goal - tool));
  };
  bench.hand = [&](const Pose& pose, const Vec6& twist) {
    Vec6 wrench = guidingWrench(pose, twist, bench.session.start(), Vec3::UnitZ());
    wrench.head<3>() = follow(pose.position + bench.session.snapshot().base) - 10.0 * twist.head<3>();
    return wrench;
  };
  bench.run(300);
  const double first = bench.device.kinematics().pose.position.norm();
  for (int turn = 0; turn < 20; ++turn) {
    goal.x() = turn % 2 == 0 ? 5e-3 : -5e-3;
    bench.run(200);
  }
  goal.x() = 0.0;
  bench.run(300);
  CHECK(bench.session.snapshot().tick.pose.position.z() == Approx(10e-3).margin(0.5e-3));
  CHECK(bench.device.kinematics().pose.position.norm() < 0.7 * first);
  const Vec3 base = bench.session.snapshot().base;
  bench.run(1000);
  CHECK((bench.session.snapshot().base - base).norm() < 10e-6);
}

TEST_CASE("two sessions share a solid: each cuts its own copy, and both copies become the same", "[session]") {
  test::TwoBurs burs({1e-3, 0.0, 5e-3});
  const std::shared_ptr<Session>& first = burs.first;
  Session& other = *burs.second;
  const ObstacleId id = burs.id;
  CHECK(other.find("tooth") == id);
  first->spin(true);
  other.spin(true);
  for (int i = 0; i < 600; ++i) {
    test::tickOnce(*first, *burs.a, i < 500 ? 2.0 : -2.0);
    test::tickOnce(other, *burs.b, i < 500 ? 2.0 : -2.0);
  }
  const std::shared_ptr<const Solid> mine = test::cutSolidOf(*first), theirs = test::cutSolidOf(other);
  REQUIRE(mine != theirs);
  const double uncut = cube()->volume()[0];
  CHECK(mine->volume()[0] < 0.999 * uncut);
  CHECK(first->snapshot().removed[0] > 0.0);
  CHECK(other.snapshot().removed[0] > 0.0);
  bool same = true;
  for (int brick = 0; brick < mine->bricks(); ++brick) same = same && mine->samples(brick) == theirs->samples(brick);
  CHECK(same);
  CHECK(first->snapshot().lostCuts == 0);
  CHECK_FALSE(eventsOf(*first, EventKind::cut).empty());
  BrickChange change;
  CHECK(first->takeChange(id, change));
  CHECK_THROWS_WITH(first->moveVertices(id, {0}, {Vec3::Zero()}), ContainsSubstring("can be edited"));

  CHECK_THROWS_WITH(Session(burs.definitionOfSecond), ContainsSubstring("have not run yet"));
}

TEST_CASE("two sessions push one tooth, and each tool feels the other", "[session]") {
  constexpr double kStiffness = 5e4, kForce = 4.0;  // N/m, N
  SessionObstacle tooth;
  tooth.name = "tooth";
  tooth.shape = Box{{0.02, 0.02, 0.01}};
  tooth.pose.position = {0.0, 0.0, -0.01};
  Suspension suspension;
  suspension.inertia[2] = 2e-3;
  suspension.stiffness[2] = kStiffness;
  SessionDef def = definition();
  const auto first = std::make_shared<Session>(def);
  const ObstacleId id = first->add(tooth);
  first->setSuspension(id, suspension);
  def.sharesWith = first;
  def.start->position.x() = 5e-3;
  Session second(def);
  VirtualDevice a(first->mechanism(), Bench::setupOf(*first)), b(second.mechanism(), Bench::setupOf(second));
  const auto sunk = [&](const Session& session) { return -session.haptics().scene().motion().suspended(0)->offset[2]; };
  const auto run = [&](int ticks, double forceOfFirst) {
    double mean[2] = {};
    for (int i = 0; i < ticks; ++i) {
      test::tickOnce(*first, a, i < 100 ? forceOfFirst : std::max(0.0, forceOfFirst));
      test::tickOnce(second, b, kForce);
      if (i < ticks / 2) continue;
      mean[0] += 2.0 * sunk(*first) / ticks;
      mean[1] += 2.0 * sunk(second) / ticks;
    }
    return std::pair<double, double>(mean[0], mean[1]);
  };
  const auto both = run(1000, kForce);
  CHECK(both.first == Approx(2.0 * kForce / kStiffness).epsilon(0.02));
  CHECK(both.second == Approx(2.0 * kForce / kStiffness).epsilon(0.02));
  CHECK(-b.state().position.z() == Approx(both.second).margin(1e-5));  // its tool lies on the tooth
  const auto one = run(1000, -0.2);                                    // the first tool leaves
  CHECK(a.state().position.z() > 1e-4);
  CHECK(one.first == Approx(kForce / kStiffness).epsilon(0.02));
  CHECK(one.second == Approx(kForce / kStiffness).epsilon(0.02));
  first->setSuspension(id, std::nullopt);
  (void)run(100, -0.2);
  CHECK(first->haptics().scene().motion().suspended(0) == nullptr);
  CHECK(second.haptics().scene().scene().obstacles()[0].pose.position == tooth.pose.position);
  suspension.stiffness[2] = -1.0;
  CHECK_THROWS_WITH(first->setSuspension(id, suspension), ContainsSubstring("suspension must be at least 0"));
}

TEST_CASE("a session sets the tap of an obstacle", "[session]") {
  Session session(definition());
  VirtualDevice device(session.mechanism(), Bench::setupOf(session));
  SessionObstacle block;
  block.name = "block";
  block.shape = Box{{0.02, 0.02, 0.01}};
  block.pose.position = {0.0, 0.0, -0.01};
  const ObstacleId id = session.add(block);
  const auto hasTaps = [&] {
    test::tickOnce(session, device, 0.0);
    test::tickOnce(session, device, 0.0);
    return session.haptics().scene().hasTaps();
  };
  CHECK_FALSE(hasTaps());
  session.setTap(id, tapOf("metal"));
  CHECK(hasTaps());
  session.setTap(id, {});
  CHECK_FALSE(hasTaps());
  CHECK_THROWS_WITH(session.setTap(id, {5.0, 90.0}), ContainsSubstring("a frequency of 10 to 1000 Hz"));
}

TEST_CASE("a session sets guides, which ramp in and replace the ones before", "[session]") {
  Session session(definition());
  VirtualDevice device(session.mechanism(), Bench::setupOf(session));
  const auto forceAfter = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) test::tickOnce(session, device, 0.0);
    return session.snapshot().wrench.z();
  };
  const double height = session.start().position.z();
  const auto plane = [&](double force) {
    return Guide{Plane{}, {{0.0, 0.0, height + 0.1}, Mat3::Identity()}, 500.0, force};
  };
  CHECK(std::abs(forceAfter(2)) < 1e-9);
  session.setGuides({plane(1.0)});
  CHECK(std::abs(forceAfter(2)) < 0.1);
  const double pulls = forceAfter(120);
  CHECK(pulls == Approx(1.0).margin(0.1));  // the hand moves the tool
  SessionObstacle ball;
  ball.name = "ball";
  ball.shape = Sphere{1e-3};
  ball.pose.position = {0.0, 0.0, -0.2};
  (void)session.add(ball);  // does not begin the ramp again
  CHECK(forceAfter(2) == Approx(pulls).margin(0.1));
  session.setGuides({plane(0.5)});
  CHECK(std::abs(forceAfter(2)) < 0.1);
  session.setGuides({});
  CHECK(std::abs(forceAfter(2)) < 1e-9);
  CHECK_THROWS_WITH(session.setGuides({plane(-1.0)}), ContainsSubstring("guide 0: the largest force is -1"));

  SessionDef stiff = definition();
  stiff.scene = std::string(ENAMEL_SOURCE_DIR) + "/data/scenes/guides.toml";
  stiff.device = std::string(ENAMEL_SOURCE_DIR) + "/data/devices/touch-x.toml";
  const Session light(stiff);
  REQUIRE(light.notes().size() == 1);
  CHECK(light.notes()[0] ==
        "guides: their stiffnesses add up to 400 N/m and are reduced by one factor: the device permits 350 N/m");
}

TEST_CASE("a bur that comes after spin() spins", "[session]") {
  test::TwoBurs burs({0.0, 0.0, 20e-3});
  Session& session = *burs.first;
  session.setTool(Tool{});
  session.spin(true);
  session.setTool(*burs.definitionOfSecond.tool, burs.definitionOfSecond.bur);
  for (int i = 0; i < 400; ++i) test::tickOnce(session, *burs.a, 2.0);
  CHECK(session.snapshot().removed[0] > 0.0);
}

TEST_CASE("vertices move on the loop's thread", "[session]") {
  Bench bench(definition());
  SessionObstacle plate;
  plate.name = "plate";
  plate.mesh = std::make_shared<MeshModel>(test::boxMesh(Vec3(5e-3, 5e-3, 2e-3)));
  plate.pose.position.z() = -2e-3;
  const ObstacleId id = bench.session.add(plate);
  bench.run(500);
  CHECK(std::abs(bench.depth()) < 50e-6);
  std::vector<int> vertices;
  std::vector<Vec3> positions;
  for (std::size_t i = 0; i < plate.mesh->mesh().vertices.size(); ++i)
    if (plate.mesh->mesh().vertices[i].z() > 0.0) {
      vertices.push_back(static_cast<int>(i));
      positions.push_back(plate.mesh->mesh().vertices[i] - Vec3(0.0, 0.0, 1e-3));
    }
  bench.session.moveVertices(id, vertices, positions);
  bench.run(500);
  CHECK(bench.depth() == Approx(1e-3).margin(50e-6));
  CHECK_THROWS_WITH(bench.session.moveVertices(id, {100000}, {Vec3::Zero()}), ContainsSubstring("must be in 0 to"));
}

TEST_CASE("a definition out of range is refused with its reason", "[session]") {
  const auto refusal = [](const auto& change) -> std::string {
    SessionDef def;
    change(def);
    try {
      Session session(def);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  CHECK_THAT(refusal([](SessionDef& d) { d.rate = 0.0; }), ContainsSubstring("the rate is 0, must be in 10 to"));
  CHECK_THAT(refusal([](SessionDef& d) { d.centring = 0.9; }), ContainsSubstring("centring is 0.9"));
  CHECK_THAT(refusal([](SessionDef& d) { d.device = "no such file"; }), ContainsSubstring("no such file"));
  CHECK_THAT(refusal([](SessionDef& d) { d.scene = "no such file"; }), ContainsSubstring("no such file"));
  CHECK_THAT(refusal([](SessionDef& d) { d.renderer = "no-such"; }), ContainsSubstring("no-such"));
  CHECK_THAT(refusal([](SessionDef& d) {
               d.map = WorkspaceMap{Pose{}, 1000.0};
             }),
             ContainsSubstring("the scale is 1000"));
  CHECK_THAT(refusal([](SessionDef& d) { d.bur = Bur{3, 0.05, 2000.0}; }), ContainsSubstring("the bur is part 3"));
}

TEST_CASE("an obstacle that is probably in another unit gives an event", "[session]") {
  const test::TemporaryFolder folder;
  SessionDef def = definition();
  def.scene = folder / "micrometres.toml";
  test::writeFile(def.scene,
                  "name = \"micrometres\"\nstart = [0, 0, 0]\n[[obstacle]]\nname = \"molar\"\nshape = \"mesh\"\n"
                  "file = \"" ENAMEL_SOURCE_DIR "/data/meshes/molar.ply\"\nunit = \"um\"\nposition = [0, 0, -0.1]\n");
  const double scale = GENERATE(1.0, 5.0);
  if (scale != 1.0) def.map = WorkspaceMap{Pose{}, scale};
  Session session(def);
  std::vector<SessionEvent> events = eventsOf(session, EventKind::unusualSize);
  REQUIRE(events.size() == 1);
  CHECK(events[0].obstacle == session.find("molar"));
  CHECK(events[0].extent == Approx(11e-6).epsilon(0.1));

  SessionObstacle box = ball("box", {0.0, 0.0, -10.0}, 1e-3);
  box.mesh = std::make_shared<MeshModel>(test::boxMesh({1.5, 0.1, 0.1}));
  const ObstacleId id = session.add(box);
  SessionObstacle tooth = ball("tooth", {0.1, 0.0, 0.0}, 1e-3);
  tooth.solid = cube();
  (void)session.add(tooth);
  (void)session.add(wallAt("wall", -1.0));
  events = eventsOf(session, EventKind::unusualSize);
  REQUIRE(events.size() == (scale == 1.0 ? 1 : 0));
  if (!events.empty()) CHECK(events[0].obstacle == id);

  box.mesh = std::make_shared<MeshModel>(test::boxMesh({0.1, 0.1, 6.0}));
  session.replace(id, box);
  events = eventsOf(session, EventKind::unusualSize);
  REQUIRE(events.size() == 1);
  CHECK(events[0].extent == Approx(12.0));
  CHECK(std::string(toString(events[0].kind)) == "unusual size of an obstacle: is its unit right?");
}

TEST_CASE("a host sees refused commands, and a loop that hangs", "[session][threads]") {
  class Refusing final : public HapticDevice {
   public:
    explicit Refusing(const Session& session) : device_(makeVirtualDevice(session)) {}
    Status measure(Measurement& measurement) noexcept override { return device_->measure(measurement); }
    Status actuate(const Command&) noexcept override { return Status::inactive; }

   private:
    std::unique_ptr<SimulatedDevice> device_;
  };
  std::atomic<bool> hangs{false};
  SessionDef def = definition();
  def.lockMemory = false;
  def.beforeTick = [&hangs](TickAccess&) {
    while (hangs) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  Session session(def);
  CHECK(session.snapshot().sinceTick == 0.0);
  session.start(std::make_unique<Refusing>(session));
  REQUIRE(eventually([&] { return session.snapshot().unsent > 3; }));
  hangs = true;
  constexpr double kLong = 0.05;  // s
  REQUIRE(eventually([&] { return session.snapshot().sinceTick > kLong; }));
  const std::uint64_t last = session.snapshot().tick.number;
  hangs = false;
  REQUIRE(eventually([&] {
    const Snapshot now = session.snapshot();
    return now.tick.number > last && now.sinceTick < kLong;
  }));
  session.stop();
  CHECK(session.snapshot().sinceTick == 0.0);
}

TEST_CASE("a loop in its own thread, changed by two others at random", "[session][threads]") {
  SessionDef def = definition();
  Session session(def);
  (void)session.add(wallAt("wall", 0.0));
  CHECK_THROWS_WITH(session.start(std::unique_ptr<HapticDevice>()), ContainsSubstring("the device is null"));
  test::PressingHand hand(session.start());
  session.start(makeVirtualDevice(session, hand.wrench()));
  CHECK(session.isRunning());
  CHECK_THROWS_WITH(session.start(makeVirtualDevice(session)), ContainsSubstring("already running"));
  const std::chrono::duration<double> length(test::longRun() ? 600.0 : 0.2);
  test::RandomChanges one(session, 1, length), two(session, 2, length);
  test::Watched watched;
  test::watch(session, hand, length, watched);
  const auto [changes, failures] = one.finish();
  const auto [others, failed] = two.finish();
  CHECK(failures == 0);
  CHECK(failed == 0);
  CHECK(watched.otherReasons == "");
  if (test::longRun())
    std::cout << "changes of two threads: " << changes << ", " << others << "; the guard stopped " << watched.lateStops
              << " times; pressed in " << watched.pressed << " of " << watched.snapshots << " snapshots\n";
  const Snapshot now = session.snapshot();
  session.stop();
  CHECK_FALSE(session.isRunning());
  CHECK(now.tick.number > 0);
}

}  // namespace enamel::test_session
