// A session's recording replays bit for bit. A recording that would not replay is refused. Solids that two sessions share.
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/runtime/replay.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/session_bench.hpp"

namespace enamel::test_session_recording {

using test::ball;
using test::Bench;
using test::ContainsSubstring;
using test::cube;
using test::definition;
using test::eventsOf;
using test::pushing;
using test::wallAt;

namespace {

// Run the recorded ticks again.
ReplayResult replayed(const std::string& path) {
  RecordingReader reader(path);
  const RecordingHeader& header = reader.header();
  const auto mechanism = makeMechanism(parseDevice(header.deviceText, header.deviceFile));
  SceneFile file;
  file.scene = flatWall();
  if (!header.sceneText.empty()) file = parseScene(header.sceneText, header.sceneFile);
  const auto renderer = makeLinked(header.renderer, header.parameters, mechanism, header.guard.period);
  HapticTick tick(*mechanism, file.scene, file.tool, *renderer, header.guard, header.start);
  return replay(reader, tick);
}

SessionDef atTheWall() {
  SessionDef def = definition();
  def.scene = ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml";
  return def;
}

}  // namespace

TEST_CASE("a session records, and the recording replays bit for bit", "[session_recording]") {
  const test::TemporaryFolder folder;
  const bool hasFile = GENERATE(true, false);
  CAPTURE(hasFile);
  Bench bench(hasFile ? atTheWall() : definition());
  Session& session = bench.session;
  if (!hasFile) (void)session.add(wallAt("wall", 0.0));
  bench.run(50);
  session.record(folder / "run.enr");
  CHECK_THROWS_WITH(session.record(folder / "other.enr"), ContainsSubstring("under way"));
  bench.run(200);
  session.reset();  // is part of the recording
  bench.run(100);
  const RecordingResult result = session.stopRecording();
  CHECK(result.ticks == 300);
  CHECK(result.problem.empty());
  const ReplayResult again = replayed(folder / "run.enr");
  CHECK(again.ticks + again.restored == 300);
  CHECK(again.different == 0);
  CHECK(again.states);
  if (hasFile)
    CHECK(std::filesystem::path(RecordingReader(folder / "run.enr").header().sceneFile).is_absolute());
  else
    CHECK(RecordingReader(folder / "run.enr").header().sceneText.empty());
}

TEST_CASE("a change that no replay repeats ends a recording, and another one is refused", "[session_recording]") {
  const test::TemporaryFolder folder;
  Bench bench(atTheWall());
  Session& session = bench.session;
  const ObstacleId wall = session.find("wall");
  REQUIRE(wall.slot == 0);
  bench.run(50);
  session.record(folder / "run.enr");
  bench.run(300);
  SECTION("an obstacle is added") { (void)session.add(ball("ball", {0.02, 0.0, 0.0}, 1e-3)); }
  SECTION("an obstacle moves") { session.move(wall, Pose{{0.0, 0.0, 1e-5}, Mat3::Identity()}); }
  SECTION("an obstacle is no longer active") { session.activate(wall, false); }
  SECTION("the tool changes") { session.setTool(Tool{}); }
  SECTION("an effect") { session.setEffect(Vec6::Unit(0)); }
  bench.run(10);
  const auto ends = eventsOf(session, EventKind::recordingEnd);
  REQUIRE(ends.size() == 1);
  CHECK(ends[0].tick == 349);
  CHECK(ends[0].time > 0.3);
  CHECK(session.stopRecording().ticks == 300);
  CHECK(replayed(folder / "run.enr").different == 0);
  CHECK_THROWS_WITH(session.record(folder / "other.enr"), ContainsSubstring("could not be replayed"));
}

TEST_CASE("a new renderer ends a recording, and another one can be recorded", "[session_recording]") {
  const test::TemporaryFolder folder;
  Bench bench(atTheWall());
  bench.run(50);
  bench.session.record(folder / "run.enr");
  bench.run(100);
  bench.session.setRenderer(kImpedance, {{"stiffness", "2000"}});
  bench.run(10);
  CHECK(eventsOf(bench.session, EventKind::recordingEnd).size() == 1);
  CHECK(bench.session.stopRecording().ticks == 100);
  bench.session.record(folder / "other.enr");
  bench.run(300);
  CHECK(bench.session.stopRecording().ticks == 300);
  CHECK(replayed(folder / "other.enr").different == 0);
}

TEST_CASE("a hook that moves an obstacle, and a scene without a file, are not recorded", "[session_recording]") {
  const test::TemporaryFolder folder;
  SessionDef def = atTheWall();
  bool moves = false;
  def.beforeTick = [&moves](TickAccess& access) {
    if (moves) (void)access.move(ObstacleId{0, 1}, Pose{});
  };
  Bench bench(def);
  bench.run(10);
  bench.session.record(folder / "run.enr");
  bench.run(10);
  moves = true;
  bench.run(10);
  CHECK(eventsOf(bench.session, EventKind::recordingEnd).size() == 1);
  CHECK(bench.session.stopRecording().ticks == 10);

  Bench lower(definition());
  (void)lower.session.add(wallAt("wall", -1e-3));
  CHECK_THROWS_WITH(lower.session.record(folder / "other.enr"), ContainsSubstring("no scene file"));
}

TEST_CASE("a cut that another session has not yet taken is not made in a restored solid", "[session_recording]") {
  SessionDef def = definition();
  def.start->position.z() = 5e-3;
  Tool bur;
  bur.parts[0].radius = 1e-3;
  def.tool = bur;
  def.bur = Bur{0, 0.5, 2000.0};
  const auto cutting = std::make_shared<Session>(def);
  SessionObstacle tooth;
  tooth.name = "tooth";
  tooth.solid = cube();
  const ObstacleId id = cutting->add(tooth);
  SessionDef second = def;
  second.sharesWith = cutting;
  second.start->position.z() = 20e-3;
  Session watching(second);
  VirtualDevice device(cutting->mechanism(), Bench::setupOf(*cutting)),
      other(watching.mechanism(), Bench::setupOf(watching));
  const auto tick = [](Session& session, VirtualDevice& at, double force) {
    Measurement measurement;
    Command command;
    REQUIRE(at.measure(measurement) == Status::ok);
    (void)session.tick(measurement, command);
    REQUIRE(at.actuate(command) == Status::ok);
    REQUIRE(at.advance([&, start = session.start()](double, const Pose& pose, const Vec6& twist) {
      return pushing(force, start, pose, twist);
    }) == Status::ok);
  };
  const auto solidOf = [](const Session& session) {
    return std::get<std::shared_ptr<const Solid>>(session.haptics().scene().scene().obstacles()[0].shape);
  };
  const auto areEqual = [](const Solid& a, const Solid& b) {
    for (int brick = 0; brick < a.bricks(); ++brick)
      if (a.samples(brick) != b.samples(brick)) return false;
    return true;
  };
  cutting->spin(true);
  for (int i = 0; i < 400; ++i) {
    tick(*cutting, device, 2.0);
    if (i < 399) tick(watching, other, 0.0);
  }
  REQUIRE(cutting->snapshot().removed[0] > 0.0);
  cutting->spin(false);
  SECTION("restored") {
    cutting->restore(id);
    for (int i = 0; i < 5; ++i) tick(watching, other, 0.0);
    CHECK(areEqual(*solidOf(*cutting), *tooth.solid));
    BrickChange change;
    CHECK_FALSE(cutting->takeChange(id, change));  // the drawing begins with the whole solid again
    CHECK(areEqual(*solidOf(watching), *tooth.solid));
  }
  SECTION("replaced") {
    SessionObstacle fresh = tooth;
    fresh.solid = cube();
    cutting->replace(id, fresh);
    for (int i = 0; i < 5; ++i) tick(watching, other, 0.0);
    CHECK(areEqual(*solidOf(watching), *fresh.solid));
  }
  SECTION("neither: it is made") {
    CHECK_FALSE(areEqual(*solidOf(watching), *solidOf(*cutting)));
    for (int i = 0; i < 5; ++i) tick(watching, other, 0.0);
    CHECK(areEqual(*solidOf(watching), *solidOf(*cutting)));
  }
}

TEST_CASE("the guard's limits for the device are right under a map", "[session_recording]") {
  SessionDef def = definition();
  const auto nominal = Session(def).haptics().guard().options();
  WorkspaceMap map;
  map.scale = 4.0;
  map.base.rotation = rotationFromEuler({0.3, -0.5, 0.7});
  def.map = map;
  def.start.reset();
  const GuardOptions ours = Session(def).haptics().guard().options();
  def.guard = nominal;
  const GuardOptions own = Session(def).haptics().guard().options();
  for (const auto number : {&GuardOptions::speed, &GuardOptions::stopSpeed, &GuardOptions::turn,
                            &GuardOptions::stopTurn, &GuardOptions::softest, &GuardOptions::brakeTurn})
    CHECK(own.*number == Approx(ours.*number).epsilon(1e-9));
  CHECK((own.damping - ours.damping).norm() < 1e-9 * (1.0 + ours.damping.norm()));
  CHECK(own.brake == Approx(ours.brake).epsilon(1e-9));
  def.guard->force = 8.0;
  CHECK(Session(def).haptics().guard().options().force == Approx(2.0));
  def.guard->workspace.setConstant(0.1);
  CHECK_THROWS_WITH(Session(def), ContainsSubstring("a box for the guard"));
}

TEST_CASE("the largest force of a scene file holds for all sessions of the scene", "[session_recording]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "soft.toml",
                  "name = \"soft\"\nstart = [0.0, 0.0, 0.001]\nmax_force = 2.5\n[[obstacle]]\nname = \"wall\"\n"
                  "shape = \"half_space\"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n");
  SessionDef def;
  def.scene = folder / "soft.toml";
  SessionDef second;
  second.sharesWith = std::make_shared<Session>(def);
  CHECK(second.sharesWith->haptics().guard().options().force == 2.5);
  CHECK(Session(second).haptics().guard().options().force == 2.5);
  second.maxForce = 1.0;
  CHECK(Session(second).haptics().guard().options().force == 1.0);
}

TEST_CASE("a snapshot under a scale has the stated material", "[session_recording]") {
  SessionDef def = definition();
  def.map = WorkspaceMap{Pose{}, 0.1};
  def.start->position.z() = 0.05e-3;
  Bench bench(def);
  SessionObstacle wall = wallAt("wall", 0.0);
  wall.material.stiffness = 30000.0;
  wall.material.viscosity = 2.0;
  (void)bench.session.add(wall);
  bench.run(300);
  const Snapshot now = bench.session.snapshot();
  REQUIRE(now.contacts.count == 1);
  CHECK(now.contacts.contacts[0].material.stiffness == Approx(30000.0).epsilon(1e-12));
  CHECK(now.contacts.contacts[0].material.viscosity == Approx(2.0).epsilon(1e-12));
}

}  // namespace enamel::test_session_recording
