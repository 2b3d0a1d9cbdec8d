#include "enamel/control/device_plant.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <string>

#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

// Derivative of the rotation vector v of R = exp(v) R0 at the angular velocity w (world axes). Source: Bortz 1971.
//
//   v' = w - v x w / 2 + (1 - (a/2) cot(a/2)) / a^2 v x (v x w),  a = |v|
Vec3 rotationVectorRate(const Vec3& v, const Vec3& w) {
  const double a = v.norm(), half = 0.5 * a;
  const double c =
      a < 1e-2 ? 1.0 / 12.0 + a * a / 720.0 + a * a * a * a / 30240.0 : (1.0 - half / std::tan(half)) / (a * a);
  const Vec3 cross = v.cross(w);
  return w - 0.5 * cross + c * v.cross(cross);
}

}  // namespace

DevicePlant devicePlant(const std::shared_ptr<const Mechanism>& mechanism, const Pose& pose) {
  if (mechanism == nullptr || !isRotation(pose.rotation))
    throw DesignError("device plant: the mechanism is missing, or the pose's matrix is not a rotation");
  const int n = mechanism->joints();
  if (n != 3 && n != 6)
    throw DesignError("device plant: the mechanism has " + std::to_string(n) + " joints, must have 3 or 6");
  Kinematics operating;
  if (const Status status = mechanism->reach(pose, Vec6::Zero(), true, operating); status != Status::ok)
    throw DesignError(std::string("device plant: the pose is ") + toString(status));
  // Pose and twist of a state.
  struct Motion {
    Pose pose;
    Vec3 rotationVector = Vec3::Zero();
    Vec6 twist = Vec6::Zero();
  };
  const auto motionOf = [pose, n](const Eigen::VectorXd& x) {
    Motion motion;
    if (n == 6) motion.rotationVector = x.segment<3>(3);
    motion.pose = {x.head<3>(), rotationFromVector(motion.rotationVector) * pose.rotation};
    motion.twist.head(n) = x.tail(n);
    return motion;
  };
  DevicePlant plant;
  plant.joints = operating.q;
  plant.jacobian = operating.jacobian;
  plant.effectiveMass = effectiveMass(operating, pose.position, Vec3::UnitZ());
  plant.largestForce = largestForce(operating, mechanism->limits().effort, pose.position, Vec3::UnitZ());
  plant.x0 = Eigen::VectorXd::Zero(2 * n);
  plant.x0.head<3>() = pose.position;
  plant.u0 = operating.gravity;
  plant.f = [mechanism, motionOf, n](const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
    const Motion m = motionOf(x);
    Vec6 acceleration;
    if (mechanism->accelerate(m.pose, m.twist, u, Vec6::Zero(), acceleration) != Status::ok)
      return Eigen::VectorXd(Eigen::VectorXd::Constant(2 * n, kUndefined));
    Vec6 rate = m.twist;
    rate.tail<3>() = rotationVectorRate(m.rotationVector, m.twist.tail<3>());
    Eigen::VectorXd slope(2 * n);
    slope << rate.head(n), acceleration.head(n);
    return slope;
  };
  plant.h = [mechanism, motionOf, n, origin = plant.joints](const Eigen::VectorXd& x) {
    const Motion m = motionOf(x);
    Kinematics k;
    if (mechanism->reach(m.pose, m.twist, false, k) != Status::ok)
      return Eigen::VectorXd(Eigen::VectorXd::Constant(2 * n, kUndefined));
    const Eigen::VectorXd moved = k.q - origin;  // angles are in (-pi, pi]; no joint in metres moves so far
    Eigen::VectorXd y(2 * n);
    y << k.rates, moved.unaryExpr([](double way) { return std::remainder(way, 2.0 * M_PI); });
    return y;
  };
  return plant;
}

ServoDesign designServo(const std::shared_ptr<const Mechanism>& mechanism, const Pose& pose, double period,
                        const ServoWeights& weights) {
  const DevicePlant plant = devicePlant(mechanism, pose);
  return designServo(outputsAsStates(linearise(plant.f, plant.h, plant.x0, plant.u0)), period, weights);
}

}  // namespace enamel
