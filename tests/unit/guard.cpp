// The guard: what it passes, limits and stops, and that it reports it.
#include "enamel/render/guard.hpp"

#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/guard_faults.hpp"
#include "support/guard_step.hpp"
#include "support/pressed_wall.hpp"
#include "support/pushes.hpp"

namespace enamel::test_guard {

namespace {

// A guard of the nominal device, at home and at rest by default.
struct Bench {
  TauMechanism device{test::nominal()};
  Guard guard;
  Kinematics k = device.home();
  Measurement m;
  JointVector gravity = k.gravity;
  double time = 0.0;

  explicit Bench(const std::function<void(GuardOptions&)>& change = {})
      : guard(device, [&] {
          GuardOptions options = guardFor(device, 1e-3);
          if (change) change(options);
          return options;
        }()) {
    m.q = k.q;
    m.rates = JointVector::Zero(6);
  }

  test::GuardedCommand ask(const Vec6& wrench, double later = 1e-3) {
    time += later;
    m.time = time;
    return test::guardStep(guard, m, k, staticTorque(k, wrench), Status::ok);
  }
  Vec6 rendered(const test::GuardedCommand& command) const { return wrenchOf(k, command.effort - gravity); }
};

Vec6 force(double x, double y, double z) { return (Vec6() << x, y, z, 0.0, 0.0, 0.0).finished(); }

}  // namespace

TEST_CASE("guard: the reference runs have the same bits with it and without", "[guard]") {
  for (const test::ReferenceRun& run : test::referenceRuns()) {
    const TauMechanism plant(run.servo ? test::nominal() : test::dampedNominal());
    HoldRenderer hold = test::holdRenderer(test::asInThePaper());
    ImpedanceRenderer spring({6000.0, 0.0});
    Renderer& renderer = run.servo ? static_cast<Renderer&>(hold) : spring;
    PushSetup setup = test::referenceSetup(run);
    const auto guarded = test::recordPush(plant, renderer, setup);
    setup.guarded = false;
    const auto bare = test::recordPush(plant, renderer, setup);
    REQUIRE(guarded.size() == bare.size());
    for (std::size_t i = 0; i < bare.size(); ++i) {
      REQUIRE(guarded[i].guard == GuardReason::none);
      REQUIRE(guarded[i].command == guarded[i].requested);
      REQUIRE(guarded[i].torque == bare[i].torque);
      REQUIRE(guarded[i].pose.position == bare[i].pose.position);
      REQUIRE(guarded[i].twist == bare[i].twist);
    }
  }
}

TEST_CASE("guard: every injected fault, with both renderers", "[guard]") {
  const TauMechanism device(test::nominal());
  for (const test::Fault& fault : test::guardFaults())
    for (const bool echo : {true, false}) {
      PositionControlRenderer servo = test::positionControl(device);
      test::requireGuarded(servo, fault, echo);
      ImpedanceRenderer spring({3000.0, 0.0});
      test::requireGuarded(spring, fault, echo);
    }
}

TEST_CASE("guard: a force is cut without being turned, gravity stays", "[guard]") {
  Bench limited([](GuardOptions& o) { o.force = 5.0; });
  limited.ask(Vec6::Zero());
  const test::GuardedCommand less = limited.ask(force(0.0, 3.0, 4.0 - 1e-9));
  CHECK(less.reason == GuardReason::none);
  const test::GuardedCommand cut = limited.ask(force(6.0, 0.0, 8.0));
  CHECK(cut.reason == GuardReason::force);
  CHECK((limited.rendered(cut) - force(3.0, 0.0, 4.0)).norm() < 1e-9);

  Bench bench;
  bench.ask(Vec6::Zero());
  const double most = largestForce(bench.k, bench.device.limits().effort, bench.k.pose.position, Vec3::UnitY());
  const test::GuardedCommand saturated = bench.ask(force(0.0, 3.0 * most, 0.0));
  CHECK(saturated.reason == GuardReason::torque);
  CHECK((bench.rendered(saturated) - force(0.0, most, 0.0)).norm() < 1e-6);

  Bench weak([](GuardOptions& o) { o.moment = 0.01; });
  weak.ask(Vec6::Zero());
  const Vec6 twisting = (Vec6() << 1.0, 0.0, 0.0, 0.0, 0.0, 0.02).finished();
  CHECK((weak.rendered(weak.ask(twisting)) - 0.5 * twisting).norm() < 1e-9);

  // Below gravity's torque: the whole gravity torque is scaled down.
  Bench tired([](GuardOptions& o) { o.torque *= 0.02; });
  const test::GuardedCommand sinking = tired.ask(Vec6::Zero());
  CHECK(sinking.reason == GuardReason::torque);
  CHECK(sinking.effort.normalized().isApprox(tired.gravity.normalized(), 1e-12));
}

TEST_CASE("guard: the slew is kept on the straight way to what is asked", "[guard]") {
  Bench bench([](GuardOptions& o) { o.slew.setConstant(20.0); });  // 0.02 N m per tick
  JointVector last = bench.ask(Vec6::Zero()).effort;
  const JointVector goal = staticTorque(bench.k, force(0.0, 0.0, 8.0));
  int ticks = 0;
  for (test::GuardedCommand c; c.effort.size() == 0 || c.effort != goal; ++ticks) {
    REQUIRE(ticks < 100);
    c = bench.ask(force(0.0, 0.0, 8.0));
    REQUIRE((c.effort - last).cwiseAbs().maxCoeff() <= 0.02 * (1.0 + 1e-9));
    CHECK((c.effort - last).normalized().isApprox((goal - last).normalized(), 1e-9));
    CHECK(c.reason == (c.effort == goal ? GuardReason::none : GuardReason::slew));
    last = c.effort;
  }
  CHECK(ticks == Approx((goal - bench.gravity).cwiseAbs().maxCoeff() / 0.02).margin(1.0));
}

TEST_CASE("guard: it engages only where little is demanded, and ramps in", "[guard]") {
  Bench bench;
  for (int i = 0; i < 50; ++i) {
    const test::GuardedCommand c = bench.ask(force(0.0, 0.0, 18.0));
    REQUIRE(c.reason == GuardReason::waiting);
    REQUIRE(c.effort.isApprox(bench.gravity, 1e-14));
  }
  CHECK_FALSE(bench.guard.engaged());
  double last = 0.0;
  for (int i = 0; i < 110; ++i) {  // 0.1 s
    const test::GuardedCommand c = bench.ask(force(0.0, 0.0, 1.0));
    const double rendered = bench.rendered(c)[2];
    REQUIRE(rendered == Approx(std::min(1.0, 0.01 * (i + 1))).margin(1e-9));
    REQUIRE(c.reason == (i < 99 ? GuardReason::engaging : GuardReason::none));
    REQUIRE(rendered >= last - 1e-12);
    last = rendered;
  }
  CHECK(bench.guard.engaged());
  CHECK(bench.ask(force(0.0, 0.0, 10.0)).reason == GuardReason::none);  // from now on larger requests are allowed
}

TEST_CASE("guard: a tool that is inside a wall when it is switched on is not kicked", "[guard]") {
  const TauMechanism device(test::dampedNominal());
  ImpedanceRenderer spring({6000.0, 0.0});
  HoldRenderer hold = test::holdRenderer();
  for (Renderer* renderer : {static_cast<Renderer*>(&spring), static_cast<Renderer*>(&hold)}) {
    LoopSetup setup;
    setup.start.position.z() = -3e-3;
    VirtualLoop loop(device, *renderer, setup);
    TickRecord record;
    const auto still = test::handAt(0.0, 0.0, 0.0);
    for (int i = 0; i < 500; ++i) {
      REQUIRE(loop.tick(still, record) == Status::ok);
      REQUIRE(record.guard == GuardReason::waiting);
    }
    CHECK((record.pose.position - setup.start.position).norm() < 1e-6);
    // A hand that pulls it out, 3 mm in about 0.3 s, feels no force on the way; then the wall is back.
    const auto handAt = [](double z) { return test::handAt(z, 100.0, 5.0); };
    double fastest = 0.0;
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(loop.tick(handAt(1e-3), record) == Status::ok);
      fastest = std::max(fastest, record.twist.head<3>().norm());
    }
    CHECK(fastest < 0.15);
    CHECK(record.guard == GuardReason::none);
    CHECK(record.pose.position.z() > 0.0);
    for (int i = 0; i < 1000; ++i) REQUIRE(loop.tick(handAt(-0.03), record) == Status::ok);
    CHECK(record.guard == GuardReason::none);
    CHECK(record.normalForce > 2.0);
    CHECK(record.pose.position.z() > -1e-3);
  }
}

TEST_CASE("guard: the user's enable ramps out and in, without a fault", "[guard]") {
  Bench bench;
  bench.ask(Vec6::Zero());
  bench.ask(force(0.0, 0.0, 10.0));
  bench.m.enabled = false;
  for (int i = 1; i <= 30; ++i) {
    const test::GuardedCommand c = bench.ask(force(0.0, 0.0, 10.0));
    CHECK(c.reason == GuardReason::disabled);
    CHECK(bench.rendered(c)[2] == Approx(10.0 * std::max(0.0, 1.0 - i / 20.0)).margin(1e-9));
  }
  bench.m.enabled = true;
  CHECK(bench.ask(force(0.0, 0.0, 10.0)).reason == GuardReason::waiting);
  CHECK(bench.ask(force(0.0, 0.0, 1.0)).reason == GuardReason::engaging);
  CHECK(bench.guard.fault() == GuardReason::none);
}

TEST_CASE("guard: a brake beyond the speed and the workspace, then a stop", "[guard]") {
  const auto moveAt = [](Bench& bench, const Vec3& from, const Vec3& velocity) {
    test::GuardedCommand c;
    Pose pose;
    for (int i = 0; i < 2; ++i) {
      pose.position = from + i * 1e-3 * velocity;
      Vec6 twist = Vec6::Zero();
      REQUIRE(bench.device.reach(pose, twist, false, bench.k) == Status::ok);
      bench.m.q = bench.k.q;
      bench.gravity = bench.k.gravity;
      c = bench.ask(Vec6::Zero());
    }
    return c;
  };
  const Vec3 aside(0.6, 0.0, 0.8);
  Bench slow, fast, faster;
  CHECK(moveAt(slow, Vec3::Zero(), 0.95 * aside).reason == GuardReason::none);
  const test::GuardedCommand braked = moveAt(fast, Vec3::Zero(), 1.5 * aside);
  CHECK(braked.reason == GuardReason::brake);
  // 0.5 m/s too fast; the chord of 1.5 mm compared with the tangent: about 1 %.
  const Vec3 brake = fast.rendered(braked).head<3>();
  CHECK((brake + 0.5 * fast.guard.options().brake * aside).norm() < 0.02 * brake.norm());
  CHECK(moveAt(faster, Vec3::Zero(), 3.1 * aside).reason == GuardReason::speed);

  const auto boxed = [](GuardOptions& o) { o.workspace.setConstant(0.01); };
  Bench inside(boxed), outwards(boxed), back(boxed), beyond(boxed);
  CHECK(moveAt(inside, Vec3(0.0, 0.0095, 0.0), Vec3(0.0, 0.2, 0.0)).reason == GuardReason::none);
  const test::GuardedCommand held = moveAt(outwards, Vec3(0.0, 0.0105, 0.0), Vec3(0.1, 0.2, 0.0));
  CHECK(held.reason == GuardReason::brake);
  CHECK((outwards.rendered(held).head<3>() + 0.2 * outwards.guard.options().brake * Vec3::UnitY()).norm() < 0.02);
  CHECK(moveAt(back, Vec3(0.0, 0.0105, 0.0), Vec3(0.0, -0.2, 0.0)).reason == GuardReason::none);
  CHECK(moveAt(beyond, Vec3(0.0, 0.016, 0.0), Vec3::Zero()).reason == GuardReason::workspace);
}

TEST_CASE("guard: damping and the budget of energy are taken from the device's model", "[guard]") {
  CHECK(guardFor(TauMechanism(test::nominal()), 1e-3).damping.norm() < 1e-9);
  const Mat6 damping = guardFor(TauMechanism(test::dampedNominal()), 1e-3).damping;
  CHECK((damping - 4.0 * Vec6::Unit(2) * Vec6::Unit(2).transpose()).norm() < 1e-9);
  for (const char* name : {"tau-nominal.toml", "delta.toml", "cartesian-3.toml", "cartesian-6.toml"}) {
    const auto device = makeMechanism(loadDevice(test::deviceFile(name)));
    const GuardOptions options = guardFor(*device, 1e-3);
    CHECK_NOTHROW(Guard(*device, options));
    double weakest = HUGE_VAL;  // largest force at home in the weakest direction
    for (int axis = 0; axis < 3; ++axis)
      for (const Vec3& way : {Vec3(Vec3::Unit(axis)), Vec3(-Vec3::Unit(axis))})
        weakest = std::min(weakest, largestForce(device->home(), device->limits().effort, Vec3::Zero(), way));
    CHECK(options.energy == Approx(0.7e-3 * weakest));
    CHECK(options.power == Approx(1e-3 * weakest));
    CHECK(options.brake > 0.0);
  }
}

TEST_CASE("guard: energy is held against a renderer, but not against a moving wall or a spring that gives back",
          "[guard]") {
  // A tool that moves by y(t) along y and is pushed along y with f(t).
  const auto reasonOf = [](auto&& y, auto&& f, const Vec3& surface) {
    Bench bench;
    for (int i = 0; i < 1000; ++i) {
      Pose pose;
      pose.position.y() = y(1e-3 * i);
      REQUIRE(bench.device.reach(pose, Vec6::Zero(), false, bench.k) == Status::ok);
      bench.m.q = bench.k.q;
      bench.m.time = 1e-3 * i;
      const test::GuardedCommand c = test::guardStep(
          bench.guard, bench.m, bench.k, staticTorque(bench.k, force(0.0, f(1e-3 * i), 0.0)), Status::ok, surface);
      if (c.reason != GuardReason::none) return c.reason;
    }
    return GuardReason::none;
  };
  const auto steady = [](double t) { return 0.02 * t - 0.01; };  // 20 mm/s
  const auto push = [](double t) { return std::min(5.0, 50.0 * t); };
  CHECK(reasonOf(steady, push, Vec3::Zero()) == GuardReason::energy);  // 100 mW
  CHECK(reasonOf(steady, push, Vec3(0.0, 0.02, 0.0)) == GuardReason::none);
  // In by 10 mm and out again along a spring of 1 kN/m, four times: 50 mJ each.
  const auto stroke = [](double t) { return -5e-3 * (1.0 - std::cos(8.0 * M_PI * t)); };
  CHECK(reasonOf(
            stroke, [&](double t) { return -1000.0 * stroke(t); }, Vec3::Zero()) == GuardReason::none);
  // The same spring, delayed by 10 ms.
  CHECK(reasonOf(
            stroke, [&](double t) { return -1000.0 * stroke(t - 0.01); }, Vec3::Zero()) == GuardReason::energy);
}

TEST_CASE("guard: an encoder that freezes while its joint moves is seen, one of a tool at rest is not", "[guard]") {
  for (const bool rates : {true, false}) {
    Bench bench;
    const auto moved = [&](int i, bool frozen) {
      Pose pose;
      pose.position.y() = 1e-4 * i;  // 100 mm/s
      Vec6 twist = Vec6::Zero();
      twist[1] = 0.1;
      REQUIRE(bench.device.reach(pose, twist, false, bench.k) == Status::ok);
      const double stuck = bench.m.q[1];
      bench.m.q = bench.k.q;
      if (frozen) bench.m.q[1] = bench.k.q[1] = stuck;
      bench.m.rates = rates ? bench.k.rates : JointVector(JointVector::Zero(6));
      return bench.ask(Vec6::Zero()).reason;
    };
    for (int i = 0; i < 100; ++i) REQUIRE(moved(i, false) == GuardReason::none);
    int ticks = 0;
    while (ticks < 100 && moved(100 + ticks, true) == GuardReason::none) ++ticks;
    CHECK(ticks == 49);
    CHECK(bench.guard.fault() == GuardReason::frozen);
  }
  Bench rest;
  for (int i = 0; i < 500; ++i)
    REQUIRE(rest.ask(force(0.0, 0.0, 3.0 * std::sin(0.02 * i))).reason == GuardReason::none);
}

TEST_CASE("guard: missed deadlines add up and are forgotten", "[guard]") {
  Bench seldom, often;
  for (int i = 0; i < 5000; ++i)
    REQUIRE(seldom.ask(Vec6::Zero(), i % 200 == 0 ? 2e-3 : 1e-3).reason == GuardReason::none);
  int ticks = 0;
  while (ticks < 100 && often.ask(Vec6::Zero(), ticks % 2 == 0 ? 2e-3 : 1e-3).reason == GuardReason::none) ++ticks;
  CHECK(ticks == Approx(22).margin(2));  // the 11th miss
  CHECK(often.guard.fault() == GuardReason::deadlines);
  Bench gap;
  gap.ask(Vec6::Zero());
  CHECK(gap.ask(Vec6::Zero(), 4e-3).reason == GuardReason::none);
  CHECK(gap.ask(Vec6::Zero(), 4.1e-3).reason == GuardReason::late);
}

TEST_CASE("guard: a fault's ramp never pushes the tool on", "[guard]") {
  for (const double direction : {-1.0, 1.0}) {
    Bench bench;
    Vec6 asked = Vec6::Zero();
    for (int i = 0; i < 40; ++i) {
      Pose pose;
      pose.position.y() = direction * 2e-5 * i;  // 20 mm/s
      REQUIRE(bench.device.reach(pose, Vec6::Zero(), false, bench.k) == Status::ok);
      bench.m.q = bench.k.q;
      bench.gravity = bench.k.gravity;
      bench.m.time = 1e-3 * i;
      if (i > 0) asked = force(0.0, 4.0, 0.0);
      const test::GuardedCommand c = test::guardStep(bench.guard, bench.m, bench.k, staticTorque(bench.k, asked),
                                                     i < 10 ? Status::ok : Status::notConverged);
      const double rendered = bench.rendered(c)[1];
      if (i < 10) continue;
      REQUIRE(c.reason == GuardReason::renderer);
      const double left = direction > 0.0 ? 0.0 : std::max(0.0, 4.0 * (1.0 - (i - 9) / 20.0));
      REQUIRE(rendered == Approx(left).margin(0.01));  // with the Jacobian of this tick
    }
  }
}

TEST_CASE("guard: a fault that stands for months stays a fault", "[guard]") {
  Bench bench;
  bench.ask(Vec6::Zero());
  bench.ask(force(0.0, 0.0, 1.0));
  bench.m.q[0] = std::nan("");
  std::vector<double> before(Guard::stateSize()), state = before;
  for (int i = 0; i < 50; ++i) {
    bench.guard.saveState(before.data());
    REQUIRE(bench.ask(Vec6::Zero()).effort.isZero(0.0) == (i >= 19));
  }
  bench.guard.saveState(state.data());
  int counters = 0;
  for (std::size_t i = 0; i < state.size(); ++i)
    if (state[i] == before[i] + 1.0) ++counters, state[i] = std::numeric_limits<int>::max() - 2;
  CHECK(counters == 1);
  bench.guard.loadState(state.data());
  for (int i = 0; i < 5; ++i) CHECK(bench.ask(Vec6::Zero()).effort.isZero(0.0));
  CHECK(bench.guard.fault() == GuardReason::measurement);
}

TEST_CASE("guard: the renderer hears what was sent to a device that cannot tell", "[guard]") {
  const TauMechanism device(test::nominal());
  const Scene wall = flatWall();
  class Hearing final : public Renderer {
   public:
    ImpedanceRenderer spring{{6000.0, 0.0}};
    JointVector heard;

   private:
    void prepare(double period) override { spring.activate(period); }
    Status render(const TickFrame& input, TickOutput& output) noexcept override {
      CHECK_FALSE(input.applied.has_value());
      heard = input.command;
      return spring.step(input, output);
    }
    void resetState() noexcept override { spring.reset(); }
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  } renderer;
  GuardOptions options = guardFor(device, 1e-3);
  options.force = 2.0;
  HapticTick tick(device, wall, Tool(), renderer, options);
  tick.setEffect(Vec6::Constant(0.1));
  Measurement m;
  Command command, last;
  for (int i = 0; i < 20; ++i) {
    Kinematics k;
    REQUIRE(device.reach(test::poseAtDepth(i < 10 ? 0.0 : 5e-5 * (i - 9)), Vec6::Zero(), false, k) == Status::ok);
    m.time = 1e-3 * i;
    m.q = k.q;
    m.rates = k.rates;
    REQUIRE(tick(m, command) == Status::ok);
    CHECK(renderer.heard == last.effort);
    last = command;
  }
  CHECK(tick.frame().reason == GuardReason::force);
  CHECK(command.effort != tick.frame().output.torque);
}

TEST_CASE("guard: reports are believed where commands repeat and are skipped at random", "[guard]") {
  test::PressedWall press;
  press.delay = {0, 3};
  for (press.seed = 1; press.seed <= 10; ++press.seed) CHECK(test::run(press).ignoredReports == 0);
  for (const double factor : {0.0, -1.0}) {
    press.driver = [factor](int tick, Measurement& sample) {
      if (tick >= 0) *sample.applied *= factor;
      return Status::ok;
    };
    CAPTURE(factor);
    CHECK(test::run(press).ignoredReports > 0);
  }
}

TEST_CASE("guard: a copy goes on as the original does; a thousand ticks are kept", "[guard]") {
  Bench bench;
  for (int i = 0; i < 1500; ++i) bench.ask(force(0.0, 0.0, 2.0 * std::sin(0.01 * i)));
  CHECK(bench.guard.kept() == kGuardTicks);
  CHECK(bench.guard.tick(0).time == bench.time);
  CHECK(bench.guard.tick(999).time == Approx(bench.time - 0.999));
  Guard copy = bench.guard;
  for (int i = 0; i < 300; ++i) {
    bench.m.time = bench.time += 1e-3;
    if (i == 100) bench.m.q[3] += 1.0;
    const JointVector asked = staticTorque(bench.k, force(0.0, 0.0, 5.0 * std::sin(0.1 * i)));
    const test::GuardedCommand a = test::guardStep(bench.guard, bench.m, bench.k, asked, Status::ok),
                               b = test::guardStep(copy, bench.m, bench.k, asked, Status::ok);
    REQUIRE(a.effort == b.effort);
    REQUIRE(a.reason == b.reason);
  }
  CHECK(copy.fault() == GuardReason::jump);
  CHECK(copy.tick(0).time == Approx(bench.time - 0.18).margin(1.5e-3));  // no ticks are added after the ramp
}

TEST_CASE("guard: limits that are none are refused", "[guard]") {
  const TauMechanism device(test::nominal());
  const auto made = [&](auto change) {
    GuardOptions options = guardFor(device, 1e-3);
    change(options);
    return Guard(device, options);
  };
  CHECK_NOTHROW(made([](GuardOptions& o) { o.torque *= 0.5; }));
  CHECK_THROWS_WITH(made([](GuardOptions& o) { o.torque[2] = 2.5; }),
                    "guard: the torque limit of joint 3 is 2.5, must be in 0 to the device's 2 N m or N");
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.torque[2] = std::nan(""); }), Error);
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.slew.resize(3); }), Error);
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.slew[0] = 0.0; }), Error);
  CHECK_THROWS_WITH(made([](GuardOptions& o) { o.force = -1.0; }),
                    "guard: the largest force is -1, must be at least 0 N");
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.energy = std::nan(""); }), Error);
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.stopSpeed = 0.1; }), Error);
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.workspace[1] = -1.0; }), Error);
  CHECK_THROWS_AS(made([](GuardOptions& o) { o.period = 0.0; }), Error);
  CHECK_THROWS_AS(guardFor(device, 1.0), Error);
  const auto shared = std::make_shared<TauMechanism>(test::nominal());
  CHECK_THROWS_WITH(guardFor(MappedMechanism(shared, {Pose{}, 2.0}), 1e-3),
                    test::ContainsSubstring("toScene(guardFor("));
}

}  // namespace enamel::test_guard
