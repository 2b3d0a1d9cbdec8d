#include "bench/assembled_dynamics.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace enamel::bench {
namespace {

constexpr int kCoordinates = 15;  // three joints per chain, then the platform's twist
constexpr int kClosures = 9;      // three equations per ball joint

// Positions, axes and velocities along one chain.
struct ChainFrames {
  std::array<Vec3, 3> axis;    // yaw, lift, elbow in W
  std::array<Vec3, 3> origin;  // of each joint in W
  Mat3 link1, link2;           // axes of the links' frames L in W
  Vec3 tip;
};

ChainFrames framesOf(const ChainParameters& chain, const Vec3& angles) {
  ChainFrames f;
  const Mat3 yaw = Eigen::AngleAxis<double>(angles[0], Vec3::UnitY()).toRotationMatrix();
  f.link1 = yaw * Eigen::AngleAxis<double>(-angles[1], Vec3::UnitX()).toRotationMatrix();
  f.link2 = f.link1 * Eigen::AngleAxis<double>(-angles[2], Vec3::UnitX()).toRotationMatrix();
  f.axis = {Vec3::UnitY(), -yaw.col(0), -yaw.col(0)};
  f.origin[0] = f.origin[1] = chain.base;
  f.origin[2] = chain.base + chain.link1.length * f.link1.col(2);
  f.tip = f.origin[2] + chain.link2.length * f.link2.col(2);
  return f;
}

// Return the columns that map the rates of the first `joints` joints to the velocity of a point.
Mat3 pointJacobian(const ChainFrames& f, const Vec3& point, int joints) {
  Mat3 j = Mat3::Zero();
  for (int k = 0; k < joints; ++k) j.col(k) = f.axis[k].cross(point - f.origin[k]);
  return j;
}

Mat3 spinJacobian(const ChainFrames& f, int joints) {
  Mat3 j = Mat3::Zero();
  for (int k = 0; k < joints; ++k) j.col(k) = f.axis[k];
  return j;
}

}  // namespace

void setRates(const TauParameters& device, TreeState& state) {
  for (int i = 0; i < 3; ++i) {
    const ChainFrames f = framesOf(device.chain[i], state.angles[i]);
    const Vec3 arm = state.pose.rotation * device.chain[i].platform;
    const Vec3 velocity = state.twist.head<3>() + state.twist.tail<3>().cross(arm);
    state.rates[i] = pointJacobian(f, f.tip, 3).partialPivLu().solve(velocity);
  }
}

TreeAcceleration assembledForwardDynamics(const TauParameters& device, const TreeState& state, const Vec6& torque,
                                          const Vec6& wrench) {
  using Kkt = Eigen::Matrix<double, kCoordinates + kClosures, kCoordinates + kClosures>;
  Kkt kkt = Kkt::Zero();
  Eigen::Matrix<double, kCoordinates + kClosures, 1> right = decltype(right)::Zero();
  const Vec3 omega = state.twist.tail<3>();

  for (int i = 0; i < 3; ++i) {
    const ChainParameters& chain = device.chain[i];
    const ChainFrames f = framesOf(chain, state.angles[i]);
    const Vec3& rates = state.rates[i];
    const Vec3 spin1 = rates[0] * f.axis[0] + rates[1] * f.axis[1];
    const Vec3 spin2 = spin1 + rates[2] * f.axis[2];
    // Accelerations at zero joint accelerations: the yaw turns the axes of lift and elbow.
    const Vec3 turn1 = rates[0] * f.axis[0].cross(rates[1] * f.axis[1]);
    const Vec3 turn2 = turn1 + rates[0] * f.axis[0].cross(rates[2] * f.axis[2]);
    const auto carried = [](const Vec3& turn, const Vec3& spin, const Vec3& offset) -> Vec3 {
      return turn.cross(offset) + spin.cross(spin.cross(offset));
    };
    const Vec3 knee = carried(turn1, spin1, f.origin[2] - f.origin[1]);

    Mat3 mass = device.motor.rotorInertia * Vec3(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix();
    Vec3 force(torque[2 * i], torque[2 * i + 1], 0.0);
    force -= device.motor.viscousFriction * Vec3(rates[0], rates[1], 0.0);
    const auto addBody = [&](const LinkParameters& link, const Mat3& axes, const Vec3& origin, const Vec3& originAcc,
                             const Vec3& spin, const Vec3& turn, int joints) {
      const Vec3 offset = axes * link.com;
      const Mat3 inertia = axes * link.inertia * axes.transpose();
      const Mat3 jv = pointJacobian(f, origin + offset, joints), jw = spinJacobian(f, joints);
      mass += link.mass * jv.transpose() * jv + jw.transpose() * inertia * jw;
      force -= link.mass * jv.transpose() * (originAcc + carried(turn, spin, offset) - device.gravity);
      force -= jw.transpose() * (inertia * turn + spin.cross(inertia * spin));
    };
    addBody(chain.link1, f.link1, f.origin[1], Vec3::Zero(), spin1, turn1, 2);
    addBody(chain.link2, f.link2, f.origin[2], knee, spin2, turn2, 3);
    kkt.block<3, 3>(3 * i, 3 * i) = mass;
    right.segment<3>(3 * i) = force;

    const Vec3 arm = state.pose.rotation * chain.platform;
    const int row = kCoordinates + 3 * i;
    kkt.block<3, 3>(row, 3 * i) = pointJacobian(f, f.tip, 3);
    kkt.block<3, 3>(row, 9) = -Mat3::Identity();
    kkt.block<3, 3>(row, 12) = crossMatrix(arm);
    right.segment<3>(row) = omega.cross(omega.cross(arm)) - knee - carried(turn2, spin2, f.tip - f.origin[2]);
  }

  const PlatformParameters& p = device.platform;
  const Vec3 offset = state.pose.rotation * p.com;
  const Mat3 inertia = state.pose.rotation * p.inertia * state.pose.rotation.transpose();
  Eigen::Matrix<double, 3, 6> jv, jw;
  jv << Mat3::Identity(), -crossMatrix(offset);
  jw << Mat3::Zero(), Mat3::Identity();
  kkt.block<6, 6>(9, 9) = p.mass * jv.transpose() * jv + jw.transpose() * inertia * jw;
  right.segment<6>(9) = wrench - p.damping.cwiseProduct(state.twist) -
                        p.mass * jv.transpose() * (omega.cross(omega.cross(offset)) - device.gravity) -
                        jw.transpose() * omega.cross(inertia * omega);
  kkt.topRightCorner<kCoordinates, kClosures>() = kkt.bottomLeftCorner<kClosures, kCoordinates>().transpose();

  Eigen::Matrix<double, kCoordinates, 1> rates;
  rates << state.rates[0], state.rates[1], state.rates[2], state.twist;
  const Eigen::Matrix<double, kCoordinates + kClosures, 1> solution = kkt.partialPivLu().solve(right);
  TreeAcceleration result;
  for (int i = 0; i < 3; ++i) result.joints.segment<2>(2 * i) = solution.segment<2>(3 * i);
  result.twist = solution.segment<6>(9);
  result.kineticEnergy = 0.5 * rates.dot(kkt.topLeftCorner<kCoordinates, kCoordinates>() * rates);
  return result;
}

}  // namespace enamel::bench
