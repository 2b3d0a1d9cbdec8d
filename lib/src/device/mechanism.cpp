#include "enamel/device/mechanism.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/assert.hpp"
#include "core/message.hpp"
#include "device/inertia.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kSamePose = 1e-6;    // m and rad: far above the errors of an iteration, below what a hand feels
constexpr double kSameMotion = 1e-6;  // relative, of the same reason

template <typename Matrix>
void checkArray(const Matrix& matrix, int rows, int columns, const std::string& name) {
  const auto sizeOf = [](int r, int c) { return std::to_string(r) + (c == 1 ? "" : " x " + std::to_string(c)); };
  const auto hasRows = static_cast<int>(matrix.rows()), hasColumns = static_cast<int>(matrix.cols());
  require(hasRows == rows && hasColumns == columns,
          name + " has " + sizeOf(hasRows, hasColumns) + " numbers, must have " + sizeOf(rows, columns));
  require(matrix.allFinite(), name + " is not finite");
}

// `who` is the function that gave the state.
void checkKinematics(const Kinematics& k, int joints, const std::string& who) {
  checkArray(k.q, joints, 1, who + "the vector of joint coordinates");
  checkArray(k.rates, joints, 1, who + "the vector of joint rates");
  checkArray(k.gravity, joints, 1, who + "the gravity torque");
  checkArray(k.pose.position, 3, 1, who + "the position");
  require(isRotation(k.pose.rotation), who + "the rotation is not a right-handed orthonormal matrix to 1e-6");
  checkArray(k.twist, 6, 1, who + "the twist");
  checkArray(k.jacobian, 6, joints, who + "the Jacobian");
  checkArray(k.inverseTransposed, 6, joints, who + "the transposed inverse of the Jacobian");
  checkArray(k.inertia, joints, joints, who + "the mass matrix");
  const double size = k.jacobian.cwiseAbs().maxCoeff();
  require(size > 0.0, who + "the Jacobian is zero, so the motors cannot push the tool; fill in d(twist)/d(rates)");
  const Jacobian back = k.jacobian * (k.inverseTransposed.transpose() * k.jacobian);
  const double error = (back - k.jacobian).cwiseAbs().maxCoeff();
  require(error <= kSameMotion * size, who + "the inverse does not belong to the Jacobian J: J inverse J differs by " +
                                           formatNumber(error) + "; it must give the joint rates of a twist");
  Cholesky<kMaxJoints> inertia;
  require(factorInertia(k.inertia, inertia), who + "the mass matrix is not positive definite");
}

}  // namespace

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

Mat6 inverseInertiaOf(const Kinematics& kinematics) noexcept {
  Cholesky<kMaxJoints> inertia;  // positive definite for every mechanism
  factorInertia(kinematics.inertia, inertia);
  Mat6 inverse;
  for (int i = 0; i < 6; ++i) {
    JointVector acceleration = torqueOf(kinematics.jacobian, Vec6::Unit(i));
    inertia.solve(acceleration.data());
    inverse.col(i) = twistOf(kinematics.jacobian, acceleration);
  }
  return inverse;
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
  if (status == Status::notFinite) refuse("reach() of the home pose gives a number that is not finite");
  if (status != Status::ok) refuse(std::string("the home pose is ") + toString(status));
  Cholesky<kMaxJoints> inertia;
  if (!factorInertia(home_.inertia, inertia))
    refuse("the mass matrix at home is not positive definite: give the platform or the links more inertia");
}

void checkMechanism(const Mechanism& mechanism, const Pose& start) {
  const std::string who = "device \"" + mechanism.name() + "\": ", place = " at the start pose: ";
  const int joints = mechanism.joints();
  checkArray(mechanism.limits().effort, joints, 1, who + "the vector of largest efforts");
  checkArray(mechanism.limits().encoderStep, joints, 1, who + "the vector of encoder steps");
  const auto requireOk = [](Status status, const std::string& function) {
    require(status == Status::ok, function + "the status is \"" + toString(status) + "\", must be ok" +
                                      (status == Status::notFinite ? "; a number that it gives is not finite" : ""));
  };
  Kinematics reached = mechanism.home();
  requireOk(mechanism.reach(start, Vec6::Zero(), true, reached), who + "reach()" + place);
  checkKinematics(reached, joints, who + "reach()" + place);
  Kinematics tracked = reached;
  requireOk(mechanism.track(reached.q, JointVector::Ones(joints), true, tracked), who + "track()" + place);
  checkKinematics(tracked, joints, who + "track()" + place);
  const double away = std::max((tracked.pose.position - start.position).norm(),
                               (tracked.pose.rotation - start.rotation).cwiseAbs().maxCoeff());
  require(away <= kSamePose, who + "track()" + place + "the joints that reach() gives lead to another pose, " +
                                 formatNumber(away) + " m or rad away");
  const double error = (tracked.twist - twistOf(tracked.jacobian, JointVector::Ones(joints))).cwiseAbs().maxCoeff();
  require(error <= kSameMotion * std::max(1.0, tracked.twist.cwiseAbs().maxCoeff()),
          who + "track()" + place + "the twist differs from Jacobian times joint rates by " + formatNumber(error));
}

}  // namespace enamel
