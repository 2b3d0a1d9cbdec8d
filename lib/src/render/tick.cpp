#include "enamel/render/tick.hpp"

namespace enamel {

HapticTick::HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer,
                       const GuardOptions& guard, const Pose& start)
    : mechanism_(mechanism),
      scene_(scene),
      tool_(tool),
      renderer_(renderer),
      guard_(mechanism, guard),
      track_(makeToolTrack(scene, tool)) {
  if (!isRotation(start.rotation) || mechanism.reach(start, Vec6::Zero(), false, input_.kinematics) != Status::ok)
    input_.kinematics = mechanism.home();
  input_.maxTorque = guard.on ? guard.torque : mechanism.limits().torque;
  output_.torque.setZero(mechanism.joints());
  renderer.activate(guard.period);
}

Status HapticTick::operator()(const Measurement& measurement, Command& command) noexcept {
  Status status = see(measurement);
  if (status == Status::ok) {
    status = renderer_.step(input_, output_);
  } else {
    output_ = TickOutput{};
    output_.torque.setZero(mechanism_.joints());
  }
  const bool touches = status == Status::ok && input_.contacts.count > 0;
  const GuardedCommand guarded =
      guard_.step(measurement, input_.kinematics, output_.torque, status,
                  touches ? input_.contacts.contacts[0].obstacleVelocity : Vec3(Vec3::Zero()));
  last_ = command.torque = guarded.torque;
  reason_ = guarded.reason;
  const bool stopped = guard_.fault() != GuardReason::none;
  if (guard_.options().on && !stopped && !guard_.engaged()) renderer_.reset();
  return status != Status::ok ? status : stopped ? Status::stopped : Status::ok;
}

void HapticTick::reset() noexcept {
  guard_.reset();
  renderer_.reset();
}

Status HapticTick::see(const Measurement& measurement) noexcept {
  const Status status = mechanism_.track(measurement.q, measurement.rates, renderer_.needsInertia(), input_.kinematics);
  if (status != Status::ok) return status;
  input_.time = measurement.time;
  input_.applied = measurement.applied;
  // Where the device cannot tell, the renderer takes its own answer for what acted, unless the guard changed it.
  if (input_.applied.size() == 0 && reason_ != GuardReason::none) input_.applied = last_;
  return followContacts(scene_, tool_, input_.kinematics.pose, kContactMargin, track_, input_.contacts);
}

}  // namespace enamel
