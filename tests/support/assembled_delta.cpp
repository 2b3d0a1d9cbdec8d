#include "support/assembled_delta.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace enamel::test {

// A body-fixed frame: its Jacobian, and its acceleration at zero joint accelerations.
struct AssembledDelta::Frame {
  using Columns = Eigen::Matrix<double, 3, kCoordinates>;
  Vec3 origin = Vec3::Zero(), spin = Vec3::Zero(), turn = Vec3::Zero(), bias = Vec3::Zero();
  Columns linear = Columns::Zero(), angular = Columns::Zero();
};

AssembledDelta::AssembledDelta(const DeltaParameters& device, const Vec3& q, const Vec3& position, const Vec3& velocity,
                               const Vec3& com, const Mat3& extraInertia)
    : device_(device), position_(position), com_(com), inertia_(extraInertia) {
  const DeltaGeometry& g = device.geometry;
  for (int i = 0; i < 3; ++i) {
    Leg& leg = legs_[i];
    leg.u = {std::cos(g.phi[i]), std::sin(g.phi[i]), 0.0};
    leg.v = {-std::sin(g.phi[i]), std::cos(g.phi[i]), 0.0};
    leg.upper = std::cos(q[i]) * leg.u + std::sin(q[i]) * Vec3::UnitZ();
    leg.base = g.r * leg.u + g.s * leg.v - Vec3(0.0, 0.0, device.homeDistance);
    leg.arm = g.c * leg.u + g.f * leg.v;
    const Vec3 span = position + leg.arm - leg.base - g.a * leg.upper;  // from the elbow to the platform joint
    const double t2 = std::atan2(span.z(), span.dot(leg.u)), t3 = std::acos(span.dot(leg.v) / g.b);
    leg.lower = std::cos(t2) * leg.u + std::sin(t2) * Vec3::UnitZ();
    leg.bar = std::sin(t3) * leg.lower + std::cos(t3) * leg.v;
    closureError_ = std::max(closureError_, (span - (g.d + g.e) * leg.lower - g.b * leg.bar).norm());
  }
  // Compute the rates of all joints from the closures and the platform's twist [v; 0].
  rates_.setZero();
  rates_.segment<3>(15) = velocity;
  assemble();
  const Eigen::VectorXd twist = rates_.tail<6>(), right = -closures_.rightCols(6) * twist;
  const Eigen::VectorXd joints = Eigen::FullPivLU<Eigen::MatrixXd>(closures_.leftCols(15)).solve(right);
  rates_.head<15>() = joints;
  closureError_ = std::max(closureError_, (closures_ * rates_).norm());
  assemble();
}

double AssembledDelta::kineticEnergy() const { return 0.5 * rates_.dot(mass_ * rates_); }

Eigen::Matrix<double, 9, 1> AssembledDelta::accelerations(const Vec3& torque, const Vec6& wrench) const {
  Eigen::VectorXd force = force_;
  for (int i = 0; i < 3; ++i) force[5 * i] += torque[i] - device_.motor.viscousFriction * rates_[5 * i];
  force.tail<6>() += wrench;
  force.segment<3>(15) -= device_.platform.damping.cwiseProduct(rates_.segment<3>(15));
  Eigen::FullPivLU<Eigen::MatrixXd> closures(kClosures, kCoordinates);
  closures.setThreshold(1e-9);
  closures.compute(closures_);
  const Eigen::MatrixXd free = closures.kernel(), freeT = free.transpose(), massOfFree = mass_ * free;
  freedoms_ = static_cast<int>(free.cols());
  const Eigen::VectorXd particular = closures.solve(-closureBias_), rest = force - mass_ * particular;
  const Eigen::MatrixXd reduced = freeT * massOfFree;
  const Eigen::VectorXd y = Eigen::FullPivLU<Eigen::MatrixXd>(reduced).solve(Eigen::VectorXd(freeT * rest));
  const Eigen::VectorXd x = particular + free * y;
  Eigen::Matrix<double, 9, 1> result;
  result << x[0], x[5], x[10], x.tail<6>();
  return result;
}

AssembledDelta::Frame AssembledDelta::carried(const Frame& parent, const Vec3& offset) {
  Frame f = parent;
  f.origin += offset;
  f.linear -= crossMatrix(offset) * parent.angular;
  f.bias += parent.turn.cross(offset) + parent.spin.cross(parent.spin.cross(offset));
  return f;
}

AssembledDelta::Frame AssembledDelta::jointed(const Frame& parent, const Vec3& offset, const Vec3& axis,
                                              int coordinate) const {
  Frame f = carried(parent, offset);
  f.angular.col(coordinate) += axis;
  f.turn += parent.spin.cross(rates_[coordinate] * axis);
  f.spin += rates_[coordinate] * axis;
  return f;
}

void AssembledDelta::addBody(const Frame& f, double mass, const Mat3& inertia) {
  mass_ += mass * f.linear.transpose() * f.linear + f.angular.transpose() * inertia * f.angular;
  force_ -= mass * f.linear.transpose() * (f.bias - device_.gravity);
  force_ -= f.angular.transpose() * (inertia * f.turn + f.spin.cross(inertia * f.spin));
  potential_ -= mass * device_.gravity.dot(f.origin);
}

void AssembledDelta::close(int row, const Frame& a, const Frame& b) {
  closures_.middleRows<3>(row) = a.linear - b.linear;
  closureBias_.segment<3>(row) = a.bias - b.bias;
  closureError_ = std::max(closureError_, (a.origin - b.origin).norm());
}

void AssembledDelta::assemble() {
  mass_.setZero();
  force_.setZero();
  closures_.setZero();
  closureBias_.setZero();
  potential_ = 0.0;
  const DeltaGeometry& g = device_.geometry;

  Frame platform;
  platform.origin = position_;
  platform.linear.middleCols<3>(15).setIdentity();
  platform.angular.middleCols<3>(18).setIdentity();
  platform.spin = rates_.tail<3>();
  addBody(carried(platform, com_), device_.platform.mass, inertia_);

  for (int i = 0; i < 3; ++i) {
    const Leg& leg = legs_[i];
    const int k = 5 * i;
    const Vec3 axis = -leg.v;                    // a rotation about it lifts u towards z
    const Vec3 normal = leg.lower.cross(leg.v);  // axis of the bars' joints
    const Vec3 half = 0.5 * device_.bar.spacing * leg.v;
    Frame ground;
    ground.origin = leg.base;
    const Frame upper = jointed(ground, Vec3::Zero(), axis, k);
    const UpperLinkParameters& u = device_.upperLink;
    addBody(carried(upper, u.com * leg.upper), u.mass,
            (u.inertia + device_.motor.rotorInertia) * leg.v * leg.v.transpose());
    const Frame near = jointed(upper, g.a * leg.upper, axis, k + 1);
    const Frame bar = jointed(near, g.e * leg.lower - half, normal, k + 2);
    const Frame other = jointed(near, g.e * leg.lower + half, normal, k + 3);
    const Mat3 rod = device_.bar.mass * g.b * g.b / 12.0 * (Mat3::Identity() - leg.bar * leg.bar.transpose());
    addBody(carried(bar, 0.5 * g.b * leg.bar), device_.bar.mass, rod);
    addBody(carried(other, 0.5 * g.b * leg.bar), device_.bar.mass, rod);
    const Frame far = jointed(bar, g.b * leg.bar, normal, k + 4);
    close(8 * i, carried(other, g.b * leg.bar), carried(far, 2.0 * half));
    close(8 * i + 3, carried(far, half + g.d * leg.lower), carried(platform, leg.arm));
    // The axis v of the far crossbar stays normal to two directions m of the platform: d^2(v.m)/dt^2 = 0.
    const std::array<Vec3, 2> across{leg.u, Vec3::UnitZ()};
    for (int j = 0; j < 2; ++j) {
      const Vec3& m = across[j];
      const int row = 8 * i + 6 + j;
      closures_.row(row) = leg.v.cross(m).transpose() * (far.angular - platform.angular);
      closureBias_[row] = (far.turn.cross(leg.v) + far.spin.cross(far.spin.cross(leg.v))).dot(m) +
                          leg.v.dot(platform.spin.cross(platform.spin.cross(m))) +
                          2.0 * far.spin.cross(leg.v).dot(platform.spin.cross(m));
    }
  }
}

}  // namespace enamel::test
