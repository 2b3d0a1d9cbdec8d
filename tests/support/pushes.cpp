#include "support/pushes.hpp"

namespace enamel::test {

ServoGain referenceGain() {
  static const ServoGain gain = referenceServo("K");
  return gain;
}

HoldRenderer holdRenderer(const HoldOptions& options) { return {referenceGain(), 1e-3, options}; }

PositionControlRenderer positionControl(const Mechanism& mechanism, int low, int high) {
  return PositionControlRenderer(positionControlFor(mechanism, 1e-3, low, high));
}

HoldOptions asInThePaper() {
  HoldOptions options;
  options.release = false;
  return options;
}

TauParameters dampedNominal() {
  TauParameters device = nominal();
  device.platform.damping[2] = 4.0;
  return device;
}

PushSetup referenceSetup(const ReferenceRun& run) {
  PushSetup setup;
  setup.hand.force = run.force;
  setup.hand.noise = 0.0;
  setup.hand.guide = false;
  setup.duration = run.duration;
  return setup;
}

WrenchFunction handAt(double z, double stiffness, double damping) {
  return [=](double, const Pose& pose, const Vec6& twist) {
    Vec6 wrench;
    wrench.head<3>() = -stiffness * (pose.position - Vec3(0.0, 0.0, z)) - damping * twist.head<3>();
    wrench.tail<3>() = holdingMoment(pose.rotation, Mat3::Identity(), twist.tail<3>());
    return wrench;
  };
}

std::vector<TickRecord> recordPush(const Mechanism& plant, Renderer& renderer, const PushSetup& setup) {
  std::vector<TickRecord> ticks;
  const PushResult result = runPush(plant, renderer, setup, [&ticks](const TickRecord& t) { ticks.push_back(t); });
  if (result.status != Status::ok) throw Error(std::string("the plant became ") + toString(result.status));
  return ticks;
}

TickFrame frameAt(const Mechanism& mechanism, const Pose& pose, double time, const Vec6& twist) {
  TickFrame frame;
  frame.time = time;
  if (mechanism.reach(pose, twist, true, frame.kinematics) != Status::ok) throw Error("pose outside the workspace");
  frame.contacts.contacts[0] = nearestContact(flatWall(), Tool(), pose, nullptr);
  frame.contacts.count = 1;
  frame.maxTorque = mechanism.limits().effort;
  frame.applied = frame.kinematics.gravity;
  if (fillContactRows(frame) != Status::ok) throw Error("the inertia is not positive definite");
  return frame;
}

Pose poseAtDepth(double depth) {
  Pose pose;
  pose.position.z() = -depth;
  return pose;
}

}  // namespace enamel::test
