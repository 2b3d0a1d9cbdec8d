#include "enamel/sim/hand.hpp"

namespace enamel {
namespace {

constexpr double kTurnStiffness = 0.5, kTurnDamping = 0.014;  // N m/rad, N m s/rad

}  // namespace

Vec3 holdingMoment(const Mat3& rotation, const Mat3& start, const Vec3& omega) noexcept {
  const Mat3 turned = rotation.lazyProduct(start.transpose());
  return -(kTurnStiffness * rotationVector(turned) + kTurnDamping * omega);
}

}  // namespace enamel
