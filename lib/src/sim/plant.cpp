#include "enamel/sim/plant.hpp"

namespace enamel {

Status Plant::rest(const Pose& pose, Kinematics& kinematics) noexcept {
  const Status status = mechanism_.reach(pose, Vec6::Zero(), false, kinematics);
  if (status != Status::ok) return status;
  state_ = DeviceState();
  state_.position = pose.position;
  state_.orientation = pose.rotation;
  return Status::ok;
}

bool isWithinSpeedLimits(const DeviceState& state) noexcept {
  return state.twist.head<3>().norm() <= kMaxPlantSpeed && state.twist.tail<3>().norm() <= kMaxPlantTurnRate;
}

Status ClosedFormPlant::start(const Pose& pose) noexcept {
  Kinematics kinematics;
  return rest(pose, kinematics);
}

Status ClosedFormPlant::advance(double time, double duration, const JointVector& torque,
                                const ExternalWrench& load) noexcept {
  const double step = duration / substeps_;
  DeviceState state = state_;
  for (int i = 0; i < substeps_; ++i) {
    if (const Status s = stepMotion(integrator_, mechanism(), time + i * step, step, torque, load, state);
        s != Status::ok)
      return s;
    if (!isWithinSpeedLimits(state)) return Status::outOfRange;
  }
  state_ = state;
  return Status::ok;
}

}  // namespace enamel
