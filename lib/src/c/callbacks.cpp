// Mechanisms that a host implements in C.
#include <cmath>

#include "c/convert.hpp"
#include "core/message.hpp"
#include "device/inertia.hpp"

namespace enamel::c {
namespace {

JointLimits limitsOf(const EnamelMechanism& m) {
  require(isKnown(m), "EnamelMechanism.size is " + std::to_string(m.size) + ", must be " + std::to_string(sizeof m));
  require(m.joints >= 1 && m.joints <= kMaxJoints,
          "EnamelMechanism.joints is " + std::to_string(m.joints) + ", must be in 1 to " + std::to_string(kMaxJoints));
  require(m.track != nullptr && m.reach != nullptr, "EnamelMechanism needs track and reach");
  JointLimits limits;
  enamel::fromPlain(m.max_torque, m.joints, limits.effort);
  enamel::fromPlain(m.encoder_step, m.joints, limits.encoderStep);
  for (int i = 0; i < m.joints; ++i) {
    const std::string joint = "EnamelMechanism: joint " + std::to_string(i);
    require(limits.effort[i] >= 0.0 && std::isfinite(limits.effort[i]),
            joint + " has a largest torque of " + formatNumber(limits.effort[i]) + ", must be at least 0 and finite");
    require(limits.encoderStep[i] > 0.0 && std::isfinite(limits.encoderStep[i]),
            joint + " has an encoder step of " + formatNumber(limits.encoderStep[i]) + ", must be above 0");
  }
  return limits;
}

class OwnMechanism final : public Mechanism {
 public:
  explicit OwnMechanism(const EnamelMechanism& m)
      : Mechanism(m.name == nullptr ? "own mechanism" : m.name, limitsOf(m)), callbacks_(m) {
    setHome();
  }

  Status track(const JointVector& q, const JointVector& rates, bool, Kinematics& kinematics) const noexcept override {
    const int n = callbacks_.joints;
    if (q.size() != n || rates.size() != n) return Status::outOfRange;
    if (!q.allFinite() || !rates.allFinite()) return Status::notFinite;
    EnamelKinematics state{};
    toPlain(kinematics, state);
    return take(callbacks_.track(callbacks_.user, q.data(), rates.data(), &state), state, kinematics);
  }

  Status reach(const Pose& pose, const Vec6& twist, bool, Kinematics& kinematics) const noexcept override {
    if (!pose.position.allFinite() || !pose.rotation.allFinite() || !twist.allFinite()) return Status::notFinite;
    EnamelPose plain;
    toPlain(pose, plain.position, plain.rotation);
    EnamelKinematics state{};
    return take(callbacks_.reach(callbacks_.user, &plain, twist.data(), &state), state, kinematics);
  }

  // V' = J M^-1 (tau - g + J^T F) + J' q', with J' as a central difference. Coriolis forces of the joints and friction
  // are left out.
  Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                    Vec6& acceleration) const noexcept override {
    constexpr double kStep = 1e-5;  // s
    if (torque.size() != callbacks_.joints) return Status::outOfRange;
    Kinematics now;
    if (const Status status = reach(pose, twist, true, now); status != Status::ok) return status;
    JointVector joints = torque - now.gravity + torqueOf(now.jacobian, wrench);
    Cholesky<kMaxJoints> inertia;
    if (!factorInertia(now.inertia, inertia)) return Status::singular;
    inertia.solve(joints.data());
    acceleration = enamel::twistOf(now.jacobian, joints);
    if (now.rates.isZero(0.0)) return Status::ok;
    Kinematics before = now, after = now;
    for (const auto& [time, state] : {std::pair<double, Kinematics*>{-kStep, &before}, {kStep, &after}})
      if (const Status status = track(now.q + time * now.rates, now.rates, false, *state); status != Status::ok)
        return status;
    acceleration +=
        (enamel::twistOf(after.jacobian, now.rates) - enamel::twistOf(before.jacobian, now.rates)) / (2.0 * kStep);
    return Status::ok;
  }

  std::vector<Bar> bars(const Pose&) const override { return {}; }

 private:
  Status take(std::int32_t result, const EnamelKinematics& state, Kinematics& kinematics) const noexcept {
    if (result != ENAMEL_OK) return statusOf(result);
    Kinematics next;
    fromPlain(state, callbacks_.joints, true, next);
    if (!next.pose.position.allFinite() || !isRotation(next.pose.rotation) || !next.twist.allFinite() ||
        !next.q.allFinite() || !next.jacobian.allFinite() || !next.inverseTransposed.allFinite() ||
        !next.gravity.allFinite() || !next.inertia.allFinite())
      return Status::notFinite;
    kinematics = next;
    return Status::ok;
  }

  EnamelMechanism callbacks_;
};

}  // namespace

std::shared_ptr<const Mechanism> makeMechanism(const EnamelMechanism& mechanism) {
  return std::make_shared<const OwnMechanism>(mechanism);
}

}  // namespace enamel::c
