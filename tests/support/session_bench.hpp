// A session in a loop of the test, on a virtual device, under a hand that pushes along -z.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "enamel/session/session.hpp"
#include "enamel/sim/hand.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/meshes.hpp"

namespace enamel::test {

inline Vec6 pushing(double force, const Pose& start, const Pose& pose, const Vec6& twist) {
  Vec6 wrench = guidingWrench(pose, twist, start, Vec3::UnitZ());
  wrench[2] -= force + 3.0 * twist[2];
  return wrench;
}

inline SessionObstacle wallAt(const std::string& name, double z) {
  SessionObstacle wall;
  static_cast<Obstacle&>(wall) = halfSpace(name, {0.0, 0.0, z}, Vec3::UnitZ());
  return wall;
}

inline SessionObstacle ball(const std::string& name, const Vec3& centre, double radius) {
  SessionObstacle ball;
  ball.name = name;
  ball.shape = Sphere{radius};
  ball.pose.position = centre;
  return ball;
}

inline SessionDef definition() {
  SessionDef def;
  def.start.emplace();
  def.start->position.z() = 0.5e-3;
  return def;
}

// A session in an own loop on a virtual device, under a hand that pushes along -z. The device's frame may differ.
struct Bench {
  explicit Bench(const SessionDef& def) : session(def), device(session.mechanism(), setupOf(session)) {}
  static VirtualDeviceSetup setupOf(const Session& session) {
    VirtualDeviceSetup setup;
    setup.start = session.start();
    setup.encoders = {true, RateSource::lowPass};
    return setup;
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      Measurement measurement;
      REQUIRE(device.measure(measurement) == Status::ok);
      measurement.buttons = buttons;
      status = session.tick(measurement, command);
      const Vec3 wrench = session.snapshot().wrench.head<3>();
      sum += wrench;
      if (last.allFinite()) largestJump = std::max(largestJump, (wrench - last).norm());
      last = wrench;
      REQUIRE(device.actuate(command) == Status::ok);
      REQUIRE(device.advance([this](double, const Pose& pose, const Vec6& twist) -> Vec6 {
        return hand ? hand(pose, twist) : pushing(force, session.start(), pose, twist);
      }) == Status::ok);
    }
  }
  double depth() const { return -device.state().position.z(); }
  // Run, and return the mean of the rendered force.
  Vec3 meanForce(int ticks) {
    sum.setZero();
    run(ticks);
    return sum / ticks;
  }

  Session session;
  VirtualDevice device;
  Command command;
  Status status = Status::ok;
  double force = 4.0;  // N
  std::uint32_t buttons = 0;
  std::function<Vec6(const Pose&, const Vec6&)> hand;
  Vec3 sum = Vec3::Zero();  // of the rendered forces, N
  Vec3 last = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  double largestJump = 0.0;  // of the rendered force between two ticks, N
};

inline std::vector<SessionEvent> eventsOf(Session& session, EventKind kind) {
  std::vector<SessionEvent> found;
  for (SessionEvent event; session.nextEvent(event);)
    if (event.kind == kind) found.push_back(event);
  return found;
}

inline std::shared_ptr<const Solid> cube() {
  const MeshModel surface(test::boxMesh(Vec3::Constant(4e-3)));
  return std::make_shared<const Solid>(surface, std::vector<SolidLayer>{{"stuff", Material{}, 0.2e9, 0.0, nullptr}},
                                       SolidOptions{2e-4, 64});
}

/// Run one tick of a session on its virtual device, under a hand that pushes along -z with `force`, N.
inline void tickOnce(Session& session, VirtualDevice& device, double force) {
  Measurement measurement;
  Command command;
  REQUIRE(device.measure(measurement) == Status::ok);
  (void)session.tick(measurement, command);
  REQUIRE(device.actuate(command) == Status::ok);
  REQUIRE(device.advance([&, start = session.start()](double, const Pose& pose, const Vec6& twist) {
    return pushing(force, start, pose, twist);
  }) == Status::ok);
}

// Two sessions with burs 5 mm above one cube.
struct TwoBurs {
  explicit TwoBurs(const Vec3& startOfSecond) {
    SessionDef def = definition();
    def.start->position.z() = 5e-3;
    def.tool.emplace().parts[0].radius = 1e-3;
    def.bur = Bur{0, 0.5, 2000.0};
    first = std::make_shared<Session>(def);
    tooth.name = "tooth";
    tooth.solid = cube();
    id = first->add(tooth);
    def.sharesWith = first;
    def.start->position = startOfSecond;
    definitionOfSecond = def;
    second = std::make_unique<Session>(def);
    a = std::make_unique<VirtualDevice>(first->mechanism(), Bench::setupOf(*first));
    b = std::make_unique<VirtualDevice>(second->mechanism(), Bench::setupOf(*second));
  }

  SessionObstacle tooth;
  ObstacleId id;
  SessionDef definitionOfSecond;
  std::shared_ptr<Session> first;
  std::unique_ptr<Session> second;
  std::unique_ptr<VirtualDevice> a, b;
};

// A thread that adds, removes, moves, replaces and edits obstacles of a session at random, every half millisecond.
class RandomChanges {
 public:
  RandomChanges(Session& session, std::uint64_t seed, std::chrono::duration<double> length)
      : session_(session), seed_(seed), random_(seed), thread_([this, length] { run(length); }) {}
  ~RandomChanges() {
    if (thread_.joinable()) thread_.join();
  }
  RandomChanges(const RandomChanges&) = delete;
  RandomChanges& operator=(const RandomChanges&) = delete;

  // Return the number of changes, and of those that threw, after the last one.
  std::pair<int, int> finish() {
    thread_.join();
    return {changes_, failures_};
  }

 private:
  void run(std::chrono::duration<double> length) {
    constexpr int kFewest = 30;  // also on a busy machine
    const auto end = std::chrono::steady_clock::now() + length;
    SessionObstacle edited = ball("edited " + std::to_string(seed_), {0.02, 0.0, 0.02}, 1e-3);
    edited.mesh = std::make_shared<MeshModel>(boxMesh(Vec3::Constant(1e-3)));
    deforms_ = session_.add(edited);
    for (; changes_ < kFewest || std::chrono::steady_clock::now() < end; ++changes_) {
      try {
        change(changes_);
        (void)session_.snapshot();
      } catch (const Error&) {
        ++failures_;
      }
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  }
  void change(int i) {
    const double what = random_.uniform(0.0, 7.0);
    const Vec3 place = Vec3(0.02, 0.0, 0.0) + random_.vector(0.01);
    if (mine_.size() < 4 || what < 1.0) {
      SessionObstacle obstacle = ball(std::to_string(seed_) + " " + std::to_string(i), place, 2e-3);
      if (what < 0.5) obstacle.mesh = std::make_shared<MeshModel>(boxMesh(Vec3::Constant(1e-3)));
      mine_.push_back(session_.add(obstacle));
    } else if (what < 2.0) {
      session_.remove(mine_.back());
      mine_.pop_back();
    } else if (what < 4.0) {
      session_.move(mine_[static_cast<std::size_t>(i) % mine_.size()], Pose{place, Mat3::Identity()});
    } else if (what < 4.5) {
      session_.activate(mine_[0], i % 2 == 0);
    } else if (what < 5.0) {
      Material soft;
      soft.stiffness = 2000.0;
      session_.setMaterial(mine_[0], soft);
    } else if (what < 6.0) {
      session_.replace(mine_[0], ball("", place, 1e-3));
    } else {
      session_.moveVertices(deforms_, {i % 8}, {random_.vector(1e-3)});
    }
  }

  Session& session_;
  std::uint64_t seed_;
  Random random_;
  ObstacleId deforms_;
  std::vector<ObstacleId> mine_;
  int changes_ = 0, failures_ = 0;
  std::thread thread_;  // the last member: it uses the others
};

// A hand in another thread than the test. It presses the tool along -z with 1 N, or lifts it back to its start.
class PressingHand {
 public:
  explicit PressingHand(const Pose& start) : start_(start) {}
  void lift(bool lifts) { *lifts_ = lifts; }
  WrenchFunction wrench() const {
    return [start = start_, lifts = lifts_](double, const Pose& pose, const Vec6& twist) {
      constexpr double kForce = 1.0, kDamping = 5.0, kPull = 200.0;  // N, N s/m, N/m
      Vec6 wrench = guidingWrench(pose, twist, start, Vec3::UnitZ());
      const double up = kPull * (start.position.z() - pose.position.z());
      wrench[2] += (*lifts ? std::clamp(up, -kForce, kForce) : -kForce) - kDamping * twist[2];
      return wrench;
    };
  }

 private:
  Pose start_;
  std::shared_ptr<std::atomic<bool>> lifts_ = std::make_shared<std::atomic<bool>>(false);
};

// Result of watch().
struct Watched {
  int lateStops = 0;         // stops of the guard after periods without a tick or a sample: the machine was busy
  std::string otherReasons;  // of stops without such periods
  double pressed = 0.0;      // share of the snapshots with a rendered contact
};

// Watch a running session. After each stop of the guard the hand lifts the tool off the wall and resets the guard. A
// late tick holds a torque too long, so that the guard may stop for energy or speed too.
inline Watched watch(Session& session, PressingHand& hand, std::chrono::duration<double> length) {
  Watched watched;
  double snapshots = 0.0, pressed = 0.0;
  std::uint64_t before = 0;  // periods without a tick or a sample, at the last reset
  const auto pause = [] { std::this_thread::sleep_for(std::chrono::milliseconds(5)); };
  const auto end = std::chrono::steady_clock::now() + length;
  do {
    pause();
    ++snapshots;
    const std::vector<SessionEvent> stops = eventsOf(session, EventKind::guardStop);
    Snapshot now = session.snapshot();
    pressed += now.fault == GuardReason::none && now.tick.mode != RenderMode::free;
    for (const SessionEvent& stop : stops) {
      if (now.missed + now.held > before)
        ++watched.lateStops;
      else
        watched.otherReasons += std::string(toString(stop.reason)) + " at " + std::to_string(stop.time) + " s; ";
      hand.lift(true);
      for (; now.tick.pose.position.z() <= 0.0; now = session.snapshot()) pause();
      session.reset();
      before = now.missed + now.held;
      hand.lift(false);
    }
  } while (std::chrono::steady_clock::now() < end);
  watched.pressed = pressed / snapshots;
  return watched;
}

inline std::shared_ptr<const Solid> cutSolidOf(const Session& session) {
  return std::get<std::shared_ptr<const Solid>>(session.haptics().scene().scene().obstacles()[0].shape);
}

}  // namespace enamel::test
