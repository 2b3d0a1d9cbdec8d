// A session in a loop of the test, on a virtual device, under a hand that pushes along -z.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "enamel/session/session.hpp"
#include "enamel/sim/hand.hpp"
#include "support/catch.hpp"
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

}  // namespace enamel::test
