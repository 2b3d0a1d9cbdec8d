#include "enamel/device/delta/mechanism.hpp"

#include <cmath>

#include "device/limits.hpp"
#include "device/translation.hpp"
#include "enamel/device/delta/dynamics.hpp"
#include "enamel/device/delta/kinematics.hpp"

namespace enamel {
namespace {

// Fill everything except q, rates and twist.
void evaluate(const DeltaModel& model, const DeltaConfiguration& configuration, bool withInertia,
              Kinematics& kinematics) noexcept {
  const Mat3 j = jacobian(configuration);
  kinematics.pose.position = configuration.position;
  kinematics.pose.rotation.setIdentity();
  kinematics.jacobian.setZero(6, 3);
  kinematics.jacobian.topRows<3>() = j;
  kinematics.inverseTransposed.setZero(6, 3);
  for (int i = 0; i < 3; ++i) kinematics.inverseTransposed.col(i).head<3>() = configuration.leg[i].row;
  kinematics.gravity = j.transpose().lazyProduct(gravityForce(model, configuration));
  if (!withInertia) {
    kinematics.inertia.resize(0, 0);
    return;
  }
  const Mat3 half = taskInertia(model, configuration).lazyProduct(j);
  const Mat3 m = j.transpose().lazyProduct(half);
  kinematics.inertia = 0.5 * (m + m.transpose());
}

}  // namespace

DeltaMechanism::DeltaMechanism(const DeltaParameters& parameters)
    : Mechanism(parameters.name, limitsOf(parameters.motor, parameters.imperfections, 3)),
      model_(makeModel(parameters)),
      geometry_(parameters.geometry),
      spacing_(parameters.bar.spacing) {
  setHome();
}

Status DeltaMechanism::track(const JointVector& q, const JointVector& rates, bool withInertia,
                             Kinematics& kinematics) const noexcept {
  if (q.size() != 3 || rates.size() != 3) return Status::outOfRange;
  if (!rates.allFinite()) return Status::notFinite;
  DeltaConfiguration configuration;
  configuration.position = kinematics.pose.position;
  const Status status = forwardKinematics(model_, q, configuration);
  if (status != Status::ok) return status;
  kinematics.q = q;
  kinematics.rates = rates;
  evaluate(model_, configuration, withInertia, kinematics);
  kinematics.twist = twistOf(kinematics.jacobian, rates);
  return Status::ok;
}

Status DeltaMechanism::reach(const Pose& pose, const Vec6& twist, bool withInertia,
                             Kinematics& kinematics) const noexcept {
  Status status = requireTranslation(pose, twist);
  DeltaConfiguration configuration;
  if (status == Status::ok) status = inverseKinematics(model_, pose.position, configuration);
  if (status != Status::ok) return status;
  kinematics.q = jointAngles(configuration);
  kinematics.rates.resize(3);
  for (int i = 0; i < 3; ++i) kinematics.rates[i] = configuration.leg[i].row.dot(twist.head<3>());
  kinematics.twist << twist.head<3>(), Vec3::Zero();
  evaluate(model_, configuration, withInertia, kinematics);
  return Status::ok;
}

Status DeltaMechanism::accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) const noexcept {
  if (torque.size() != 3) return Status::outOfRange;
  if (!torque.allFinite() || !wrench.allFinite()) return Status::notFinite;
  Status status = requireTranslation(pose, twist);
  DeltaConfiguration configuration;
  if (status == Status::ok) status = inverseKinematics(model_, pose.position, configuration);
  if (status != Status::ok) return status;
  const Vec3 velocity = twist.head<3>(), force = wrench.head<3>();
  acceleration << forwardDynamics(model_, configuration, velocity, Vec3(torque), force), Vec3::Zero();
  return Status::ok;
}

std::vector<Bar> DeltaMechanism::bars(const Pose& pose) const {
  DeltaConfiguration configuration;
  std::vector<Bar> bars;
  if (requireTranslation(pose, Vec6::Zero()) != Status::ok ||
      inverseKinematics(model_, pose.position, configuration) != Status::ok)
    return bars;
  const DeltaGeometry& g = geometry_;
  std::array<Vec3, 3> platform;
  for (int i = 0; i < 3; ++i) {
    const DeltaLeg& leg = configuration.leg[i];
    const Vec3 u(model_.cosPhi[i], model_.sinPhi[i], 0.0), v(-model_.sinPhi[i], model_.cosPhi[i], 0.0);
    const Vec3 base = g.r * u + g.s * v - model_.homeDistance * Vec3::UnitZ();
    const Vec3 elbow = base + g.a * (leg.cos1 * u + leg.sin1 * Vec3::UnitZ());
    const Vec3 lower = leg.cos2 * u + leg.sin2 * Vec3::UnitZ(), half = 0.5 * spacing_ * v;
    platform[i] = pose.position + g.c * u + g.f * v;
    const Vec3 near = elbow + g.e * lower, far = platform[i] - g.d * lower;
    bars.push_back({base, elbow, i});
    bars.push_back({near - half, near + half, i});
    bars.push_back({near - half, far - half, i});
    bars.push_back({near + half, far + half, i});
    bars.push_back({far - half, far + half, i});
  }
  for (int i = 0; i < 3; ++i) bars.push_back({platform[i], platform[(i + 1) % 3], -1});
  return bars;
}

}  // namespace enamel
