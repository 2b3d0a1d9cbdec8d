// Movable obstacles: the step of a suspension, and ticks in which a tool pushes one.
#include "enamel/render/suspended.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "support/bench.hpp"
#include "support/catch.hpp"

namespace enamel::test_suspended {

namespace {

using test::Bench, test::kTick;

Vec6 both(double linear, double angular) {
  Vec6 v;
  v << linear, linear, linear, angular, angular, angular;
  return v;
}

double energyOf(const Suspension& s, const SuspendedState& state) {
  return 0.5 * (state.velocity.dot(s.inertia.cwiseProduct(state.velocity)) +
                state.offset.dot(s.stiffness.cwiseProduct(state.offset)));
}

// A block of 40 x 40 x 20 mm with its upper face at z = 0 and its suspension in the middle of that face.
Obstacle block(const std::optional<Suspension>& suspension, double friction = 0.0) {
  Obstacle obstacle;
  obstacle.name = "block";
  obstacle.shape = Box{{0.02, 0.02, 0.01}};
  obstacle.pose.position = {0.0, 0.0, -0.01};
  obstacle.material.friction = obstacle.material.slidingFriction = friction;
  if (!suspension) return obstacle;
  Suspension s = *suspension;
  s.centre = {0.0, 0.0, 0.01};
  obstacle.suspension = std::make_shared<const Suspension>(s);
  return obstacle;
}

Suspension sprung(double mass, double stiffness, double ratio) {  // ratio: of the damping
  Suspension s;
  s.inertia = both(mass, 4e-5 * mass);
  s.stiffness = both(stiffness, 1e-4 * stiffness);
  s.damping = 2.0 * ratio * s.inertia.cwiseProduct(s.stiffness).cwiseSqrt();
  return s;
}

Suspension loose(double mass, double damping = 0.0) {
  Suspension s;
  s.inertia = both(mass, 0.0);
  s.damping = both(damping, 0.0);
  return s;
}

}  // namespace

TEST_CASE("suspended: a step keeps momentum and never adds energy to the work of the force", "[suspended]") {
  test::Random random(57);
  for (int i = 0; i < 2000; ++i) {
    const auto any = [&](double low, double high) { return std::pow(10.0, random.uniform(low, high)); };
    Suspension s = loose(any(-4, 1));
    SuspendedState state;
    state.velocity.head<3>() = random.vector(1.0);
    state.wrench.head<3>() = random.vector(20.0);
    const Vec6 before = s.inertia.cwiseProduct(state.velocity), push = state.wrench;
    const double elapsed = any(-4, -2);
    advance(s, elapsed, state);
    const Vec6 change = s.inertia.cwiseProduct(state.velocity) - before - elapsed * push;
    CHECK(change.norm() <= 1e-14 * (before.norm() + elapsed * push.norm()));  // rounding of five operations

    s = sprung(any(-4, 1), any(0, 8), random.uniform(0.0, 1.0));
    state.offset.head<3>() = random.vector(1e-3);
    const SuspendedState was = state;
    advance(s, elapsed, state);
    const double work = was.wrench.dot(state.offset - was.offset);
    CHECK(energyOf(s, state) - energyOf(s, was) - work <= 1e-13 * (energyOf(s, was) + std::abs(work)));
    SuspendedState forced = was;  // the response to a force is the inverse inertia
    forced.wrench.setZero();
    advance(s, elapsed, forced);
    CHECK((freeVelocity(s, was, elapsed) - forced.velocity).norm() == 0.0);
    CHECK((state.velocity - forced.velocity - elapsed * inverseInertia(s, elapsed).cwiseProduct(was.wrench)).norm() <=
          1e-14 * (state.velocity.norm() + forced.velocity.norm()));
  }
}

TEST_CASE("suspended: a pit holds a block as a spring in the step, and takes energy only", "[suspended]") {
  constexpr double kPeriod = 1e-3, kStiff = 1e5;
  test::Random random(572);
  for (int i = 0; i < 300; ++i) {
    Suspension s = sprung(random.uniform(1e-3, 1.0), random.uniform(0.0, 1e5), random.uniform(0.0, 1.0));
    s.inertia.tail<3>().setZero();
    Scene scene;
    scene.add(block(s));
    const Suspension& own = *scene.obstacles()[0].suspension;
    SceneMotion plain(scene), held(scene);
    const Vec3 normal = random.vector(1.0).normalized(), force = 5.0 * random.direction();
    double lost = 0.0, before = 0.0;
    for (int tick = 0; tick < 3; ++tick)  // of the same motion: the last step is held
      for (SceneMotion* motion : {&plain, &held}) {
        (void)motion->follow(scene, tick * kPeriod, kPeriod);
        motion->scaleForces(0.0);
        motion->push(0, Vec3::Zero(), force);  // at the centre
        if (tick == 2 && motion == &held) motion->hold(0, Vec3::Zero(), normal, kStiff, kPeriod);
      }
    before = energyOf(own, *held.suspended(0));
    const Vec3 old = held.suspended(0)->velocity.head<3>(), offset = held.suspended(0)->offset.head<3>();
    const Vec3 pit = held.suspended(0)->wrench.head<3>() - force;
    (void)plain.follow(scene, 3 * kPeriod, kPeriod);
    (void)held.follow(scene, 3 * kPeriod, kPeriod);
    const Vec3 now = held.suspended(0)->velocity.head<3>();
    const Mat3 across = Mat3::Identity() - normal * normal.transpose();
    const double whole = own.inertia[0] + kPeriod * own.damping[0] + kPeriod * kPeriod * own.stiffness[0];
    const Vec3 free = (own.inertia[0] * old + kPeriod * (force - own.stiffness[0] * offset)) / whole;
    CHECK((across * now - across * free * whole / (whole + kPeriod * kPeriod * kStiff)).norm() < 1e-12);
    CHECK(std::abs(normal.dot(now - free)) < 1e-12);
    lost = kPeriod * pit.dot(now);
    CHECK(lost <= 0.0);
    CHECK(energyOf(own, *held.suspended(0)) <= before + kPeriod * force.dot(now) + lost + 1e-15);
  }
}

TEST_CASE("suspended: at rest under a force, the springs carry it; axes without inertia stay", "[suspended]") {
  Suspension s = sprung(2e-3, 5e4, 0.3);
  s.inertia[1] = 0.0;
  SuspendedState state;
  for (int i = 0; i < 2000; ++i) {
    state.wrench << 5.0, 5.0, -2.0, 0.0, 0.0, 0.0;
    advance(s, kTick, state);
  }
  CHECK(state.offset[0] == Approx(5.0 / 5e4).epsilon(1e-12));
  CHECK(state.offset[1] == 0.0);
  CHECK(state.offset[2] == Approx(-2.0 / 5e4).epsilon(1e-12));
}

TEST_CASE("suspended: pose, velocity and contact row of a block agree", "[suspended]") {
  // A rotated block on springs, pushed beside its centre.
  Obstacle obstacle = block(std::nullopt);
  obstacle.pose.rotation = rotationFromVector(Vec3(0.3, -0.2, 0.5));
  Suspension s = sprung(0.2, 400.0, 0.1);
  s.centre = {0.002, -0.004, 0.006};
  obstacle.suspension = std::make_shared<const Suspension>(s);
  Scene scene;
  scene.add(obstacle);
  SceneMotion motion(scene);
  const double T = 1e-5, last = 1e-8;  // s; in the last step the block hardly turns
  for (int i = 0; i < 2000; ++i) {
    motion.scaleForces(0.0);
    motion.push(0, obstacle.pose.position + Vec3(0.01, 0.005, 0.0), {1.0, 2.0, -3.0});
    (void)motion.follow(scene, i * T, T);
  }
  const Obstacle before = motion.scene().obstacles()[0];
  CHECK(angleBetween(before.pose.rotation, obstacle.pose.rotation) > 0.01);
  ContactSnapshot contacts;
  contacts.count = 2;
  for (int i = 0; i < 2; ++i) {
    Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    c.point = before.pose.position + Vec3(0.004, -0.01, 0.003 * i);
    c.normal = Vec3(1.0, 2.0 * i, -1.0).normalized();
    c.obstacle = 0;
  }
  ContactYield yield;
  motion.yieldAt(contacts, last, 1.0, yield);
  REQUIRE(yield.isAny);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 arm = contacts.contacts[i].point - before.pose.position;
    CHECK((yield.velocity[i] - before.twist.head<3>() - before.twist.tail<3>().cross(arm)).norm() < 1e-12);
    CHECK(yield.across[i] >= 0.0);
  }
  CHECK(yield.inverse[0][1] == yield.inverse[1][0]);
  motion.scaleForces(0.0);
  // A force at contact 1 changes the speed at contact 0 by the element of the matrix.
  SceneMotion free = motion;
  motion.push(0, contacts.contacts[1].point, 2.0 * contacts.contacts[1].normal);
  (void)motion.follow(scene, 1.0, last);
  (void)free.follow(scene, 1.0, last);
  const Obstacle& after = motion.scene().obstacles()[0];
  const auto speedAt = [&](const SceneMotion& m) {
    const Obstacle& o = m.scene().obstacles()[0];
    const Vec3 point = o.pose.position + o.pose.rotation * before.pose.rotation.transpose() *
                                             (contacts.contacts[0].point - before.pose.position);
    return contacts.contacts[0].normal.dot(o.twist.head<3>() + o.twist.tail<3>().cross(point - o.pose.position));
  };
  CHECK(speedAt(motion) - speedAt(free) == Approx(2.0 * last * yield.inverse[0][1]).epsilon(1e-5));
  CHECK(speedAt(free) == Approx(contacts.contacts[0].normal.dot(yield.after[0])).epsilon(1e-5));
  // The pose moves by the velocity. Relative to the origin of the frame, the centre turns within the step.
  CHECK((after.pose.position - before.pose.position - last * after.twist.head<3>()).norm() <
        1e-5 * last * after.twist.head<3>().norm());
  CHECK((rotationVector(after.pose.rotation * before.pose.rotation.transpose()) - last * after.twist.tail<3>()).norm() <
        1e-6 * last * after.twist.tail<3>().norm());  // rounding of matrices, 1e-16, over the angle
}

TEST_CASE("suspended: infinite inertia or stiffness is the fixed block", "[suspended]") {
  for (const bool spring : {false, true})
    for (const int delay : {0, 2}) {
      Suspension heavy = loose(1e25), stiff = sprung(1e-3, 1e25, 0.0);
      heavy.inertia.tail<3>().setConstant(1e25);
      Bench fixed({"tau-nominal.toml", kClosedForm, block(std::nullopt, 0.2), delay, spring, true});
      Bench byInertia({"tau-nominal.toml", kClosedForm, block(heavy, 0.2), delay, spring, true});
      Bench byStiffness({"tau-nominal.toml", kClosedForm, block(stiff, 0.2), delay, spring, true});
      double largest = 0.0;
      for (int i = 0; i < 400; ++i) {
        REQUIRE(fixed.press(6.0));
        REQUIRE(byInertia.press(6.0));
        REQUIRE(byStiffness.press(6.0));
        const JointVector& command = fixed.haptics->frame().command;
        REQUIRE((byInertia.haptics->frame().command - command).norm() <= 1e-12 * command.norm());
        REQUIRE((byStiffness.haptics->frame().command - command).norm() <= 1e-12 * command.norm());
        largest = std::max(largest, fixed.force());
      }
      CHECK(largest > 3.0);
    }
}

TEST_CASE("suspended: a tool and a loose block keep their momentum", "[suspended]") {
  for (const bool spring : {false, true})
    for (const int delay : {0, 1, 2})
      for (const double mass : {2e-3, 0.02, 0.2}) {
        Bench bench({"cartesian-3.toml", kClosedForm, block(loose(mass)), delay, spring});
        const double toolMass = 0.045;  // of the device file
        const auto momentum = [&] { return toolMass * bench.tool().twist[2] + mass * bench.state().velocity[2]; };
        double before = 0.0, largest = 0.0;
        for (int i = 0; i < 300; ++i) {  // the hand throws the tool at the block
          REQUIRE(bench.step(
              [](double time, const Pose&, const Vec6&) { return Vec3(0.0, 0.0, time < 0.02 ? -0.3 : 0.0); }));
          if (i == 20) before = momentum();
          largest = std::max(largest, bench.force());
        }
        INFO("mass " << mass << " kg, delay " << delay << (spring ? ", spring" : "") << ", speeds "
                     << bench.tool().twist[2] << " and " << bench.state().velocity[2]);
        CHECK(largest > 0.1);
        CHECK(before == Approx(-0.3 * 0.02).epsilon(0.06));  // with a tick of the force more or less
        CHECK(std::abs(momentum() - before) <= 1e-12 * std::abs(before));
      }
}

TEST_CASE("suspended: the block gets no more energy than the hand gives", "[suspended]") {
  for (const bool spring : {false, true})
    for (const int delay : {0, 1, 2}) {
      if (spring && delay > 0) continue;  // on this light device the spring adds energy also to a fixed wall
      for (const Suspension& s : {sprung(2e-3, 5e4, 0.3), sprung(2e-3, 5e3, 0.0), sprung(0.3, 5e3, 0.0),
                                  sprung(0.02, 500.0, 0.0), loose(0.02), loose(0.2)}) {
        Bench bench({"cartesian-3.toml", kClosedForm, block(s), delay, spring});
        const double toolMass = 0.045;  // of the device file
        const bool isLoose = s.stiffness.isZero(0.0);
        double work = 0.0, largest = 0.0;
        std::vector<double> owns;  // the block is ahead of the tool by the delay
        for (int i = 0; i < (isLoose ? 150 : 600); ++i) {
          const double z = bench.tool().position.z(), push = isLoose   ? (i < 50 ? -0.3 : 0.0)
                                                             : i < 200 ? -0.8 - 0.7 * std::sin(0.2 * i)
                                                                       : -0.2;
          REQUIRE(bench.step([&](double, const Pose&, const Vec6&) { return Vec3(0.0, 0.0, push); }));
          work += push * (bench.tool().position.z() - z);
          const double tool = 0.5 * toolMass * std::pow(bench.tool().twist[2], 2), own = energyOf(s, bench.state());
          owns.push_back(own);
          if (i >= delay)  // rounding: energies are up to 10 mJ
            REQUIRE(owns[static_cast<std::size_t>(i - delay)] + tool <= work + 1e-12);
          largest = std::max(largest, own);
        }
        CHECK(largest > 1e-5);
      }
    }
}

TEST_CASE("suspended: a pressed tooth sinks by force over stiffness", "[suspended]") {
  for (const bool spring : {false, true})
    for (const int delay : {0, 1, 2}) {
      Bench bench({"tau-nominal.toml", kClosedForm, block(sprung(2e-3, 5e4, 0.3)), delay, spring});
      double mean = 0.0, force = 0.0;
      for (int i = 0; i < 1200; ++i) {
        REQUIRE(bench.press(5.0));
        if (i < 700) continue;
        mean -= bench.state().offset[2] / 500.0;
        force += bench.force() / 500.0;
      }
      INFO("delay " << delay << (spring ? ", spring" : ""));
      CHECK(force == Approx(5.0).epsilon(0.01));
      CHECK(mean == Approx(force / 5e4).epsilon(0.02));
    }
}

TEST_CASE("suspended: friction holds the tool on a mobile molar, on a cusp and in a fissure", "[suspended]") {
  const SceneFile file = loadScene(std::string(ENAMEL_SOURCE_DIR) + "/data/scenes/mobile-molar.toml");
  for (const auto& [onCusp, isMobile] : {std::pair(false, true), {true, true}, {false, false}, {true, false}}) {
    Bench::Setting setting{"tau-nominal.toml", kClosedForm, file.scene.obstacles()[0], 0, false, true};
    if (!isMobile) setting.obstacle.suspension = nullptr;
    setting.tool = file.tool;
    setting.start = onCusp ? Vec3(1.11e-3, -1.727e-3, 4.66e-3) : Vec3(0.0, 0.0, 4e-3);
    const Vec3 push = onCusp ? Vec3(0.29, -0.44, -0.85) : Vec3(0.0, 0.0, -1.0);
    Bench bench(setting);
    Vec3 place = Vec3::Zero();
    double largest = 0.0;
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(bench.step([&](double, const Pose&, const Vec6& twist) {
        return Vec3((i < 300 ? 1.0 : 4.0) * push - 3.0 * twist.head<3>());
      }));
      if (i == 500) place = bench.tool().position;
      if (i > 500) largest = std::max(largest, (bench.tool().position - place).norm());
    }
    CHECK(bench.haptics->frame().output.mode == RenderMode::contact);
    CHECK(largest < 2e-5);  // m, in half a second, of the chatter
  }
}

TEST_CASE("suspended: a saved motion continues bit for bit", "[suspended]") {
  Scene scene;
  scene.add(block(sprung(0.01, 500.0, 0.1)));
  SceneMotion motion(scene), copy(scene);
  const auto run = [&](SceneMotion& m, int from) {
    for (int i = from; i < from + 50; ++i) {
      m.scaleForces(0.0);
      m.push(0, {0.01, 0.0, 0.0}, {0.1 * std::sin(i), 0.2, -1.0});
      m.push(0, Vec6(Vec6::Constant(1e-5)));
      (void)m.follow(scene, kTick * i, kTick);
    }
  };
  run(motion, 0);
  std::vector<double> state(motion.stateSize());
  motion.saveState(state.data());
  copy.loadState(state.data());
  run(motion, 50);
  run(copy, 50);
  CHECK(motion.suspended(0)->offset == copy.suspended(0)->offset);
  CHECK(motion.suspended(0)->velocity == copy.suspended(0)->velocity);
  CHECK(motion.scene().obstacles()[0].pose.position == copy.scene().obstacles()[0].pose.position);
  CHECK(!motion.suspended(0)->offset.isZero(0.0));
  state[3] = std::nan("");
  copy.loadState(state.data());
  CHECK(copy.suspended(0)->offset.isZero(0.0));
  motion.reset(scene);
  CHECK(motion.suspended(0)->velocity.isZero(0.0));
  CHECK(motion.scene().obstacles()[0].pose.position == scene.obstacles()[0].pose.position);
}

TEST_CASE("suspended: stable on imperfect devices at every delay", "[suspended]") {
  struct Case {
    const char* name;
    Suspension suspension;
  };
  const Case cases[] = {{"tooth", sprung(2e-3, 5e4, 0.3)},       {"tooth without damping", sprung(2e-3, 5e4, 0.0)},
                        {"loose tooth", sprung(2e-3, 5e3, 0.2)}, {"jaw", sprung(0.3, 5e3, 0.3)},
                        {"soft", sprung(0.01, 500.0, 0.1)},      {"fragment", loose(0.02, 300.0)}};
  for (const test::BenchDevice& device : test::kBenchDevices)
    for (const int delay : {0, 1, 2}) {
      const auto run = [&](const std::optional<Suspension>& suspension) {
        return test::holdAfterPress(device, block(suspension, 0.2), delay, 600);
      };
      const test::HeldForce rigid = run(std::nullopt);
      for (const Case& c : cases) {
        INFO(device.file << ", delay " << delay << ", " << c.name);
        const auto [change, force] = run(c.suspension);
        // An unstable loop swings between zero and the largest force.
        CHECK(change <= std::max(rigid.change, 0.5 * device.force));
        CHECK(std::abs(force - rigid.force) < 0.1 * device.force);
      }
    }
}

}  // namespace enamel::test_suspended
