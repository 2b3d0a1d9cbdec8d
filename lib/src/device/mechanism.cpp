#include "enamel/device/mechanism.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/assert.hpp"
#include "device/inertia.hpp"
#include "enamel/core/error.hpp"

namespace enamel {

// Sum column by column, so that the order of summation does not depend on the alignment of a vector.

Vec6 twistOf(const Jacobian& jacobian, const JointVector& rates) noexcept {
  Vec6 twist = Vec6::Zero();
  for (int i = 0; i < jacobian.cols(); ++i) twist += jacobian.col(i) * rates[i];
  return twist;
}

JointVector torqueOf(const Jacobian& jacobian, const Vec6& wrench) noexcept {
  JointVector torque(jacobian.cols());
  for (int i = 0; i < jacobian.cols(); ++i) torque[i] = jacobian.col(i).dot(wrench);
  return torque;
}

JointVector staticTorque(const Kinematics& kinematics, const Vec6& wrench) noexcept {
  return kinematics.gravity + torqueOf(kinematics.jacobian, wrench);
}

Vec6 wrenchOf(const Kinematics& kinematics, const JointVector& torque) noexcept {
  return twistOf(kinematics.inverseTransposed, torque);
}

double effectiveMass(const Kinematics& kinematics, const Vec3& point, const Vec3& direction) noexcept {
  Vec6 push;
  push << direction, (point - kinematics.pose.position).cross(direction);
  const JointVector b = torqueOf(kinematics.jacobian, push);
  ENAMEL_ASSERT(kinematics.inertia.rows() == b.size());
  Cholesky<kMaxJoints> inertia;
  if (!factorInertia(kinematics.inertia, inertia)) return std::numeric_limits<double>::quiet_NaN();
  JointVector acceleration = b;
  inertia.solve(acceleration.data());
  return 1.0 / b.dot(acceleration);
}

double largestForce(const Kinematics& kinematics, const JointVector& maxTorque, const Vec3& point,
                    const Vec3& direction) noexcept {
  Vec6 push;
  push << direction, (point - kinematics.pose.position).cross(direction);
  const JointVector torquePerForce = torqueOf(kinematics.jacobian, push);
  double force = std::numeric_limits<double>::infinity();
  for (int i = 0; i < torquePerForce.size(); ++i) {
    const double left = maxTorque[i] - std::copysign(1.0, torquePerForce[i]) * kinematics.gravity[i];
    if (torquePerForce[i] != 0.0 && maxTorque[i] > 0.0) force = std::min(force, left / std::abs(torquePerForce[i]));
  }
  return force;
}

Vec3 eigenvaluesOf(const Mat3& matrix) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3>(matrix, Eigen::EigenvaluesOnly).eigenvalues();
}

JointVector eigenvaluesOf(const JointMatrix& matrix, JointMatrix& axes) noexcept {
  const Eigen::SelfAdjointEigenSolver<JointMatrix> solver(matrix);
  axes = solver.eigenvectors();
  return solver.eigenvalues();
}

void Mechanism::setHome(const Pose& home) {
  const auto refuse = [this](const std::string& problem) {
    throw ConfigurationError("device \"" + name_ + "\"", 0, "", problem);
  };
  const Status status = reach(home, Vec6::Zero(), true, home_);
  if (status != Status::ok) refuse(std::string("the home pose is ") + toString(status));
  Cholesky<kMaxJoints> inertia;
  if (!factorInertia(home_.inertia, inertia))
    refuse("the mass matrix at home is not positive definite: give the platform or the links more inertia");
}

}  // namespace enamel
