// The viewer's experiment without a picture: hand, test push, commands, and the haptic thread. Run under the thread
// sanitizer too (preset tsan).
#include "experiment.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "enamel/device/tau/dynamics.hpp"
#include "runner.hpp"
#include "servo_gain.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::viewer::test_experiment {

namespace {

const ServoedDevice& nominal() {
  static const ServoedDevice device = loadServoedDevice(test::deviceFile("tau-nominal.toml"));
  return device;
}

SceneFile shipped(const std::string& name) { return loadScene(ENAMEL_SOURCE_DIR "/data/scenes/" + name); }

Hand handAt(const Vec3& position) {
  Hand hand;
  hand.target = hand.position = position;
  return hand;
}

std::unique_ptr<Experiment> experiment(const SceneFile& scene, Wall wall, const Settings& settings = {}) {
  Pose start;
  start.position = scene.start;
  return std::make_unique<Experiment>(nominal(), settings, scene, start, handAt(scene.start), wall);
}

void run(Experiment& e, int ticks) {
  for (int i = 0; i < ticks; ++i) e.tick();
}

}  // namespace

TEST_CASE("the tool stops at the wall, the hand goes on, and the force is the hand's spring", "[experiment]") {
  for (const Wall wall : {Wall::positionControl, Wall::impedance}) {
    const auto e = experiment(shipped("flat-wall.toml"), wall);
    e->moveHandTo({0.0, 0.0, -0.025});
    run(*e, 2000);
    const Frame& frame = e->frame();
    REQUIRE(frame.plant == Status::ok);
    // At rest the hand's force 400 N/m times its stretch is the wall's.
    const double depth = -frame.record.nearest.gap;
    const double force = 400.0 * (0.025 - depth);
    CHECK(frame.hand.position.z() == Approx(-0.025).epsilon(1e-3));
    CHECK(-frame.record.person[2] == Approx(force).epsilon(1e-3));
    CHECK(frame.record.normalForce == Approx(force).epsilon(1e-2));
    if (wall == Wall::impedance)
      CHECK(depth == Approx(force / 6000.0).epsilon(1e-2));
    else
      CHECK(std::abs(depth) < 1e-5);  // the integrators bring the tool back to the surface
    CHECK(frame.holding == (wall == Wall::positionControl));
  }
}

TEST_CASE("the hand's force is bounded, and it does not wind up", "[experiment]") {
  const auto e = experiment(shipped("flat-wall.toml"), Wall::impedance);
  for (int i = 0; i < 2000; ++i) {
    e->moveHandTo({0.0, 0.0, -0.5});
    e->tick();
  }
  CHECK(-e->frame().record.person[2] == Approx(kLargestHandForce).epsilon(1e-2));
  CHECK(e->frame().hand.target.z() > -0.05);
  // A change of grip leaves the force as it is.
  const double before = e->frame().record.person[2];
  e->setGrip(kPaperGrip);
  e->tick();
  CHECK(e->frame().record.person[2] == Approx(before).epsilon(0.02));
  CHECK(e->frame().hand.position.z() < -0.3);  // 15 N at 40 N/m
}

TEST_CASE("a test push measures what the specification says", "[experiment]") {
  // Without the tool's mechanical damping the servo reaches 20 to 30 kN/m; the spring 3 to 4 kN/m with it.
  Settings undamped;
  undamped.toolDamping = 0.0;
  const auto servo = experiment(shipped("flat-wall.toml"), Wall::positionControl, undamped);
  const auto spring = experiment(shipped("flat-wall.toml"), Wall::impedance);
  for (Experiment* e : {servo.get(), spring.get()}) {
    e->startTestPush();
    run(*e, 1);
    CHECK(e->frame().testing);
    run(*e, 4000);
    CHECK_FALSE(e->frame().testing);
  }
  const TestPush& a = servo->frame().tests[0];
  const TestPush& b = spring->frame().tests[1];
  REQUIRE(a.valid);
  REQUIRE(b.valid);
  CHECK_FALSE(servo->frame().tests[1].valid);
  CHECK(a.stiffness > 20e3);
  CHECK(a.stiffness < 32e3);
  CHECK(b.stiffness > 3.0e3);
  CHECK(b.stiffness < 6.0e3);
  CHECK(a.force == Approx(kTestForce).epsilon(0.05));
  CHECK(a.stiffness == Approx(a.force / a.depth));
  CHECK(a.preload == Approx(0.5).epsilon(0.1));
}

TEST_CASE("the physical limit at home is that of the specification", "[experiment]") {
  const TauModel model = makeModel(nominal().parameters);
  const double expected[] = {421e3, 106e3, 47e3, 26e3};
  for (int d = 0; d < 4; ++d)
    CHECK(stiffnessLimit(model, model.home, Vec3::UnitZ(), 15.0, 0.0, d).stiffness ==
          Approx(expected[d]).epsilon(0.03));  // three digits are published
  const StiffnessLimit limit = stiffnessLimit(model, model.home, Vec3::UnitZ(), 15.0, 0.0, 0);
  CHECK(limit.mass == Approx(0.273).epsilon(0.01));
  // F_max really is the largest: there, and no further, every motor is within its limit.
  Vec6 push = Vec6::Zero();
  push[2] = limit.largestForce;
  CHECK(staticTorque(model, model.home, push).cwiseAbs().maxCoeff() == Approx(model.maxTorque).epsilon(1e-12));
  CHECK(stiffnessLimit(model, model.home, Vec3::UnitZ(), limit.largestForce + 1.0, 0.0, 0).stiffness == 0.0);
}

TEST_CASE("every scene can be touched, and switching walls in contact keeps the tool", "[experiment]") {
  for (const char* name : {"flat-wall.toml", "oblique-wall.toml", "corner.toml", "box.toml"}) {
    INFO(name);
    const auto e = experiment(shipped(name), Wall::impedance);
    e->moveHandTo({-0.012, -0.006, -0.025});
    run(*e, 1500);
    CHECK(e->frame().contacts.contacts[0].gap < 0.0);
    CHECK(e->frame().record.mode == RenderMode::contact);
    const Vec3 before = e->frame().record.pose.position;
    for (int i = 0; i < 6; ++i) {
      e->select(i % 2 == 0 ? Wall::positionControl : Wall::impedance);
      run(*e, 400);
      CHECK(e->frame().plant == Status::ok);
      CHECK(e->frame().record.status == Status::ok);
      CHECK((e->frame().record.pose.position - before).norm() < 0.01);
    }
  }
}

TEST_CASE("the mechanical stops keep a free tool within reach, whatever the hand does", "[experiment]") {
  const auto e = experiment(shipped("oblique-wall.toml"), Wall::positionControl);
  test::Random random(601);
  double farthest = 0.0;
  for (int i = 0; i < test::count(1000, 5000); ++i) {
    e->moveHandTo(random.vector(0.3));
    if (i % 3 == 0) e->setGrip(i % 2 == 0 ? kPaperGrip : kFirmGrip);
    if (i % 7 == 0) e->select(i % 2 == 0 ? Wall::positionControl : Wall::impedance);
    run(*e, 200);
    farthest = std::max(farthest, e->frame().record.pose.position.cwiseAbs().maxCoeff());
    REQUIRE(e->frame().plant == Status::ok);
  }
  CHECK(farthest > kStop);
  CHECK(farthest < 0.040);
}

TEST_CASE("the runner: pause, single ticks, slow motion, replacement", "[experiment]") {
  Runner runner(experiment(shipped("flat-wall.toml"), Wall::positionControl));
  const auto periods = [&runner](int count) {
    for (int i = 0; i < count; ++i) runner.period();
    int samples = 0;
    for (Sample sample; runner.nextSample(sample);) ++samples;
    return samples;
  };
  CHECK(periods(100) == 100);
  Command command{Command::Kind::slowdown};
  command.number = 10;
  runner.send(command);
  CHECK(periods(100) == 10);
  runner.send({Command::Kind::pause});
  CHECK(periods(100) == 0);
  CHECK(runner.frame().paused);
  command = {Command::Kind::step};
  command.number = 3;
  runner.send(command);
  CHECK(periods(100) == 3);
  command = {Command::Kind::slowdown};
  command.number = 1000;
  runner.send(command);
  runner.send({Command::Kind::resume});
  CHECK(periods(3000) == 3);
  CHECK(runner.frame().slowdown == 1000);
  command.number = 1;
  runner.send(command);
  runner.replace(experiment(shipped("box.toml"), Wall::impedance));
  CHECK(periods(10) == 10);
  runner.collect();
  CHECK(runner.frame().wall == Wall::impedance);
  CHECK(runner.frame().record.tick == 9);
  // A queue that nobody reads fills up and says so; a replacement that found no room is dropped, not leaked.
  while (runner.send({Command::Kind::pause})) continue;
  runner.replace(experiment(shipped("box.toml"), Wall::impedance));
  // Samples that nobody reads are dropped and counted.
  runner.period();
  runner.send({Command::Kind::resume});
  for (int i = 0; i < 10000; ++i) runner.period();
  CHECK(runner.frame().droppedSamples > 0);
}

TEST_CASE("the same commands on simulated time give the same bits", "[experiment]") {
  std::vector<Vec6> runs[2];
  for (auto& run : runs) {
    Settings settings;
    settings.noise = 0.5;
    settings.delay = {0, 3};
    Runner runner(experiment(shipped("corner.toml"), Wall::impedance, settings));
    Command command{Command::Kind::handTo};
    command.target = {-0.02, 0.0, -0.02};
    runner.send(command);
    for (int i = 0; i < 1000; ++i) {
      runner.period();
      run.push_back(runner.frame().record.twist);
    }
  }
  CHECK(runs[0] == runs[1]);
}

TEST_CASE("beside a haptic thread: random commands, no sample lost or out of order", "[experiment]") {
  Runner runner(experiment(shipped("flat-wall.toml"), Wall::positionControl));
  test::Random random(602);
  std::uint64_t samples = 0, frames = 0;
  {
    const PeriodicThread haptics(kPeriod, [&runner] { runner.period(); });
    const int rounds = std::max(150, test::count(300, 30000));
    for (int i = 0; i < rounds; ++i) {
      Command command{Command::Kind::handTo};
      switch (static_cast<int>(random.uniform(0.0, 6.0))) {
        case 0: command.target = random.vector(0.03); break;
        case 1:
          command.kind = Command::Kind::select;
          command.number = i % 2;
          break;
        case 2: command.kind = i % 2 == 0 ? Command::Kind::pause : Command::Kind::resume; break;
        case 3:
          command.kind = Command::Kind::slowdown;
          command.number = i % 2 == 0 ? 1 : 5;
          break;
        case 4: command.kind = Command::Kind::testPush; break;
        default:
          runner.replace(experiment(shipped("box.toml"), i % 2 == 0 ? Wall::impedance : Wall::positionControl));
          continue;
      }
      runner.send(command);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      runner.collect();
      const Frame& frame = runner.frame();
      frames += frame.record.pose.position.allFinite();
      CHECK(frame.plant == Status::ok);
      for (Sample sample; runner.nextSample(sample);) {
        ++samples;
        REQUIRE(sample.torque.cwiseAbs().maxCoeff() <= 2.0);
      }
    }
  }
  CHECK(samples > 50);
  CHECK(frames > 50);
  CHECK(runner.frame().droppedSamples == 0);
}

}  // namespace enamel::viewer::test_experiment
