// The viewer's experiment without a picture: hand, test push and settings.
#include "experiment.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "colours/palette.hpp"
#include "enamel/core/error.hpp"
#include "enamel/study/metrics.hpp"
#include "runner.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/experiments.hpp"
#include "support/run_length.hpp"
#include "torque_style.hpp"

namespace enamel::viewer::test_experiment {

using namespace fixture;

namespace {

void run(Experiment& e, int ticks) {
  for (int i = 0; i < ticks; ++i) e.tick();
}

TestPush testPush(Experiment& e) {
  e.startTestPush();
  do e.tick();
  while (e.frame().testing);
  return e.frame().tests[indexOf(e.frame().selected)];
}

double number(const char* symbol, const PushMetrics& metrics) {
  for (const Metric& metric : allMetrics())
    if (metric.symbol == std::string(symbol)) return valueOf(metrics, metric).value();
  FAIL("no metric " << symbol);
  return 0.0;
}

}  // namespace

TEST_CASE("the tool stops at the wall, the hand goes on, and the force is the hand's spring", "[experiment]") {
  for (const RendererSlot slot : {RendererSlot::positionControl, RendererSlot::impedance, RendererSlot::hold}) {
    INFO(indexOf(slot));
    const auto e = experiment(shipped("flat-wall.toml"), slot);
    e->moveHandTo({0.0, 0.0, -0.025});
    run(*e, 2000);
    const Frame& frame = e->frame();
    REQUIRE(frame.plant == Status::ok);
    // At rest the hand's force, 400 N/m times its stretch, is the wall's.
    const double depth = -frame.record.nearest.gap;
    const double force = 400.0 * (0.025 - depth);
    CHECK(frame.hand.position.z() == Approx(-0.025).epsilon(1e-3));
    // Position control reacts to every encoder count: use the mean.
    if (slot != RendererSlot::positionControl) CHECK(-frame.record.handWrench[2] == Approx(force).epsilon(3e-3));
    double mean = 0.0, hand = 0.0;
    for (int i = 0; i < 500; ++i) {
      e->tick();
      mean += e->frame().record.normalForce / 500.0;
      hand -= e->frame().record.handWrench[2] / 500.0;
    }
    CHECK(hand == Approx(force).epsilon(3e-3));
    CHECK(mean == Approx(force).epsilon(1e-2));
    if (slot == RendererSlot::impedance)
      CHECK(depth == Approx(force / 6000.0).epsilon(1e-2));
    else
      CHECK(std::abs(depth) < 3e-5);  // both return the tool to the surface
    CHECK(frame.holding == (slot == RendererSlot::hold));
  }
}

TEST_CASE("read-outs are smooth where the force alternates, keep its sign, and show a stop at once", "[experiment]") {
  ReadoutFilter filter;
  TickRecord record;
  record.nearest.normal = Vec3::UnitZ();
  Readout last;
  for (int i = 0; i < 1500; ++i) {
    record.time = 1e-3 * i;
    const bool early = i < 750;
    record.rendered[2] = i % 2 == 0 ? (early ? 6.0 : -6.0) : (early ? -4.0 : 4.0);  // N: a mean of 1, then of -1
    record.handWrench[2] = early ? -1.0 : 1.0;
    record.nearest.gap = i % 2 == 0 ? -2e-6 : 0.0;
    last = filter.add(record);
    if (i % 750 < 700) continue;
    REQUIRE(last.force.z() == Approx(early ? 1.0 : -1.0).margin(0.06));  // 1 % of the range a tick
    REQUIRE(last.hand == Approx(early ? 1.0 : -1.0).margin(2e-3));
    REQUIRE(last.depth == Approx(1e-6).margin(2e-8));
  }
  record.time += 1e-3;
  record.rendered.setZero();
  record.guard = GuardReason::oscillation;
  CHECK(filter.add(record).force.norm() == 0.0);
  // A restart of time begins with the value of its first tick.
  record.guard = GuardReason::none;
  record.time = 0.0;
  record.rendered[2] = 5.0;
  CHECK(filter.add(record).force.z() == 5.0);
  // An experiment fills them in: under position control the ticks alternate, the read-out does not.
  const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::positionControl);
  e->moveHandTo({0.0, 0.0, -0.010});
  run(*e, 2000);
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 300; ++i) {
    e->tick();
    low = std::min(low, e->frame().readout.force.z());
    high = std::max(high, e->frame().readout.force.z());
  }
  CHECK(high - low < 0.5);
  CHECK(high == Approx(4.0).margin(0.3));
}

TEST_CASE("the hand's force is bounded, and it does not wind up", "[experiment]") {
  const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::impedance);
  for (int i = 0; i < 2000; ++i) {
    e->moveHandTo({0.0, 0.0, -0.5});
    e->tick();
  }
  CHECK(-e->frame().record.handWrench[2] == Approx(kLargestHandForce).epsilon(1e-2));
  CHECK(e->frame().hand.target.z() > -0.05);
  // A change of grip keeps the force.
  const double before = e->frame().record.handWrench[2];
  e->setGrip(kPaperGrip);
  e->tick();
  CHECK(e->frame().record.handWrench[2] == Approx(before).epsilon(0.02));
  CHECK(e->frame().hand.position.z() < -0.3);  // 15 N at 40 N/m
}

TEST_CASE("a test push measures what the specification says", "[experiment]") {
  // Without the tool's mechanical damping, hold reaches 20 to 30 kN/m. With it, the spring reaches 3 to 4 kN/m.
  // Position control is an order of magnitude stiffer than hold.
  Settings undamped;
  undamped.toolDamping = 0.0;
  const auto servo = experiment(shipped("flat-wall.toml"), RendererSlot::hold, undamped);
  const auto spring = experiment(shipped("flat-wall.toml"), RendererSlot::impedance);
  const TestPush a = testPush(*servo), b = testPush(*spring);
  REQUIRE(a.verdict == FirstImpactVerdict::measured);
  REQUIRE(b.verdict == FirstImpactVerdict::measured);
  CHECK_FALSE(servo->frame().tests[1].made);
  CHECK(a.stiffness > 20e3);
  CHECK(a.stiffness < 32e3);
  CHECK(b.stiffness > 3.0e3);
  CHECK(b.stiffness < 6.0e3);
  CHECK(a.force == Approx(kTestForce - kTestPreload).epsilon(1e-9));
  CHECK(a.stiffness == Approx(a.force / a.depth));
  CHECK(a.preload == Approx(kTestPreload).epsilon(1e-9));
  for (const int delay : {0, 1, 2, 3}) {
    INFO("delay " << delay);
    Settings late;
    late.delay = {delay, delay};
    const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::positionControl, late);
    const TestPush push = testPush(*e);
    CAPTURE(push.stiffness, push.depth, push.preload);
    REQUIRE(push.verdict == FirstImpactVerdict::measured);
    CHECK(push.stiffness > (delay == 0 ? 150e3 : delay == 1 ? 60e3 : 20e3));
    WARN("position control, delay " << delay << ": K_z1 " << 1e-3 * push.stiffness << " kN/m");
  }
}

TEST_CASE("the stiffness shown is that of the continuous motion, also where a delayed law halts on its way in",
          "[experiment]") {
  for (const RendererSlot slot : {RendererSlot::positionControl, RendererSlot::impedance, RendererSlot::hold})
    for (const int delay : {0, 1}) {
      if (slot == RendererSlot::impedance && delay > 0) continue;  // unstable
      INFO(indexOf(slot) << " delay " << delay);
      Settings settings;
      settings.delay = {delay, delay};
      const auto e = experiment(shipped("flat-wall.toml"), slot, settings);
      const auto plant = makeMechanism(changed(nominal().parameters, settings));
      std::vector<TickRecord> ticks;
      e->startTestPush();
      do {
        e->tick();
        if (e->frame().record.tick == 0) ticks.clear();  // start of the push
        ticks.push_back(e->frame().record);
      } while (e->frame().testing);
      const TestPush shown = e->frame().tests[indexOf(slot)];
      REQUIRE(shown.verdict == FirstImpactVerdict::measured);

      constexpr std::size_t onset = 1000;
      double rest = 0.0;
      for (std::size_t i = onset - 100; i <= onset; ++i) rest += ticks[i].nearest.gap / 101.0;

      // Simulate the plant again from every tick to the next, in 16 steps, until it has returned by a tenth.
      PushSetup setup;
      setup.hand.noise = 0.0;
      SimulatedHand hand(setup);
      hand.hold(onset);
      double deepest = 0.0, depth = 0.0;
      const double force = kTestForce - kTestPreload;
      for (std::size_t i = onset; depth >= 0.9 * deepest; ++i) {
        const TickRecord& record = ticks.at(i);
        DeviceState state;
        state.position = record.pose.position;
        state.orientation = Eigen::Quaternion<double>(record.pose.rotation);
        state.twist = record.twist;
        for (int step = 0; step < 16; ++step) {
          const double dt = kPeriod / 16.0;
          REQUIRE(stepRungeKutta4(*plant, record.time + step * dt, dt, record.torque, hand, state) == Status::ok);
          depth = rest - state.position.z();
          deepest = std::max(deepest, depth);
        }
        REQUIRE(state.position.z() == Approx(ticks.at(i + 1).pose.position.z()).margin(1e-9));
      }
      CHECK(shown.depth == Approx(deepest).epsilon(0.01));
      CHECK(shown.stiffness == Approx(force / deepest).epsilon(0.01));
      // The chart shows nothing deeper; it shows less if the tool turns between two ticks.
      double charted = 0.0;
      for (std::size_t i = onset; i < ticks.size(); ++i) charted = std::max(charted, -ticks[i].nearest.gap);
      CHECK(shown.stiffness < 1.01 * force / (charted + rest));
      if (slot != RendererSlot::positionControl)
        CHECK(shown.stiffness == Approx(force / (charted + rest)).epsilon(0.01));
    }
}

TEST_CASE("a test push is runPush() on the surface nearest to the hand, bit for bit, whatever was before",
          "[experiment]") {
  struct Case {
    const char* scene;
    RendererSlot slot;
    int delay;
    bool leans;  // on the wall before the push
  };
  for (const Case& c :
       {Case{"flat-wall.toml", RendererSlot::positionControl, 0, false},
        Case{"corner.toml", RendererSlot::impedance, 1, false},
        Case{"molar.toml", RendererSlot::positionControl, 1, false}, Case{"molar.toml", RendererSlot::hold, 0, false},
        Case{"flat-wall.toml", RendererSlot::positionControl, 1, true}}) {
    INFO(c.scene << " slot " << indexOf(c.slot) << " delay " << c.delay);
    Settings settings;
    settings.delay = {c.delay, c.delay};
    settings.encoders = {true, RateSource::difference};
    settings.noise = 0.5;
    const SceneFile scene = shipped(c.scene);
    const auto e = experiment(scene, c.slot, settings);
    if (c.leans) {
      e->moveHandTo({0.0, 0.0, -0.02});
      run(*e, 1500);
      REQUIRE(e->frame().record.nearest.gap <= 0.0);
      e->moveHandTo(scene.start);
      while (e->frame().record.nearest.gap <= 0.0) e->tick();
    }
    std::vector<TickRecord> shown;
    e->startTestPush();
    do {
      e->tick();
      if (e->frame().record.tick == 0) shown.clear();
      shown.push_back(e->frame().record);
    } while (e->frame().testing);
    const TestPush test = e->frame().tests[indexOf(c.slot)];
    if (test.status != Status::ok && test.status != Status::stopped) shown.pop_back();  // the tick that failed

    const auto plant = makeMechanism(changed(nominal().parameters, settings));
    const auto model = makeMechanism(nominal().parameters);
    PushSetup setup;
    setup.encoders = settings.encoders;
    setup.delay = settings.delay;
    setup.hand.force = kTestForce;
    setup.hand.preload = kTestPreload;
    setup.hand.noise = settings.noise;
    setScene(scene, setup);
    std::unique_ptr<Renderer> renderer;
    if (c.slot == RendererSlot::positionControl)
      renderer = std::make_unique<PositionControlRenderer>(
          positionControlFor(*model, kPeriod, settings.delay.low, settings.delay.high));
    else if (c.slot == RendererSlot::impedance)
      renderer = std::make_unique<ImpedanceRenderer>(settings.spring);
    else
      renderer = std::make_unique<HoldRenderer>(nominal().gain, kPeriod, settings.hold);
    MetricsCollector collector(setup, largestStiffness(*plant, setup), plant->limits().effort);
    std::size_t i = 0, other = 0;
    const PushResult result =
        runPush(std::make_unique<ClosedFormPlant>(*plant), *model, *renderer, setup,
                [&](const TickRecord& tick, const VirtualLoop&) {
                  collector.add(tick);
                  if (i >= shown.size()) return;
                  const TickRecord& same = shown[i++];
                  other += tick.pose.position != same.pose.position || tick.torque != same.torque || tick.q != same.q;
                });
    CHECK(shown.size() == result.ticks);
    CHECK(other == 0);
    CHECK(test.status == result.status);
    if (result.status != Status::ok && result.status != Status::stopped) continue;
    CHECK(test.verdict == collector.metrics().verdict);
    if (test.verdict != FirstImpactVerdict::measured) continue;
    CHECK(test.stiffness == number("K_z1", collector.metrics()));
    CHECK(test.stiffness / test.limit == Approx(number("share of limit", collector.metrics())).epsilon(1e-12));
  }
}

TEST_CASE("a test push without a stiffness says why", "[experiment]") {
  const auto reason = [](RendererSlot slot, const Settings& settings) {
    const auto e = experiment(shipped("flat-wall.toml"), slot, settings);
    const TestPush test = testPush(*e);
    CHECK(test.made);
    CHECK(test.stiffness == 0.0);
    CHECK(e->frame().hand.grip.stiffness == kFirmGrip.stiffness);
    return test.verdict;
  };
  Settings late;
  late.delay = {3, 3};
  CHECK(reason(RendererSlot::impedance, late) == FirstImpactVerdict::unstable);
  Settings creeping;
  creeping.spring.stiffness = 200.0;
  creeping.toolDamping = 100.0;  // far more than critical damping: the tool approaches its depth from one side
  CHECK(reason(RendererSlot::impedance, creeping) == FirstImpactVerdict::noReturn);
}

TEST_CASE("a test push that is interrupted leaves no number, and gives the grip back", "[experiment]") {
  const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::positionControl);
  e->setGrip(kPaperGrip);
  e->startTestPush();
  run(*e, 500);
  REQUIRE(e->frame().testing);
  e->select(RendererSlot::impedance);
  run(*e, 1);
  CHECK_FALSE(e->frame().testing);
  CHECK(e->frame().hand.grip.stiffness == kPaperGrip.stiffness);
  CHECK_FALSE(e->frame().tests[0].made);
  CHECK_FALSE(e->frame().tests[1].made);
}

TEST_CASE("the limit is that of a step to 12 N from the preload, at the plant's inertia and the longest delay",
          "[experiment]") {
  Settings heavier;
  heavier.extraMass = 0.1;
  for (const Settings& settings : {Settings{}, heavier}) {
    const auto plant = makeMechanism(changed(nominal().parameters, settings));
    const JointVector& maxTorque = plant->limits().effort;
    // 0.273 kg is the specification's. A mass at the platform adds fully, because the push does not turn it.
    const double mass = effectiveMass(plant->home(), Vec3::Zero(), Vec3::UnitZ());
    CHECK(mass == Approx(0.273 + settings.extraMass).epsilon(0.02));
    for (int d = 0; d < 4; ++d) {
      const StiffnessLimit limit = stiffnessLimit(plant->home(), maxTorque, Vec3::UnitZ(), {0, d});
      const double t1 = (d + 1) * kPeriod, most = limit.largestForce;
      CHECK(limit.stiffness == Approx(2.0 * mass * (most - 12.0) / (most - 0.5) / (t1 * t1)));
      // F_max is the largest force: up to it, and not above, every motor is within its limit.
      Vec6 push = Vec6::Zero();
      push[2] = most;
      CHECK(staticTorque(plant->home(), push).cwiseAbs().maxCoeff() == Approx(maxTorque[0]).epsilon(1e-12));
    }
  }
}

TEST_CASE("one plant under both renderers: damped by the tool's damping, with a mass that they do not know",
          "[experiment]") {
  const auto plain = makeMechanism(nominal().parameters);
  Settings settings;
  settings.toolDamping = 7.0;
  const auto damped = makeMechanism(changed(nominal().parameters, settings));
  Vec6 twist = Vec6::Zero(), drag = Vec6::Zero(), a, b;
  twist << 0.1, -0.2, 0.3, 1.0, 2.0, -1.0;
  drag.head<3>() = -7.0 * twist.head<3>();
  const JointVector torque = plain->home().gravity;
  REQUIRE(plain->accelerate(Pose{}, twist, torque, drag, a) == Status::ok);
  REQUIRE(damped->accelerate(Pose{}, twist, torque, Vec6::Zero(), b) == Status::ok);
  CHECK((a - b).norm() < 1e-9 * a.norm());

  settings.extraMass = 0.2;
  std::vector<Vec6> free[2];
  for (const RendererSlot slot : {RendererSlot::positionControl, RendererSlot::impedance}) {
    const auto e = experiment(shipped("flat-wall.toml"), slot, settings);
    for (int i = 0; i < 2000; ++i) {
      e->moveHandTo({0.01 * std::sin(0.01 * i), 0.0, 0.012});
      e->tick();
      free[indexOf(slot)].push_back(e->frame().record.twist);
    }
    REQUIRE(e->frame().record.mode == RenderMode::free);
    // The hand carries the weight for which the renderer does not compensate.
    e->moveHandTo({0.0, 0.0, 0.012});
    run(*e, 3000);
    CHECK(e->frame().record.handWrench[1] == Approx(0.2 * 9.81).epsilon(0.01));
  }
  CHECK(free[0] == free[1]);
}

TEST_CASE("a servo's gain from a file", "[experiment]") {
  const std::string device = test::deviceFile("tau-nominal.toml");
  const test::TemporaryFolder folder;
  const auto write = [&](double period, const Eigen::MatrixXd& gain) {
    std::ofstream file(folder / "servo.json");
    file.precision(17);
    file << "{\"model\": \"tau-nominal.toml\", \"period\": " << period << ", \"K\": ";
    for (int i = 0; i < gain.rows(); ++i)
      for (int j = 0; j < gain.cols(); ++j) file << (j > 0 ? ", " : i > 0 ? "], [" : "[[") << gain(i, j);
    file << "]]}";
    file.close();
    return folder / "servo.json";
  };
  const ServoedDevice softer = loadServoedDevice(device, write(kPeriod, 0.25 * nominal().gain));
  CHECK((softer.gain - 0.25 * nominal().gain).norm() < 1e-14 * nominal().gain.norm());
  const auto stiffness = [](const ServoedDevice& servoed) {
    const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::hold, {}, servoed);
    const TestPush test = testPush(*e);
    REQUIRE(test.verdict == FirstImpactVerdict::measured);
    return test.stiffness;
  };
  CHECK(stiffness(softer) < 0.6 * stiffness(nominal()));

  const auto refused = [&](const std::string& file) -> std::string {
    try {
      loadServoedDevice(device, file);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refused(write(5e-4, nominal().gain)) ==
        folder / "servo.json" + ": period: is 0.0005 s, must be 0.001 s, the period of the viewer");
  CHECK(refused(write(kPeriod, Eigen::MatrixXd::Ones(3, 9))) ==
        folder / "servo.json" + ": K: is for 3 joints, but TAU nominal has 6");
  CHECK(refused("/no/such/servo.json").find("/no/such/servo.json") == 0);
  std::ofstream(folder / "neither.json") << "{\"model\": \"a\", \"period\": 0.001}";
  CHECK(refused(folder / "neither.json") == folder / "neither.json" + ": K: is missing");
  std::ofstream(folder / "old.json") << "{\"kind\": \"surface\", \"model\": \"a\", \"period\": 0.001}";
  CHECK(refused(folder / "old.json") ==
        folder / "old.json" + ": kind: is \"surface\": position control does not need a file any more");
}

namespace {

struct Drag {
  double hand = 0.0, tool = 0.0;  // path along the surface, m
  double deepest = 0.0;           // m
  int contact = 0;                // ticks
};

// Lean on the wall, drag the hand by `way` in `ticks`, and rest.
Drag drag(Experiment& e, const Vec3& lean, const Vec3& way, int ticks) {
  for (int i = 0; i < 600; ++i) {
    e.moveHandTo(Vec3(e.frame().hand.target + (lean - e.frame().hand.target) / (600.0 - i)));
    e.tick();
  }
  run(e, 400);
  Drag result;
  const Vec3 from = e.frame().record.pose.position;
  const auto watch = [&] {
    e.tick();
    REQUIRE(e.frame().plant == Status::ok);
    REQUIRE(e.frame().record.status == Status::ok);
    result.deepest = std::max(result.deepest, -e.frame().record.nearest.gap);
    result.contact += e.frame().record.mode == RenderMode::contact;
  };
  for (int i = 1; i <= ticks; ++i) {
    e.moveHandTo(lean + way * (static_cast<double>(i) / ticks));
    watch();
  }
  for (int i = 0; i < 300; ++i) watch();
  result.hand = way.norm();
  result.tool = (e.frame().record.pose.position - from).norm();
  return result;
}

}  // namespace

TEST_CASE("a tool under position control is dragged along walls and teeth; the paper's law holds it", "[experiment]") {
  struct Case {
    const char* scene;
    Vec3 lean, way;
    double least;  // part of the hand's path that the tool must follow
  };
  // Along the oblique wall: across its normal. Down the corner's edge. On teeth: across the chewing surface.
  const Vec3 normal = Vec3(0.3214, 0.5390, 0.7785).normalized();
  const Vec3 along = Vec3(0.014, -0.008, 0.0) - normal * normal.dot(Vec3(0.014, -0.008, 0.0));
  const Case cases[] = {{"oblique-wall.toml", {0.0, 0.0, -0.012}, along, 0.9},
                        {"corner.toml", {-0.018, 0.0, -0.010}, {0.0, 0.014, 0.0}, 0.9},
                        {"molar.toml", {0.0, 0.0, -0.002}, {0.0, 0.008, 0.0}, 0.8},
                        {"jaw.toml", {0.018, 0.0, -0.009}, {0.0, 0.010, 0.0}, 0.4}};
  for (const Case& c : cases)
    for (const int delay : {0, 3}) {
      INFO(c.scene << " delay " << delay);
      Settings settings;
      settings.delay = {delay, delay};
      const auto e = experiment(shipped(c.scene), RendererSlot::positionControl, settings);
      const Drag slid = drag(*e, c.lean, c.way, 1500);
      WARN(c.scene << ", delay " << delay << ": hand " << 1e3 * slid.hand << " mm, tool " << 1e3 * slid.tool
                   << " mm, deepest " << 1e6 * slid.deepest << " um, in contact " << slid.contact / 18.0 << " %");
      CHECK(slid.tool > c.least * slid.hand);
      CHECK(slid.contact > 1500);
      CHECK(slid.deepest < 5e-5);
      if (delay > 0) continue;
      const auto held = experiment(shipped(c.scene), RendererSlot::hold);
      CHECK(drag(*held, c.lean, 0.3 * c.way, 500).tool < 0.2 * 0.3 * c.way.norm());
    }
}

namespace {

// Does not move; only provides what a chart needs.
class SomeJoints final : public Mechanism {
 public:
  SomeJoints(const JointVector& limits, int chains)
      : Mechanism("some", {limits, JointVector::Ones(limits.size())}), joints_(limits.size()), chains_(chains) {
    setHome();
  }
  Status track(const JointVector&, const JointVector&, bool, Kinematics&) const noexcept override {
    return Status::unreachable;
  }
  Status reach(const Pose&, const Vec6&, bool, Kinematics& kinematics) const noexcept override {
    kinematics.q.setZero(joints_);
    kinematics.inertia.setIdentity(joints_, joints_);
    return Status::ok;
  }
  Status accelerate(const Pose&, const Vec6&, const JointVector&, const Vec6&, Vec6&) const noexcept override {
    return Status::unreachable;
  }
  std::vector<Bar> bars(const Pose&) const override {
    std::vector<Bar> bars;
    for (int i = 0; i < chains_; ++i) bars.push_back({Vec3::Zero(), Vec3::UnitX(), i});
    bars.push_back({Vec3::UnitX(), Vec3::UnitY(), -1});  // the platform
    return bars;
  }

 private:
  Eigen::Index joints_;
  int chains_;
};

std::string strokes(const TorqueStyle& style) {
  std::string text;
  for (int i = 0; i < style.joints; ++i) {
    const unsigned colour = style.colourOf(i);
    text += colour == kJoints[0] ? 'a' : colour == kJoints[1] ? 'b' : 'c';
    if (style.dashed(i)) text += '-';
  }
  return text;
}

}  // namespace

TEST_CASE("charts of any number of joints", "[experiment]") {
  const TorqueStyle tau(*makeMechanism(nominal().parameters));
  CHECK(strokes(tau) == "aa-bb-cc-");
  CHECK_FALSE(tau.shares);
  CHECK(tau.limit == 2.0);
  CHECK(tau.factor == JointVector::Ones(6));
  const TorqueStyle delta(SomeJoints(JointVector::Constant(3, 0.5), 3));
  CHECK(strokes(delta) == "abc");
  CHECK_FALSE(delta.shares);
  CHECK(delta.limit == 0.5);
  // Axes: N and N m need different scales.
  const TorqueStyle axes(SomeJoints(JointVector::Constant(6, 5.0), 0));
  CHECK(strokes(axes) == "abca-b-c-");
  CHECK(axes.shares);
  JointVector limits(7);
  limits << 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 4.0;
  const TorqueStyle arm(SomeJoints(limits, 1));
  CHECK(strokes(arm) == "abca-b-c-a");
  CHECK(arm.shares);
  CHECK(arm.factor[6] * 4.0 == Approx(arm.limit));
}

TEST_CASE("every scene can be touched, and switching renderers in contact keeps the tool", "[experiment]") {
  for (const char* name : {"flat-wall.toml", "oblique-wall.toml", "corner.toml", "box.toml"}) {
    INFO(name);
    const auto e = experiment(shipped(name), RendererSlot::impedance);
    e->moveHandTo({-0.012, -0.006, -0.025});
    run(*e, 1500);
    CHECK(e->frame().contacts.contacts[0].gap < 0.0);
    CHECK(e->frame().record.mode == RenderMode::contact);
    const Vec3 before = e->frame().record.pose.position;
    for (int i = 0; i < 6; ++i) {
      e->select(i % 2 == 0 ? RendererSlot::positionControl : RendererSlot::impedance);
      run(*e, 400);
      CHECK(e->frame().plant == Status::ok);
      CHECK(e->frame().record.status == Status::ok);
      CHECK((e->frame().record.pose.position - before).norm() < 0.01);
    }
  }
}

TEST_CASE("the mechanical stops keep a free tool within reach, whatever the hand does", "[experiment]") {
  const auto e = experiment(shipped("oblique-wall.toml"), RendererSlot::positionControl);
  test::Random random(601);
  double farthest = 0.0;
  for (int i = 0; i < test::count(1000, 5000); ++i) {
    e->moveHandTo(random.vector(0.3));
    if (i % 3 == 0) e->setGrip(i % 2 == 0 ? kPaperGrip : kFirmGrip);
    if (i % 7 == 0) e->select(i % 2 == 0 ? RendererSlot::positionControl : RendererSlot::impedance);
    run(*e, 200);
    farthest = std::max(farthest, e->frame().record.pose.position.cwiseAbs().maxCoeff());
    REQUIRE(e->frame().plant == Status::ok);
  }
  CHECK(farthest > kStop);
  CHECK(farthest < 0.040);
}

TEST_CASE("a bur drills while it spins, stroke by stroke, and what is undone is there again bit for bit",
          "[experiment]") {
  const SceneFile file = tooth();
  const Solid& solid = *file.solids[0];
  const auto uncut = samplesOf(solid);
  const RemovedVolume whole = solid.volume();
  const auto e = experiment(file, RendererSlot::positionControl);
  const DrillState& drilled = e->frame().drilled;
  CHECK(e->frame().record.nearest.gap == Approx(2e-4).epsilon(0.05));
  e->moveHandTo({0.0, 0.0, -5e-3});  // 2 N
  run(*e, 400);
  CHECK(samplesOf(solid) == uncut);
  CHECK(drilled.strokes == 0);

  e->spin(true);
  run(*e, 500);
  const RemovedVolume first = drilled.removed;
  CHECK(first[0] > 0.2e-9);
  CHECK(drilled.spins);
  CHECK(drilled.feed > 1e-4);
  CHECK(drilled.strokes == 1);
  const RemovedVolume left = solid.volume();
  CHECK(whole[0] + whole[1] - left[0] - left[1] == Approx(first[0] + first[1]).epsilon(0.05));
  e->spin(false);
  run(*e, 20);
  const auto after = samplesOf(solid);
  e->spin(true);
  e->spin(false);  // an empty stroke does not count
  CHECK(drilled.strokes == 1);

  e->spin(true);
  std::vector<double> times;
  for (int i = 0; i < 300; ++i) {  // not half way through: restored material pushes the tool out to the nearest side
    const auto begin = std::chrono::steady_clock::now();
    e->tick();
    times.push_back(1e6 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  std::sort(times.begin(), times.end());
  WARN("a period that drills: p50 " << times[150] << " us, p99 " << times[297] << " us");
  CHECK(drilled.removed[1] > 0.1e-9);  // dentine
  CHECK(drilled.strokes == 2);
  e->spin(false);
  e->undo();
  CHECK(samplesOf(solid) == after);
  CHECK(drilled.removed == first);
  e->undo();
  CHECK(samplesOf(solid) == uncut);
  CHECK(drilled.removed == RemovedVolume{});
  CHECK(drilled.strokes == 0);
  e->undo();
  CHECK(samplesOf(solid) == uncut);
  run(*e, 300);  // the tool is inside the restored material
  CHECK(e->frame().plant == Status::ok);
  CHECK(e->frame().record.pose.position.z() > -1e-4);

  e->spin(true);
  run(*e, 200);
  CHECK(drilled.removed[0] > 0.0);
  e->restore();
  CHECK(samplesOf(solid) == uncut);
  CHECK(drilled.removed == RemovedVolume{});
  e->undo();
  CHECK(samplesOf(solid) == uncut);

  const auto other = experiment(shipped("flat-wall.toml"), RendererSlot::positionControl);
  other->spin(true);
  other->undo();
  run(*other, 10);
  CHECK_FALSE(other->frame().drilled.spins);
}

TEST_CASE(
    "the force that is shown is what the motors deliver: never beyond what they allow, and negative where they pull",
    "[experiment]") {
  // A blow on a very stiff spring requires more force than available.
  Settings stiff;
  stiff.spring.stiffness = 1e5;
  const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::impedance, stiff);
  const auto plant = makeMechanism(changed(nominal().parameters, stiff));
  e->moveHandTo({0.0, 0.0, -0.037});
  int beyond = 0;
  for (int i = 0; i < 1500; ++i) {
    e->tick();
    const TickRecord& record = e->frame().record;
    const Delivered force = deliveredOf(record);
    REQUIRE(force.total == Approx(record.rendered.head<3>().norm()));
    REQUIRE(std::hypot(force.normal, force.tangential) == Approx(force.total).margin(1e-9));
    REQUIRE(sampleOf(record).normalForce == force.normal);
    Kinematics k = plant->home();
    REQUIRE(plant->reach(record.pose, Vec6::Zero(), true, k) == Status::ok);
    const double allowed = stiffnessLimit(k, plant->limits().effort, record.nearest.normal, {}).largestForce;
    CHECK(force.normal < 1.01 * allowed);
    beyond += record.normalForce > 1.05 * allowed;  // the renderer's own value
    if (record.normalForce > 1.05 * allowed) CHECK(e->frame().conditions.saturated);
  }
  CHECK(beyond > 0);
  // A hold without release pulls back.
  Settings sticky;
  sticky.hold.release = false;
  const auto hold = experiment(shipped("flat-wall.toml"), RendererSlot::hold, sticky);
  hold->moveHandTo({0.0, 0.0, -0.02});
  run(*hold, 1500);
  CHECK(deliveredOf(hold->frame().record).normal == Approx(8.0).epsilon(0.05));
  hold->moveHandTo({0.0, 0.0, 0.01});
  run(*hold, 1000);
  REQUIRE(hold->frame().holding);
  CHECK(deliveredOf(hold->frame().record).normal == Approx(-4.0).epsilon(0.05));
}

TEST_CASE("the hand does not wind up beyond a mechanical stop, and is back at once", "[experiment]") {
  for (const Grip& grip : {kFirmGrip, kPaperGrip}) {
    const auto e = experiment(shipped("flat-wall.toml"), RendererSlot::positionControl);
    e->setGrip(grip);
    CHECK_FALSE(e->frame().conditions.edge);
    e->moveHandTo({0.0, 0.0, 0.02});
    run(*e, 1000);
    for (int i = 0; i < 3000; ++i) {
      e->moveHandBy({0.0, 0.0, 1e-4});  // a mouse that is dragged 300 mm further
      e->tick();
    }
    const Frame& frame = e->frame();
    CHECK(frame.conditions.edge);
    CHECK(frame.record.pose.position.z() > kStop);
    CHECK(frame.hand.target.z() < kStop + kBeyondStop + 2e-4);
    // 12 mm back have an effect.
    const double at = frame.record.pose.position.z();
    e->moveHandBy({0.0, 0.0, -0.012});
    run(*e, 1000);
    CHECK(e->frame().record.pose.position.z() < at - 0.005);
    CHECK_FALSE(e->frame().conditions.edge);
  }
}

TEST_CASE(
    "conditions: an unstable spring, motors at their limit, a slip on a wall with friction; a quiet press has none",
    "[experiment]") {
  const auto seen = [](Experiment& e, int ticks) {
    Conditions all;
    for (int i = 0; i < ticks; ++i) {
      e.tick();
      const Conditions& c = e.frame().conditions;
      all = {all.saturated || c.saturated, all.unstable || c.unstable, all.slipped || c.slipped, all.edge || c.edge};
    }
    return all;
  };
  const auto quiet = experiment(shipped("flat-wall.toml"), RendererSlot::positionControl);
  const double from = quiet->frame().hand.target.z();
  Conditions none;
  for (int step = 1; step <= 100; ++step) {  // within 1 s
    quiet->moveHandTo({1e-4 * step, 0.0, from + 0.01 * step * (-0.02 - from)});
    const Conditions now = seen(*quiet, step < 100 ? 10 : 1000);
    none = {none.saturated || now.saturated, none.unstable || now.unstable, none.slipped || now.slipped,
            none.edge || now.edge};
  }
  CHECK_FALSE(none.saturated);
  CHECK_FALSE(none.unstable);
  CHECK_FALSE(none.slipped);
  CHECK_FALSE(none.edge);

  Settings stiff;
  stiff.spring.stiffness = 20000.0;
  stiff.delay = {2, 2};
  stiff.toolDamping = 0.0;
  const auto thrown = experiment(shipped("flat-wall.toml"), RendererSlot::impedance, stiff);
  thrown->moveHandTo({0.0, 0.0, -0.02});
  CHECK(seen(*thrown, 1500).unstable);

  SceneFile rough = shipped("flat-wall.toml");
  Scene scene;
  for (Obstacle obstacle : rough.scene.obstacles()) {
    obstacle.material.friction = obstacle.material.slidingFriction = 0.2;
    (void)scene.add(obstacle);
  }
  rough.scene = scene;
  const auto slides = experiment(rough, RendererSlot::positionControl);
  slides->moveHandTo({0.0, 0.0, -0.02});
  CHECK_FALSE(seen(*slides, 1500).slipped);
  slides->moveHandTo({0.02, 0.0, -0.02});
  CHECK(seen(*slides, 500).slipped);
  run(*slides, 3000);
  CHECK_FALSE(slides->frame().conditions.slipped);
}

TEST_CASE("a test push that cannot be made says why; a result keeps its conditions and its limit", "[experiment]") {
  const auto scene = shipped("flat-wall.toml");
  SceneFile far = scene;
  far.scene = flatWall({0.0, 0.0, -0.4}, Vec3::UnitZ());  // out of the device's reach
  const auto reaches = experiment(far, RendererSlot::impedance);
  CHECK(testPush(*reaches).verdict == FirstImpactVerdict::noStep);
  Settings late;
  late.delay = {3, 3};
  const auto chatters = experiment(scene, RendererSlot::impedance, late);
  const TestPush unstable = testPush(*chatters);
  CHECK(unstable.verdict == FirstImpactVerdict::unstable);
  CHECK(unstable.status == Status::stopped);
  CHECK(unstable.amount > 0.0);
  CHECK(chatters->frame().guardTicks[static_cast<std::size_t>(chatters->frame().record.guard)] > 0);

  Settings settings;
  settings.extraMass = 0.05;
  const auto e = experiment(scene, RendererSlot::positionControl, settings);
  const TestPush made = testPush(*e);
  REQUIRE(made.verdict == FirstImpactVerdict::measured);
  CHECK(made.status == Status::ok);
  CHECK(made.settings.extraMass == 0.05);
  CHECK(made.limit > made.stiffness);
  CHECK(made.limit < 1e6);
  // Later and at another place, it is unchanged.
  e->moveHandTo({0.02, 0.02, -0.01});
  run(*e, 1000);
  CHECK(e->frame().tests[indexOf(RendererSlot::positionControl)].limit == made.limit);
  const auto next = experiment(scene, RendererSlot::impedance);
  next->keepTests(e->frame().tests);
  CHECK(next->frame().tests[indexOf(RendererSlot::positionControl)].stiffness == made.stiffness);
}

}  // namespace enamel::viewer::test_experiment
