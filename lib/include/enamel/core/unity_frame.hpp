// Conversion between the frame of Enamel and that of Unity. Enamel's frame is right-handed with z towards the user,
// Unity's is left-handed with z away from the user. Both have x to the right and y up.
#pragma once

#include <Eigen/Geometry>

#include "enamel/core/types.hpp"

namespace enamel {

/// Convert a point, direction, velocity or force. The function is its own inverse. Realtime: yes.
inline Vec3 mirrorUnity(const Vec3& vector) noexcept { return {vector.x(), vector.y(), -vector.z()}; }

/// Convert a moment or an angular velocity, whose sign depends on the handedness. The function is its own inverse.
/// Realtime: yes.
inline Vec3 mirrorUnityTurn(const Vec3& vector) noexcept { return {-vector.x(), -vector.y(), vector.z()}; }

/// Return the rotation matrix of a unit quaternion of Unity. The quaternion need not be exactly normalised. Realtime:
/// yes.
inline Mat3 rotationFromUnity(const Eigen::Quaterniond& unity) noexcept {
  return Eigen::Quaterniond(unity.w(), -unity.x(), -unity.y(), unity.z()).normalized().toRotationMatrix();
}

/// Return the quaternion of Unity for a rotation matrix, with w >= 0. Realtime: yes.
inline Eigen::Quaterniond rotationToUnity(const Mat3& rotation) noexcept {
  const Eigen::Quaterniond q(rotation);
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return Eigen::Quaterniond(sign * q.w(), -sign * q.x(), -sign * q.y(), sign * q.z());
}

}  // namespace enamel
