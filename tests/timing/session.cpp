// Reports the cost of each change of a session, on the caller's thread and in the tick that takes it over. Times are
// printed only; the test checks that every change arrived. A loop under random changes keeps its time.
#include "enamel/session/session.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <thread>

#include "enamel/plugin/renderer_source.hpp"
#include "support/run_length.hpp"
#include "support/session_bench.hpp"

namespace enamel::test_session {

namespace {

using Clock = std::chrono::steady_clock;

double since_us(Clock::time_point begin) {
  return std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
}

double median(std::vector<double>& times) {
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
  return times[times.size() / 2];
}

// A session with a wall, some balls and a molar-sized solid, whose ticks this thread runs.
class Table {
 public:
  explicit Table(int balls) : bench_(test::definition()) {
    (void)session().add(test::wallAt("wall", 0.0));
    for (int i = 0; i < balls; ++i)
      (void)session().add(test::ball("ball " + std::to_string(i), {0.02, 2e-3 * i, 0.0}, 5e-4));
    bench_.run(300);
    std::printf("%d obstacles; an ordinary tick takes %.1f us (median)\n", balls + 1, ordinary());
  }
  Session& session() { return bench_.session; }

  // Run `change` many times on another thread, each followed by a tick.
  template <typename Change>
  void row(const char* name, const Change& change) {
    const int repeats = test::count(50, 1000);
    std::vector<double> caller, loop;
    for (int i = 0; i < repeats; ++i) {
      std::thread([&] {
        const auto begin = Clock::now();
        change(i);
        caller.push_back(since_us(begin));
      }).join();
      loop.push_back(tick_us());
      bench_.run(2);
    }
    std::printf("  %-32s caller %9.1f us   its tick %7.1f us\n", name, median(caller), median(loop));
  }

 private:
  double tick_us() {
    Measurement measurement;
    REQUIRE(bench_.device.measure(measurement) == Status::ok);
    const auto begin = Clock::now();
    (void)session().tick(measurement, bench_.command);
    const double time = since_us(begin);
    REQUIRE(bench_.device.actuate(bench_.command) == Status::ok);
    REQUIRE(bench_.device.advance([this](double, const Pose& pose, const Vec6& twist) {
      return test::pushing(bench_.force, session().start(), pose, twist);
    }) == Status::ok);
    return time;
  }
  double ordinary() {
    std::vector<double> times(200);
    for (double& time : times) time = tick_us();
    return median(times);
  }

  test::Bench bench_;
};

}  // namespace

TEST_CASE("the cost of changes", "[timing]") {
  for (const int balls : {10, 100}) {
    Table table(balls);
    Session& session = table.session();
    ObstacleId id;
    table.row("add, remove a ball", [&](int i) {
      if (i % 2 == 0)
        id = session.add(test::ball("another", {0.0, 0.03, 0.0}, 1e-3));
      else
        session.remove(id);
    });
    const ObstacleId moved = session.find("ball 0");
    table.row("move", [&](int i) { session.move(moved, Pose{{0.02, 1e-5 * i, 0.0}, Mat3::Identity()}); });
    table.row("setMaterial", [&](int i) {
      Material material;
      material.friction = material.slidingFriction = 1e-3 * i;
      session.setMaterial(moved, material);
    });
    table.row("setTool", [&](int i) {
      Tool tool;
      tool.parts[0].radius = i % 2 == 0 ? 1e-6 : 0.0;
      session.setTool(tool);
    });
    table.row("setRenderer (position-control)", [&](int) { session.setRenderer(kPositionControl); });
    table.row("setEffect", [&](int i) { session.setEffect(1e-3 * (i % 2) * Vec6::Unit(0)); });
    table.row("snapshot", [&](int) { (void)session.snapshot(); });
    if (balls > 10) continue;

    const MeshModel surface(test::boxMesh(Vec3::Constant(5e-3)));
    SessionObstacle tooth;
    tooth.name = "tooth";
    tooth.pose.position.y() = -0.03;
    tooth.solid = std::make_shared<const Solid>(
        surface, std::vector<SolidLayer>{{"stuff", Material{}, 0.2e9, 0.0, nullptr}}, SolidOptions{1e-4, 64});
    std::printf("  a solid of %.0f MB:\n", 1e-6 * static_cast<double>(tooth.solid->bytes()));
    table.row("add, remove a solid", [&](int i) {
      if (i % 2 == 0)
        id = session.add(tooth);
      else
        session.remove(id);
    });
    id = session.add(tooth);
    table.row("add, remove a ball beside it", [&](int i) {
      if (i % 2 == 0)
        (void)session.add(test::ball("another", {0.0, 0.03, 0.0}, 1e-3));
      else
        session.remove(session.find("another"));
    });
    table.row("restore", [&](int) { session.restore(id); });
    const Snapshot now = session.snapshot();
    CHECK(now.tick.number > 300);
    CHECK(now.droppedEvents == 0);
    CHECK(session.find("another") == ObstacleId{});
  }
}

TEST_CASE("changes at random delay no tick, and the torque does not jump", "[timing]") {
  const std::chrono::duration<double> length(test::longRun() ? 300.0 : 1.0);  // first without changes, then with them
  for (const bool isChanged : {false, true}) {
    std::atomic<double> largest{0.0};  // change of a torque from tick to tick, as a share of the guard's limit
    JointVector last;
    double before = 0.0;  // time of `last`, s
    SessionDef def = test::definition();
    const Session* running = nullptr;
    def.beforeTick = [&](TickAccess& access) {
      const TickFrame& frame = access.frame();
      const JointVector most = running->haptics().guard().options().slew * (frame.time - before);
      if (last.size() == frame.command.size() && frame.time > before)
        largest = std::max(largest.load(), (frame.command - last).cwiseAbs().cwiseQuotient(most).maxCoeff());
      last = frame.command;
      before = frame.time;
    };
    Session session(def);
    running = &session;
    (void)session.add(test::wallAt("wall", 0.0));
    test::PressingHand hand(session.start());
    session.start(makeVirtualDevice(session, hand.wrench()));
    int changes = 0;
    test::Watched watched;
    if (isChanged) {
      test::RandomChanges one(session, 1, length), two(session, 2, length);
      watched = test::watch(session, hand, length);
      for (test::RandomChanges* thread : {&one, &two}) {
        const auto [made, failed] = thread->finish();
        changes += made;
        CHECK(failed == 0);
      }
    } else {
      watched = test::watch(session, hand, length);
    }
    const PeriodicTiming& timing = session.loop()->timing();
    const auto ticks = timing.periods.load(), missed = timing.missed.load();
    std::printf(
        "%d changes by two threads: %llu ticks, %llu deadlines missed; compute median %.1f us, 99.9 %% %.1f us; "
        "largest torque step %.3f of the guard's limit; stopped %d times, pressed %.0f %% of the time\n",
        changes, static_cast<unsigned long long>(ticks), static_cast<unsigned long long>(missed),
        1e6 * timing.compute.quantile(0.5), 1e6 * timing.compute.quantile(0.999), largest.load(), watched.lateStops,
        1e2 * watched.pressed);
    CHECK(static_cast<double>(ticks) > 0.5 * def.rate * length.count());
    CHECK(timing.compute.quantile(0.99) < 0.5 / def.rate);
    CHECK(largest.load() <= 1.0 + 1e-9);
    CHECK(watched.otherReasons == "");
    if (test::longRun()) CHECK(watched.pressed > 0.5);
  }
}

}  // namespace enamel::test_session
