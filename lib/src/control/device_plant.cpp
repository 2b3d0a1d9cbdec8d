#include "enamel/control/device_plant.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"

namespace enamel {
namespace {

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

Mat3 rotationOf(const Vec3& rotationVector) {
  const double angle = rotationVector.norm();
  if (angle == 0.0) return Mat3::Identity();
  return Eigen::AngleAxis<double>(angle, rotationVector / angle).toRotationMatrix();
}

// Derivative of the rotation vector v of R = exp(v) R0 at the angular velocity w (world axes):
// v' = w - v x w / 2 + (1 - (a/2) cot(a/2)) / a^2 v x (v x w), a = |v| (Bortz 1971).
Vec3 rotationVectorRate(const Vec3& v, const Vec3& w) {
  const double a = v.norm(), half = 0.5 * a;
  const double c =
      a < 1e-2 ? 1.0 / 12.0 + a * a / 720.0 + a * a * a * a / 30240.0 : (1.0 - half / std::tan(half)) / (a * a);
  const Vec3 cross = v.cross(w);
  return w - 0.5 * cross + c * v.cross(cross);
}

struct Motion {
  TauConfiguration configuration;
  Vec3 rotationVector;
  Vec6 twist;
};

}  // namespace

DevicePlant devicePlant(const TauModel& model, const Pose& pose) {
  TauConfiguration operating;
  if (const Status status = inverseKinematics(model, pose, operating); status != Status::ok)
    throw DesignError(std::string("device plant: the pose is ") + toString(status));
  const auto motionOf = [model, pose](const Eigen::VectorXd& x, Motion& motion) {
    motion.rotationVector = x.segment<3>(3);
    motion.twist = x.tail<6>();
    const Pose moved{x.head<3>(), rotationOf(motion.rotationVector) * pose.rotation};
    return inverseKinematics(model, moved, motion.configuration) == Status::ok;
  };
  DevicePlant plant;
  plant.angles = jointAngles(operating);
  plant.jacobian = jacobian(model, operating);
  plant.effectiveMass = effectiveMass(model, operating, pose.position, Vec3::UnitZ());
  plant.x0 = Eigen::VectorXd::Zero(12);
  plant.x0.head<3>() = pose.position;
  plant.u0 = gravityTorque(model, operating);
  plant.largestForce = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 6; ++i) {
    const double torquePerForce = plant.jacobian(2, i),
                 left = model.maxTorque - std::copysign(1.0, torquePerForce) * plant.u0[i];
    if (torquePerForce != 0.0) plant.largestForce = std::min(plant.largestForce, left / std::abs(torquePerForce));
  }
  plant.f = [model, motionOf](const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
    Eigen::VectorXd rate = Eigen::VectorXd::Constant(12, kUndefined);
    Motion m;
    if (!motionOf(x, m)) return rate;
    rate << m.twist.head<3>(), rotationVectorRate(m.rotationVector, m.twist.tail<3>()),
        forwardDynamics(model, m.configuration, m.twist, Vec6(u), Vec6::Zero());
    return rate;
  };
  plant.h = [model, motionOf, angles = plant.angles](const Eigen::VectorXd& x) {
    Eigen::VectorXd y = Eigen::VectorXd::Constant(12, kUndefined);
    Motion m;
    if (!motionOf(x, m)) return y;
    const Vec6 difference = jointAngles(m.configuration) - angles;
    y << jointRates(model, m.configuration, m.twist),
        difference.unaryExpr([](double angle) { return std::remainder(angle, 2.0 * M_PI); });
    return y;
  };
  return plant;
}

ServoDesign designServo(const TauModel& model, const Pose& pose, double period, const ServoWeights& weights) {
  const DevicePlant plant = devicePlant(model, pose);
  return designServo(outputsAsStates(linearise(plant.f, plant.h, plant.x0, plant.u0)), period, weights);
}

}  // namespace enamel
