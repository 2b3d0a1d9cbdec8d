// The code of lib/docs/session.md, compiled and run. unit.pages compares its lines with the page.
#include <atomic>

#include "enamel/core/error.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/eventually.hpp"
#include "support/session_bench.hpp"

namespace enamel::test_session_page {

using test::eventually;

namespace {

// A tetrahedron of 10 mm; the page's own mesh.
struct Own {
  std::vector<Vec3> vertices{{-5e-3, -5e-3, 0.0}, {5e-3, -5e-3, 0.0}, {0.0, 5e-3, 0.0}, {0.0, 0.0, -8e-3}};
  std::vector<std::array<int, 3>> triangles{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
};

}  // namespace

TEST_CASE("obstacles come, move and go while the loop runs", "[session_page]") {
  const Own own;
  SessionDef def;
  def.start.emplace();
  def.start->position.z() = 1e-3;
  Session session(def);
  session.start(makeVirtualDevice(session));

  TriangleMesh mesh;
  mesh.vertices = own.vertices;    // m
  mesh.triangles = own.triangles;  // counter-clockwise, seen from outside
  SessionObstacle tooth;
  tooth.name = "tooth";
  tooth.mesh = std::make_shared<MeshModel>(mesh);  // the slow part, on this thread
  tooth.pose.position = {0.0, 0.0, -0.0005};
  tooth.material.friction = tooth.material.slidingFriction = 0.2;
  const ObstacleId id = session.add(tooth);

  // The graphics thread.
  int begun = 0, lines = 0;
  const auto drawLine = [&](const Vec3&, const Vec3&) { ++lines; };
  const auto play = [&](const Vec3&, double) { ++begun; };
  CHECK(eventually([&] {
    const Snapshot now = session.snapshot();
    for (int i = 0; i < now.contacts.count; ++i) {
      const Contact& contact = now.contacts.contacts[static_cast<std::size_t>(i)];
      drawLine(contact.point, contact.point + 1e-3 * contact.normal);
    }
    for (SessionEvent event; session.nextEvent(event);)
      if (event.kind == EventKind::contactBegin) play(event.point, event.speed);
    if (now.fault != GuardReason::none) session.reset();  // the machine is busy
    return begun > 0 && lines > 0;
  }));

  // Once per picture.
  Pose pose;
  pose.position = {0.0, 0.0, -0.001};
  session.move(id, pose);  // the obstacle glides there
  Material soft;
  soft.stiffness = 2000.0;  // N/m at the hand
  session.setMaterial(id, soft);
  session.activate(id, false);  // it can no longer be touched
  session.activate(id, true);   // it appears at its stated pose
  session.remove(id);
  CHECK(session.find("tooth") == ObstacleId{});
  CHECK(eventually([&] { return session.snapshot().contacts.count == 0; }));

  Tool probe;
  probe.parts[0].radius = 0.5e-3;
  session.setTool(probe);
  session.setRenderer(kImpedance, {{"stiffness", "2000"}});
  CHECK_NOTHROW(session.stop());
}

TEST_CASE("a hook reads buttons and adds an effect", "[session_page]") {
  SessionDef def;
  std::atomic<double> amplitude{0.2};  // N, set by any thread
  def.beforeTick = [&amplitude](TickAccess& access) {
    const Measurement& m = access.measurement();
    access.spin((m.buttons & 1U) != 0);  // the first button spins the bur
    access.setEffect(amplitude * std::sin(2.0 * M_PI * 150.0 * m.time) * Vec6::Unit(2));
  };
  test::Bench bench(def);
  bench.buttons = 1;
  bench.run(50);
  CHECK(bench.session.snapshot().spins);
  CHECK(bench.largestJump > 0.05);
}

TEST_CASE("a workspace map with a clutch", "[session_page]") {
  SessionDef def;
  def.map.emplace();
  def.map->base.position = {0.0, 0.0, 0.05};  // of the device's origin, in the scene, m
  def.map->scale = 0.2;                       // the tool moves 2 mm when the hand moves 10 mm
  def.clutchButton = 1;                       // while it is pressed, the tool stays and the hand moves on
  def.centring = 0.1;
  test::Bench bench(def);
  bench.run(10);
  CHECK(bench.session.snapshot().base.z() == Approx(0.05).margin(1e-3));
}

TEST_CASE("a recording", "[session_page]") {
  const test::TemporaryFolder folder;
  SessionDef def;
  def.scene = ENAMEL_SOURCE_DIR "/data/scenes/flat-wall.toml";
  test::Bench bench(def);
  Session& session = bench.session;
  const std::string path = folder / "run.rec";

  session.record(path);
  bench.run(100);
  const RecordingResult result = session.stopRecording();  // ticks, lost ticks, and why the file is not complete
  CHECK(result.ticks == 100);
}

TEST_CASE("two tools drill a tooth", "[session_page]") {
  SessionDef def;
  def.start.emplace();
  def.start->position.z() = 5e-3;
  const MeshModel surface(test::boxMesh(Vec3::Constant(4e-3)));

  Material rough;
  rough.friction = rough.slidingFriction = 0.2;
  const SolidLayer layer{"dentine", rough, 0.6e9, 0.0, nullptr};  // the hardness in Pa
  SessionObstacle tooth;
  tooth.name = "tooth";
  tooth.solid = std::make_shared<const Solid>(surface, std::vector<SolidLayer>{layer}, SolidOptions{2e-4, 0});
  def.tool.emplace();
  def.tool->parts[0].radius = 1e-3;
  def.bur = Bur{0, 0.5, 2000.0};  // part, wear, turns per second

  const auto drill = std::make_shared<Session>(def);
  const ObstacleId id = drill->add(tooth);
  SessionDef mirror;
  mirror.sharesWith = drill;  // before either of them runs
  mirror.start = Pose{{0.02, 0.0, 0.02}, Mat3::Identity()};
  Session second(mirror);
  drill->start(makeVirtualDevice(*drill));
  second.start(makeVirtualDevice(second));

  drill->spin(true);
  int bricks = 0, cuts = 0;
  double volume = 0.0;
  Solid cut = *drill->solid(id);
  const auto upload = [&](int brick, const BrickSamples& samples) {
    ++bricks;
    cut.set(brick, samples);
  };
  CHECK(eventually([&] {
    BrickChange change;
    while (drill->takeChange(id, change)) upload(change.brick, change.samples);
    for (SessionEvent event; drill->nextEvent(event);)
      if (event.kind == EventKind::cut) ++cuts, volume += event.removed[0];
    if (drill->snapshot().fault != GuardReason::none) drill->reset();  // the machine is busy
    return bricks > 0 && volume > 0.0;
  }));
  CHECK(cut.volume()[0] < drill->solid(id)->volume()[0]);
  drill->replace(id, tooth);  // whole again
  CHECK(cuts > 0);
  CHECK(eventually([&] {
    BrickChange change;
    return !second.takeChange(id, change);
  }));
  second.stop();
  drill->stop();
}

}  // namespace enamel::test_session_page
