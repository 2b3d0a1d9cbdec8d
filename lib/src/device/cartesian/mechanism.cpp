#include "enamel/device/cartesian/mechanism.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "device/limits.hpp"
#include "device/translation.hpp"

namespace enamel {
namespace {

// Coefficients of the exponential map at an angle t. A series replaces the quotients where they lose digits.
struct TurnCoefficients {
  double sine;    // sin t / t
  double cosine;  // (1 - cos t) / t^2
  double cubic;   // (t - sin t) / t^3
};

TurnCoefficients turnCoefficients(double t) noexcept {
  const double square = t * t;
  if (t < 1e-2)  // next terms: t^6 / 5040, t^6 / 40320, t^6 / 362880
    return {1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0),
            1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0)};
  const double half = std::sin(0.5 * t);
  return {std::sin(t) / t, 2.0 * half * half / square, (t - std::sin(t)) / (square * t)};
}

double lengthOf(const Vec3& v) noexcept { return std::sqrt(v.dot(v)); }

// E(v), the left Jacobian of the exponential map, and its inverse.
Mat3 leftJacobian(const Vec3& turn) noexcept {
  const TurnCoefficients k = turnCoefficients(lengthOf(turn));
  const Mat3 cross = crossMatrix(turn);
  return Mat3::Identity() + k.cosine * cross + k.cubic * cross.lazyProduct(cross);
}

Mat3 inverseLeftJacobian(const Vec3& turn) noexcept {
  const double t = lengthOf(turn);
  const TurnCoefficients k = turnCoefficients(t);
  const Mat3 cross = crossMatrix(turn);
  // 1/t^2 - (1 + cos t) / (2 t sin t) = (1 - (sin t / t) / (2 (1 - cos t) / t^2)) / t^2.
  //
  // Series: 1/12 + t^2/720 + t^4/30240.
  const double square = t * t;
  const double quadratic = t < 1e-1 ? (1.0 + square / 60.0 * (1.0 + square / 42.0 * (1.0 + square / 40.0))) / 12.0
                                    : (1.0 - 0.5 * k.sine / k.cosine) / square;
  return Mat3::Identity() - 0.5 * cross + quadratic * cross.lazyProduct(cross);
}

// v of R = exp([v]x), for angles below pi. Longer than kMaxCartesianTurn if R turns by more.
Vec3 turnOf(const Mat3& rotation) noexcept {
  const Vec3 axis(0.5 * (rotation(2, 1) - rotation(1, 2)), 0.5 * (rotation(0, 2) - rotation(2, 0)),
                  0.5 * (rotation(1, 0) - rotation(0, 1)));  // sin t n
  const double sine = lengthOf(axis), cosine = 0.5 * (rotation(0, 0) + rotation(1, 1) + rotation(2, 2) - 1.0);
  const double t = std::atan2(sine, cosine);
  if (t > kMaxCartesianTurn) return {t, 0.0, 0.0};
  return sine > 0.0 ? Vec3(axis * (t / sine)) : Vec3(Vec3::Zero());
}

JointLimits cartesianLimits(const CartesianParameters& p) {
  JointLimits limits{JointVector::Constant(p.axes, p.maxForce), JointVector::Constant(p.axes, p.positionStep),
                     driveOf(p.rotorMass, p.imperfections)};
  for (int i = 3; i < p.axes; ++i) {
    limits.effort[i] = p.maxMoment;
    limits.encoderStep[i] = p.angleStep;
  }
  for (int i = 0; i < p.axes; ++i)
    if (!p.driven[static_cast<std::size_t>(i)]) limits.effort[i] = 0.0;
  return limits;
}

bool within(const Vec3& position, const Vec3& halfWidths) noexcept {
  for (int i = 0; i < 3; ++i)
    if (!(std::abs(position[i]) <= halfWidths[i])) return false;
  return true;
}

const CartesianParameters& checked(const CartesianParameters& parameters) {
  checkCartesian(parameters);
  return parameters;
}

}  // namespace

CartesianMechanism::CartesianMechanism(const CartesianParameters& parameters)
    : Mechanism(parameters.name, cartesianLimits(checked(parameters))), device_(parameters) {
  setHome();
}

double CartesianMechanism::massAt(const Vec3& position, Vec3& gradient) const noexcept {
  gradient.setZero();
  if (device_.massTable.isEmpty()) return device_.mass;
  return device_.massTable.at(position, device_.halfWidths, gradient);
}

// Fill everything except q, rates, pose and twist. The pose must be set.
void CartesianMechanism::evaluate(const Vec3& turn, bool withInertia, Kinematics& kinematics) const noexcept {
  const int n = device_.axes;
  kinematics.jacobian.setIdentity(6, n);
  kinematics.inverseTransposed.setIdentity(6, n);
  kinematics.gravity.setZero(n);
  Vec3 gradient;
  const double mass = massAt(kinematics.pose.position, gradient);
  kinematics.gravity.head<3>() = -mass * device_.gravity;
  for (int i = 0; i < 3; ++i)
    if (!device_.driven[static_cast<std::size_t>(i)]) kinematics.gravity[i] = 0.0;
  if (withInertia) {
    kinematics.inertia.setZero(n, n);
    kinematics.inertia.topLeftCorner<3, 3>() = mass * Mat3::Identity();
  } else {
    kinematics.inertia.resize(0, 0);
  }
  if (n == 3) return;
  const Mat3 e = leftJacobian(turn);
  kinematics.jacobian.block<3, 3>(3, 3) = e;
  kinematics.inverseTransposed.block<3, 3>(3, 3) = inverseLeftJacobian(turn).transpose();
  if (!withInertia) return;
  const Mat3 toP = kinematics.pose.rotation.transpose().lazyProduct(e);
  const Mat3 half = device_.inertia.lazyProduct(toP);
  const Mat3 m = toP.transpose().lazyProduct(half);
  kinematics.inertia.block<3, 3>(3, 3) = 0.5 * (m + m.transpose());
}

Status CartesianMechanism::track(const JointVector& q, const JointVector& rates, bool withInertia,
                                 Kinematics& kinematics) const noexcept {
  if (q.size() != device_.axes || rates.size() != device_.axes) return Status::outOfRange;
  if (!q.allFinite() || !rates.allFinite()) return Status::notFinite;
  const Vec3 position = q.head<3>();
  if (!within(position, device_.halfWidths)) return Status::unreachable;
  Vec3 turn = Vec3::Zero();
  if (device_.axes == 6) turn = q.segment<3>(3);
  if (!(lengthOf(turn) <= kMaxCartesianTurn)) return Status::unreachable;
  kinematics.q = q;
  kinematics.rates = rates;
  kinematics.pose.position = position;
  kinematics.pose.rotation = rotationFromVector(turn);
  evaluate(turn, withInertia, kinematics);
  kinematics.twist = twistOf(kinematics.jacobian, rates);
  return Status::ok;
}

Status CartesianMechanism::reach(const Pose& pose, const Vec6& twist, Vec3& turn) const noexcept {
  turn.setZero();
  if (device_.axes == 3) {
    const Status status = requireTranslation(pose, twist);
    if (status != Status::ok) return status;
  } else {
    if (!pose.position.allFinite() || !pose.rotation.allFinite() || !twist.allFinite()) return Status::notFinite;
    turn = turnOf(pose.rotation);
    if (!(lengthOf(turn) <= kMaxCartesianTurn)) return Status::unreachable;
  }
  return within(pose.position, device_.halfWidths) ? Status::ok : Status::unreachable;
}

Status CartesianMechanism::reach(const Pose& pose, const Vec6& twist, bool withInertia,
                                 Kinematics& kinematics) const noexcept {
  Vec3 turn;
  const Status status = reach(pose, twist, turn);
  if (status != Status::ok) return status;
  const int n = device_.axes;
  kinematics.q.resize(n);
  kinematics.rates.resize(n);
  kinematics.q.head<3>() = pose.position;
  kinematics.rates.head<3>() = twist.head<3>();
  kinematics.pose = pose;
  kinematics.twist = twist;
  if (n == 6) {
    kinematics.q.segment<3>(3) = turn;
    kinematics.rates.segment<3>(3) = inverseLeftJacobian(turn).lazyProduct(Vec3(twist.tail<3>()));
  } else {
    kinematics.pose.rotation.setIdentity();
    kinematics.twist.tail<3>().setZero();
  }
  evaluate(turn, withInertia, kinematics);
  return Status::ok;
}

Status CartesianMechanism::accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque,
                                      const Vec6& wrench, Vec6& acceleration) const noexcept {
  if (torque.size() != device_.axes) return Status::outOfRange;
  if (!torque.allFinite() || !wrench.allFinite()) return Status::notFinite;
  Vec3 turn;
  const Status status = reach(pose, twist, turn);
  if (status != Status::ok) return status;
  const Vec6 opposing = device_.damping.cwiseProduct(twist);
  const Vec3 force = torque.head<3>() + wrench.head<3>() - opposing.head<3>();
  Vec3 gradient;
  const double mass = massAt(pose.position, gradient);
  acceleration.head<3>() = force / mass + device_.gravity;
  if (!device_.massTable.isEmpty()) {  // Lagrange: d/dt (m v) - 1/2 |v|^2 grad m = sum of forces
    const Vec3 v = twist.head<3>();
    acceleration.head<3>() -= (gradient.dot(v) * v - 0.5 * v.squaredNorm() * gradient) / mass;
  }
  acceleration.tail<3>().setZero();
  if (device_.axes == 3) return Status::ok;
  const Vec3 driven = inverseLeftJacobian(turn).transpose().lazyProduct(Vec3(torque.segment<3>(3)));
  const Vec3 moment = driven + wrench.tail<3>() - opposing.tail<3>();
  // Euler's equation in the axes of P, where the inertia tensor is constant.
  const Mat3 toP = pose.rotation.transpose();
  const Vec3 spin = toP.lazyProduct(Vec3(twist.tail<3>()));
  const Vec3 gyroscopic = spin.cross(Vec3(device_.inertia.lazyProduct(spin)));
  const Vec3 left = toP.lazyProduct(moment) - gyroscopic;
  acceleration.tail<3>() = pose.rotation.lazyProduct(Vec3(device_.inertia.inverse().lazyProduct(left)));
  return Status::ok;
}

std::vector<Bar> CartesianMechanism::bars(const Pose& pose) const {
  std::vector<Bar> bars;
  Vec3 turn;
  if (reach(pose, Vec6::Zero(), turn) != Status::ok) return bars;
  const double length = 0.25 * device_.halfWidths.minCoeff();
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis = length * pose.rotation.col(i);
    bars.push_back({pose.position - axis, pose.position + axis, -1});
  }
  return bars;
}

}  // namespace enamel
