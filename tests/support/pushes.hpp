// Renderers and pushes as the tests use them.
#pragma once

#include <vector>

#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/surface_servo.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/push.hpp"
#include "support/devices.hpp"
#include "support/reference.hpp"

namespace enamel::test {

/// The gain of data/reference/servo-nominal.json: designed for the nominal device at 1 ms.
inline ServoGain referenceGain() {
  static const nlohmann::json servo = referenceFile("servo-nominal.json");
  return matrixFrom(servo.at("K"));
}

inline PositionControlRenderer positionControl(const PositionControlOptions& options = {}) {
  return {referenceGain(), 1e-3, options};
}

/// The surface servo for a mechanism with a delay of `low` to `high` ticks.
inline SurfaceServoRenderer surfaceServo(const Mechanism& mechanism, int low = 0, int high = 0) {
  return SurfaceServoRenderer(surfaceServoFor(mechanism.limits().count, 1e-3, low, high));
}

inline PositionControlOptions asInThePaper() {
  PositionControlOptions options;
  options.release = false;
  return options;
}

/// The plant of the impedance scenarios: 4 N s/m of mechanical damping on the TCP along z.
inline TauParameters dampedNominal() {
  TauParameters device = nominal();
  device.platform.damping[2] = 4.0;
  return device;
}

/// The push of one row of data/reference/runs-nominal.json.
inline PushSetup referenceSetup(const nlohmann::json& run) {
  PushSetup setup;
  setup.person.force = run.at("force");
  setup.person.noise = 0.0;
  setup.person.guide = false;
  setup.duration = run.at("duration");
  return setup;
}

/// A hand that draws the TCP to (0, 0, z), m, and keeps the orientation: N/m, N s/m.
inline auto handAt(double z, double stiffness, double damping) {
  return [=](double, const Pose& pose, const Vec6& twist) {
    Vec6 wrench;
    wrench.head<3>() = -stiffness * (pose.position - Vec3(0.0, 0.0, z)) - damping * twist.head<3>();
    wrench.tail<3>() = holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
    return wrench;
  };
}

inline std::vector<TickRecord> recordPush(const Mechanism& plant, Renderer& renderer, const PushSetup& setup) {
  std::vector<TickRecord> ticks;
  const PushResult result = runPush(plant, renderer, setup, [&ticks](const TickRecord& t) { ticks.push_back(t); });
  if (result.status != Status::ok) throw Error(std::string("the plant became ") + toString(result.status));
  return ticks;
}

/// A frame at a pose that a renderer accepts, with the TCP's contact with the wall z = 0.
inline TickFrame frameAt(const Mechanism& mechanism, const Pose& pose, double time, const Vec6& twist = Vec6::Zero()) {
  TickFrame frame;
  frame.time = time;
  if (mechanism.reach(pose, twist, true, frame.kinematics) != Status::ok) throw Error("pose outside the workspace");
  frame.contacts.contacts[0] = nearestContact(flatWall(), Tool(), pose, nullptr);
  frame.contacts.count = 1;
  frame.maxTorque = mechanism.limits().torque;
  frame.applied = frame.kinematics.gravity;
  if (fillContactRows(frame) != Status::ok) throw Error("the inertia is not positive definite");
  return frame;
}

inline Pose poseAtDepth(double depth) {
  Pose pose;
  pose.position.z() = -depth;
  return pose;
}

}  // namespace enamel::test
