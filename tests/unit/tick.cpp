// A haptic tick stage by stage: each fills its own part of the frame, and nothing is computed twice.
#include "enamel/render/tick.hpp"

#include "enamel/collision/solid.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/pushes.hpp"

namespace enamel::test_tick {

namespace {

constexpr double kPeriod = 1e-3;

const TauMechanism& tau() {
  static const TauMechanism mechanism(test::nominal());
  return mechanism;
}

// Requests what it is told to, and keeps its input.
class Recorder final : public Renderer {
 public:
  explicit Recorder(bool inertia) : inertia_(inertia) {}
  bool needsInertia() const noexcept override { return inertia_; }
  double push = 0.0;  // along z, N
  Status answer = Status::ok;
  TickFrame seen;

 private:
  void prepare(double) override {}
  Status render(const TickFrame& frame, TickOutput& output) noexcept override {
    seen = frame;
    output.torque = staticTorque(frame.kinematics, (Vec6() << 0.0, 0.0, push, 0.0, 0.0, 0.0).finished());
    output.mode = RenderMode::contact;
    output.normalForce = push;
    return answer;
  }
  void resetState() noexcept override {}
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  bool inertia_;
};

Measurement sampleAt(const Pose& pose, double time, const Vec6& twist = Vec6::Zero()) {
  Kinematics k;
  REQUIRE(tau().reach(pose, twist, false, k) == Status::ok);
  Measurement m;
  m.time = time;
  m.q = k.q;
  m.rates = k.rates;
  return m;
}

}  // namespace

TEST_CASE("sense: pose, twist and gravity of the sample; the inertia only where a renderer asks for it", "[tick]") {
  const Scene wall = flatWall();
  const Pose pose = test::poseAtDepth(1e-4);
  const Vec6 twist = (Vec6() << 0.01, 0.0, -0.02, 0.1, 0.0, 0.0).finished();
  Kinematics truth;
  REQUIRE(tau().reach(pose, twist, true, truth) == Status::ok);
  for (const bool inertia : {false, true}) {
    Recorder renderer(inertia);
    HapticTick tick(tau(), wall, Tool(), renderer, kPeriod);
    Command command;
    Measurement m = sampleAt(pose, 0.5, twist);
    m.applied = truth.gravity;
    REQUIRE(tick(m, command) == Status::ok);
    const TickFrame& frame = renderer.seen;
    CHECK(frame.time == 0.5);
    CHECK(frame.age == 0);
    CHECK(frame.kinematics.q == m.q);
    CHECK((frame.kinematics.pose.position - pose.position).norm() < 1e-11);
    CHECK((frame.kinematics.twist - twist).norm() < 1e-9);
    CHECK(frame.applied == m.applied);
    CHECK(frame.maxTorque == tau().limits().effort);
    CHECK(frame.kinematics.inertia.rows() == (inertia ? 6 : 0));
    CHECK(frame.rows.count == (inertia ? 1 : -1));
    CHECK(tick.frame().output.torque == command.effort);
    CHECK(tick.frame().command == command.effort);
    Measurement lost = m;
    lost.time += kPeriod;
    lost.age = 1;  // no sample: the torque that acted before the last sample is not reported again
    REQUIRE(tick(lost, command) == Status::ok);
    CHECK(frame.kinematics.q == m.q);
    CHECK_FALSE(frame.applied);
  }
}

TEST_CASE("sense: after a sample that came late, the next one may be lost, late or in time", "[tick]") {
  const Scene wall = flatWall();
  for (const int lostAfter : {0, 1, 2}) {
    Recorder renderer(false);
    HapticTick tick(tau(), wall, Tool(), renderer, kPeriod);
    Command command;
    const auto give = [&](double periods, int age) {
      Measurement m = sampleAt(test::poseAtDepth(1e-4), periods * kPeriod);
      m.age = age;
      INFO(lostAfter << ": " << periods << " " << age);
      const double before = tick.frame().time;
      CHECK(tick(m, command) == Status::ok);
      CHECK(tick.frame().time > before);
    };
    give(1.0, 0);
    give(2.0, 1);  // two lost samples: the prediction is at 3 periods
    give(3.0, 2);
    give(1.5, 0);  // they come late
    for (int age = 1; age <= lostAfter; ++age) give(1.5 + age, age);
    give(2.5, 0);
    give(6.0, 0);
    CHECK(tick.guard().fault() == GuardReason::none);
  }
}

TEST_CASE("find contacts: at the pose of the tick, and where obstacles are now", "[tick]") {
  Scene scene = flatWall();
  Recorder renderer(false);
  HapticTick tick(tau(), scene, Tool(), renderer, kPeriod);
  Command command;
  REQUIRE(tick(sampleAt(test::poseAtDepth(2e-4), kPeriod), command) == Status::ok);
  REQUIRE(renderer.seen.contacts.count == 1);
  CHECK(renderer.seen.contacts.contacts[0].gap == Approx(-2e-4).epsilon(1e-9));
  Pose moved = scene.obstacles()[0].pose;
  moved.position.z() -= 5e-4;
  REQUIRE(scene.move(0, moved, Vec6::Zero()) == Status::ok);
  REQUIRE(tick(sampleAt(test::poseAtDepth(2e-4), 2.0 * kPeriod), command) == Status::ok);
  REQUIRE(renderer.seen.contacts.count == 1);
  CHECK(renderer.seen.contacts.contacts[0].gap == Approx(-2e-4 + 5e-4 / 120.0).epsilon(1e-9));  // it begins to glide
  moved.position.z() -= 5e-3;  // new at every tick: it is at its pose
  REQUIRE(scene.move(0, moved, Vec6::Zero()) == Status::ok);
  REQUIRE(tick(sampleAt(test::poseAtDepth(2e-4), 3.0 * kPeriod), command) == Status::ok);
  CHECK(renderer.seen.contacts.count == 0);
}

TEST_CASE("render and guard: what was requested and what reaches the motors are both in the frame", "[tick]") {
  const Scene wall = flatWall();
  GuardOptions limits = guardFor(tau(), kPeriod);
  limits.force = 2.0;
  Recorder renderer(false);
  HapticTick tick(tau(), wall, Tool(), renderer, limits);
  Command command;
  double time = 0.0;
  const auto next = [&] { return tick(sampleAt(test::poseAtDepth(1e-4), time += kPeriod), command); };
  REQUIRE(next() == Status::ok);
  CHECK(tick.frame().reason == GuardReason::none);
  renderer.push = 5.0;
  REQUIRE(next() == Status::ok);
  const TickFrame& frame = tick.frame();
  CHECK(frame.reason == GuardReason::force);
  const Kinematics& k = frame.kinematics;
  CHECK(wrenchOf(k, frame.output.torque - k.gravity)[2] == Approx(5.0).epsilon(1e-9));
  CHECK(wrenchOf(k, frame.command - k.gravity)[2] == Approx(2.0).epsilon(1e-9));
  renderer.answer = Status::notConverged;
  CHECK(next() == Status::notConverged);
  CHECK(frame.reason == GuardReason::renderer);
  CHECK(frame.output.torque.isZero(0.0));
  CHECK(next() == Status::notConverged);
  renderer.answer = Status::ok;
  CHECK(next() == Status::stopped);  // latched
  tick.reset();
  renderer.push = 0.0;
  CHECK(next() == Status::ok);
}

TEST_CASE("cut: the last stage, with the force of the tick", "[tick]") {
  const auto solid = std::make_shared<Solid>(MeshModel(test::boxMesh(Vec3(3e-3, 3e-3, 2e-3))),
                                             std::vector<SolidLayer>{{"enamel", {}, 3e9, 0.0, nullptr}});
  Scene scene;
  Pose place;
  place.position.z() = -2e-3;
  scene.add({"tooth", std::shared_ptr<const Solid>(solid), place, Vec6::Zero(), {}});
  Tool ball;
  ball.parts[0].radius = 0.5e-3;
  Drill drill(ball, {solid}, {0, 0.35, 2000.0});
  drill.spin(true);
  Recorder renderer(false);
  HapticTick tick(tau(), scene, ball, renderer, kPeriod);
  tick.attach(&drill);
  Command command;
  Pose pose;
  pose.position.z() = 0.5e-3 - 2e-5;
  const double whole = solid->volume()[0];
  double volume = whole;
  double time = 0.0;
  const auto next = [&] {
    REQUIRE(tick(sampleAt(pose, time += kPeriod), command) == Status::ok);
    return drill.removed()[0];
  };
  CHECK(next() == 0.0);  // in contact, but not pressed
  renderer.push = 2.0;
  double removed = 0.0;
  for (int i = 0; i < 20; ++i) removed += next();
  volume = solid->volume()[0];
  CHECK(removed > 0.0);
  CHECK(1e9 * (whole - volume) == Approx(1e9 * removed).epsilon(0.2));  // mm^3; about ten samples
  Measurement lost = sampleAt(pose, time += kPeriod);
  lost.age = 1;
  REQUIRE(tick(lost, command) == Status::ok);
  CHECK(solid->volume()[0] == volume);  // nothing is cut while the tool's position is unknown
  renderer.answer = Status::notConverged;
  (void)tick(sampleAt(pose, time += kPeriod), command);
  renderer.answer = Status::ok;
  for (int i = 0; i < 50; ++i) {  // the guard stopped the loop, so the tool sinks in
    pose.position.z() -= 2e-5;
    REQUIRE(tick(sampleAt(pose, time += kPeriod), command) == Status::stopped);
  }
  CHECK(tick.frame().contacts.count > 0);
  CHECK(solid->volume()[0] == volume);
}

TEST_CASE("guard: only obstacles that carry the force excuse its work", "[tick]") {
  // The tool is pushed up with 5 N while it moves up at 20 mm/s, between a wall below and one above.
  const auto reason = [](const Vec3& below, const Vec3& above) {
    Guard guard(tau(), guardFor(tau(), kPeriod));
    for (int i = 0; i < 1000; ++i) {
      Pose pose;
      pose.position.z() = -0.01 + 2e-5 * i;
      TickFrame frame;
      frame.kinematics = tau().home();
      REQUIRE(tau().reach(pose, Vec6::Zero(), false, frame.kinematics) == Status::ok);
      Measurement m;
      m.time = kPeriod * i;
      m.q = frame.kinematics.q;
      m.rates = JointVector::Zero(6);
      const double push = std::min(5.0, 0.05 * i);
      frame.output.torque = staticTorque(frame.kinematics, (Vec6() << 0.0, 0.0, push, 0.0, 0.0, 0.0).finished());
      frame.contacts.count = 2;
      frame.contacts.contacts[0].normal = -Vec3::UnitZ();  // the deepest
      frame.contacts.contacts[0].obstacleVelocity = above;
      frame.contacts.contacts[1].obstacleVelocity = below;
      guard.step(m, Status::ok, frame);
      if (isFault(frame.reason)) return frame.reason;
    }
    return GuardReason::none;
  };
  const Vec3 rises(0.0, 0.0, 0.02), rests = Vec3::Zero();
  CHECK(reason(rests, rests) == GuardReason::energy);
  CHECK(reason(rises, rests) == GuardReason::none);
  CHECK(reason(rests, rises) == GuardReason::energy);  // the wall above cannot push up
}

}  // namespace enamel::test_tick
