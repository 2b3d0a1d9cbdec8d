// Vectors, poses and conventions of the whole library.
//
// Units are SI. World frame W: x right, y up, z from the wall towards the user, origin at the centre of the workspace.
// Platform frame P has its origin at the tool centre point (TCP) and equals W at the home pose.
// A twist is [v; w] and a wrench is [f; m], both at the TCP and in the axes of W.
#pragma once

#include <Eigen/Core>

namespace enamel {

using Vec3 = Eigen::Matrix<double, 3, 1>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat3 = Eigen::Matrix<double, 3, 3>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Largest number of joints of a mechanism.
inline constexpr int kMaxJoints = 7;

/// Largest valid torque or force, N m or N. Larger values are rejected as invalid.
inline constexpr double kLargestTorque = 1e6;

/// One number per joint: rad, rad/s, N m (rotation) or m, m/s, N (translation). Up to kMaxJoints, stored in place.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// n x n matrix of the joints, stored in place.
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;
/// 6 x n Jacobian: V = J q', tau = J^T F. Stored in place.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// Pose of the platform frame P in the world frame W.
struct Pose {
  Vec3 position = Vec3::Zero();      ///< TCP in W, m
  Mat3 rotation = Mat3::Identity();  ///< axes of P in W (orthonormal, right-handed)
};

/// Return the rotation matrix of Euler angles (alpha, beta, gamma), rad: R = Rz(gamma) Ry(beta) Rx(alpha).
/// Realtime: yes.
Mat3 rotationFromEuler(const Vec3& eulerXyz) noexcept;

/// Return the Euler angles (alpha, beta, gamma), rad, of a rotation matrix, with beta in [-pi/2, pi/2]. At beta =
/// +-pi/2 only alpha -+ gamma is defined, and alpha is reported as 0. Realtime: yes.
Vec3 eulerFromRotation(const Mat3& rotation) noexcept;

/// Return true if a matrix is a rotation: finite, orthonormal within 1e-6, right-handed. Realtime: yes.
bool isRotation(const Mat3& matrix) noexcept;

/// Return the angle between two orientations, rad, in [0, pi]; accurate for small angles. Realtime: yes.
double angleBetween(const Mat3& a, const Mat3& b) noexcept;

/// Return the rotation matrix of a rotation vector (axis times angle, rad). Realtime: yes.
Mat3 rotationFromVector(const Vec3& vector) noexcept;

/// Return the rotation vector of a rotation matrix, rad; accurate for angles below 3 rad. Realtime: yes.
Vec3 rotationVector(const Mat3& rotation) noexcept;

/// Return the matrix of the cross product: crossMatrix(a) b = a x b. Realtime: yes.
inline Mat3 crossMatrix(const Vec3& a) noexcept {
  Mat3 m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

}  // namespace enamel
