// A tick of a session never allocates and never frees, whatever other threads have changed before it.
#include "enamel/session/session.hpp"

#include <thread>

#include "enamel/plugin/renderer_source.hpp"
#include "support/allocation_counter.hpp"
#include "support/command.hpp"
#include "support/session_bench.hpp"

namespace enamel::test_session {

namespace {

// Run a function on a thread that is not the loop's: it posts its changes. The thread ends before the ticks.
template <typename Function>
void onAnotherThread(const Function& function) {
  std::thread(function).join();
}

}  // namespace

TEST_CASE("ticks of a session allocate nothing while another thread changes everything", "[realtime]") {
  SessionDef def = test::definition();
  def.clutchButton = 1;
  def.centring = 0.1;
  Tool bur;
  bur.parts[0].radius = 1e-3;
  def.tool = bur;
  def.bur = Bur{0, 0.5, 2000.0};
  def.start->position.z() = 5e-3;
  ObstacleId pushed;
  def.beforeTick = [&pushed](TickAccess& access) {
    (void)access.move(pushed, Pose{{0.03, 1e-4 * access.measurement().time, 0.0}, Mat3::Identity()});
    access.setEffect(1e-3 * Vec6::Unit(0));
    (void)access.activate(pushed, access.measurement().time > 0.3);
  };
  const auto shared = std::make_shared<Session>(def);
  Session& session = *shared;
  SessionObstacle tooth;
  tooth.name = "tooth";
  tooth.solid = test::cube();
  const ObstacleId cut = session.add(tooth);
  SessionObstacle plate;
  plate.name = "plate";
  plate.mesh = std::make_shared<MeshModel>(test::boxMesh(Vec3::Constant(2e-3)));
  plate.pose.position.x() = 0.02;
  const ObstacleId edited = session.add(plate);
  pushed = session.add(test::ball("pushed", {0.03, 0.0, 0.0}, 1e-3));
  const ObstacleId other = session.add(test::ball("other", {0.0, 0.03, 0.0}, 1e-3));

  VirtualDevice device(session.mechanism(), test::Bench::setupOf(session));
  long allocated = 0;
  std::uint32_t buttons = 0;
  double goal = 0.0;  // of the hand, m
  int inContact = 0;
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      Measurement measurement;
      Command command;
      REQUIRE(device.measure(measurement) == Status::ok);
      measurement.buttons = buttons;
      const long before = test::allocationCount();
      (void)session.tick(measurement, command);
      allocated += test::allocationCount() - before;
      inContact += session.snapshot().tick.mode == RenderMode::contact;
      REQUIRE(device.actuate(command) == Status::ok);
      REQUIRE(device.advance([&, start = session.start()](double, const Pose& pose, const Vec6& twist) {
        Vec6 wrench = guidingWrench(pose, twist, start, Vec3::UnitZ());
        wrench[2] += 400.0 * (goal - pose.position.z()) - 10.0 * twist[2];
        return wrench;
      }) == Status::ok);
    }
  };
  session.spin(true);
  run(300);
  const double removed = session.snapshot().removed[0];
  CHECK(removed > 0.0);

  int changes = 0;
  ObstacleId added;
  const auto change = [&](const auto& function) {
    onAnotherThread(function);
    run(3);
    ++changes;
  };
  for (int round = 0; round < 10; ++round) {
    change([&] { added = session.add(test::ball("ball", {0.0, 0.02, 0.0}, 1e-3)); });
    change([&] { session.move(added, Pose{{0.0, 0.021, 0.0}, Mat3::Identity()}); });
    change([&] { session.activate(added, false); });
    change([&] {
      Material soft;
      soft.stiffness = 2000.0;
      session.setMaterial(other, soft);
    });
    change([&] { session.replace(other, test::ball("", Vec3::Zero(), 2e-3)); });
    change([&] { session.remove(added); });
    change([&] { session.moveVertices(edited, {0}, {Vec3(2e-3, 2e-3, 2e-3) + 1e-5 * round * Vec3::UnitZ()}); });
    change([&] { session.setRenderer(round % 2 == 0 ? kImpedance : kPositionControl); });
    change([&] { session.setTool(bur, def.bur); });
    change([&] { session.setEffect(1e-2 * Vec6::Unit(1)); });
    change([&] { session.restore(cut); });
    change([&] { session.mark(cut); });
    change([&] { session.undo(cut); });
    change([&] { session.spin(round % 2 == 0); });
    change([&] { session.enable(round % 2 == 0); });
    change([&] { session.reset(); });
    change([&] { session.clutch(round % 2 == 0); });
    buttons = round % 2 == 0 ? 2 : 0;
    run(20);
  }
  session.enable(true);
  session.spin(true);
  session.restore(cut);
  run(600);
  CHECK(session.snapshot().removed[0] > removed);
  goal = 20e-3;
  run(200);
  CHECK(allocated == 0);
  CHECK(changes == 170);
  CHECK(inContact > 300);

  int begins = 0, ends = 0, cuts = 0;
  const long before = test::allocationCount();
  for (SessionEvent event; session.nextEvent(event);) {
    begins += event.kind == EventKind::contactBegin;
    ends += event.kind == EventKind::contactEnd;
    cuts += event.kind == EventKind::cut;
  }
  BrickChange brick;
  while (session.takeChange(cut, brick)) continue;
  (void)session.snapshot();
  CHECK(test::allocationCount() == before);
  CHECK(begins > 0);
  CHECK(ends > 0);
  CHECK(cuts > 0);
}

TEST_CASE("ticks of two sessions that cut one solid allocate nothing", "[realtime]") {
  test::TwoBurs burs({2e-3, 0.0, 5e-3});
  burs.first->spin(true);
  burs.second->spin(true);
  const long before = test::allocationCount();
  for (int i = 0; i < 400; ++i) {
    test::tickOnce(*burs.first, *burs.a, 2.0);
    test::tickOnce(*burs.second, *burs.b, 2.0);
  }
  CHECK(test::allocationCount() == before);
  CHECK(burs.first->snapshot().removed[0] > 0.0);
  CHECK(burs.second->snapshot().removed[0] > 0.0);
}

TEST_CASE("a recorded tick of a session allocates nothing", "[realtime]") {
  SessionDef def = test::definition();
  test::Bench bench(def);
  (void)bench.session.add(test::wallAt("wall", 0.0));
  bench.run(20);
  const test::TemporaryFolder folder;
  bench.session.record(folder / "run.enr");
  long allocated = 0;
  Command command;
  for (int i = 0; i < 1000; ++i) {
    Measurement measurement;
    REQUIRE(bench.device.measure(measurement) == Status::ok);
    const long before = test::allocationCount();
    (void)bench.session.tick(measurement, command);
    allocated += test::allocationCount() - before;
    REQUIRE(bench.device.actuate(command) == Status::ok);
    REQUIRE(bench.device.advance([&](double, const Pose& pose, const Vec6& twist) {
      return test::pushing(4.0, bench.session.start(), pose, twist);
    }) == Status::ok);
  }
  CHECK(allocated == 0);
  CHECK(bench.session.stopRecording().ticks == 1000);
}

}  // namespace enamel::test_session
