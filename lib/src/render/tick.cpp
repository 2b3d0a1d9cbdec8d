#include "enamel/render/tick.hpp"

namespace enamel {

HapticTick::HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer,
                       double period, const Pose& start)
    : mechanism_(mechanism), scene_(scene), tool_(tool), renderer_(renderer), track_(makeToolTrack(scene, tool)) {
  if (mechanism.reach(start, Vec6::Zero(), false, input_.kinematics) != Status::ok)
    input_.kinematics = mechanism.home();
  input_.maxTorque = mechanism.limits().torque;
  output_.torque.setZero(mechanism.joints());
  renderer.activate(period);
}

Status HapticTick::operator()(const Measurement& measurement, Command& command) noexcept {
  Status status = see(measurement);
  if (status == Status::ok) {
    status = renderer_.step(input_, output_);
  } else {
    output_ = TickOutput{};
    output_.torque.setZero(mechanism_.joints());
  }
  command.torque = output_.torque;
  return status;
}

Status HapticTick::see(const Measurement& measurement) noexcept {
  const Status status = mechanism_.track(measurement.q, measurement.rates, renderer_.needsInertia(), input_.kinematics);
  if (status != Status::ok) return status;
  input_.time = measurement.time;
  input_.applied = measurement.applied;
  return followContacts(scene_, tool_, input_.kinematics.pose, kContactMargin, track_, input_.contacts);
}

}  // namespace enamel
