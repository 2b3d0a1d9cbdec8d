#include "enamel/sim/hand.hpp"

namespace enamel {
namespace {

constexpr double kTurnStiffness = 0.5, kTurnDamping = 0.014;  // N m/rad, N m s/rad

}  // namespace

Vec3 holdingMoment(const Mat3& rotation, const Mat3& start, const Vec3& omega) noexcept {
  const Mat3 turned = rotation.lazyProduct(start.transpose());
  return -(kTurnStiffness * rotationVector(turned) + kTurnDamping * omega);
}

Vec6 guidingWrench(const Pose& pose, const Vec6& twist, const Pose& start, const Vec3& normal) noexcept {
  const Vec3 pull =
      kGuideGrip.stiffness * (pose.position - start.position) + kGuideGrip.damping * Vec3(twist.head<3>());
  Vec6 wrench;
  wrench << normal.dot(pull) * normal - pull, holdingMoment(pose.rotation, start.rotation, twist.tail<3>());
  return wrench;
}

}  // namespace enamel
