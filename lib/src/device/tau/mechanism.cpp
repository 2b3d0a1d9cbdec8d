#include "enamel/device/tau/mechanism.hpp"

#include <Eigen/Geometry>

#include "device/limits.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"

namespace enamel {
namespace {

// Fill everything except q, rates and twist.
void evaluate(const TauModel& model, const TauConfiguration& configuration, bool withInertia,
              Kinematics& kinematics) noexcept {
  const Mat6 jacobian = enamel::jacobian(model, configuration);
  kinematics.pose = configuration.pose;
  kinematics.jacobian = jacobian;
  kinematics.inverseTransposed = inverseJacobian(model, configuration).transpose();
  kinematics.gravity = gravityTorque(model, configuration, jacobian);
  if (withInertia)
    kinematics.inertia = massMatrix(model, configuration, jacobian);
  else
    kinematics.inertia.resize(0, 0);
}

}  // namespace

TauMechanism::TauMechanism(const TauParameters& parameters)
    : Mechanism(parameters.name, limitsOf(parameters.motor, parameters.imperfections, 6)),
      model_(makeModel(parameters)) {
  setHome();
}

Status TauMechanism::track(const JointVector& q, const JointVector& rates, bool withInertia,
                           Kinematics& kinematics) const noexcept {
  if (q.size() != 6 || rates.size() != 6 || kinematics.q.size() != 6) return Status::outOfRange;
  if (!rates.allFinite()) return Status::notFinite;
  TauConfiguration configuration;
  // The search reads only the tips. Start with the last ones, moved by the joints' motion since then, to first order.
  const Vec6 moved = kinematics.jacobian.leftCols<6>() * Vec6(q - kinematics.q);
  for (int i = 0; i < 3; ++i) {
    const Vec3 arm = kinematics.pose.rotation * model_.chain[i].platform;
    configuration.chain[i].tip = kinematics.pose.position + arm + moved.head<3>() + moved.tail<3>().cross(arm);
  }
  const Status status = forwardKinematics(model_, q, configuration).status;
  if (status != Status::ok) return status;
  kinematics.q = q;
  kinematics.rates = rates;
  evaluate(model_, configuration, withInertia, kinematics);
  kinematics.twist = kinematics.jacobian.leftCols<6>() * Vec6(rates);
  return Status::ok;
}

Status TauMechanism::reach(const Pose& pose, const Vec6& twist, bool withInertia,
                           Kinematics& kinematics) const noexcept {
  if (!twist.allFinite()) return Status::notFinite;
  TauConfiguration configuration;
  const Status status = inverseKinematics(model_, pose, configuration);
  if (status != Status::ok) return status;
  kinematics.q = jointAngles(configuration);
  kinematics.rates = jointRates(model_, configuration, twist);
  kinematics.twist = twist;
  evaluate(model_, configuration, withInertia, kinematics);
  return Status::ok;
}

Status TauMechanism::accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                Vec6& acceleration) const noexcept {
  if (torque.size() != 6) return Status::outOfRange;
  if (!twist.allFinite() || !torque.allFinite() || !wrench.allFinite()) return Status::notFinite;
  TauConfiguration configuration;
  const Status status = inverseKinematics(model_, pose, configuration);
  if (status == Status::ok) acceleration = forwardDynamics(model_, configuration, twist, Vec6(torque), wrench);
  return status;
}

std::vector<Bar> TauMechanism::bars(const Pose& pose) const {
  TauConfiguration configuration;
  std::vector<Bar> bars;
  if (inverseKinematics(model_, pose, configuration) != Status::ok) return bars;
  for (int i = 0; i < 3; ++i) {
    const ChainConfiguration& c = configuration.chain[i];
    const Vec3 base = model_.chain[i].base, knee = kneePoint(model_.chain[i], c);
    bars.push_back({base, knee, i});
    bars.push_back({knee, c.tip, i});
  }
  for (int i = 0; i < 3; ++i) bars.push_back({configuration.chain[i].tip, configuration.chain[(i + 1) % 3].tip, -1});
  return bars;
}

}  // namespace enamel
