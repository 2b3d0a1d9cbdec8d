#include "enamel/device/mapped_mechanism.hpp"

#include <cmath>

#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

const Mechanism& checked(const std::shared_ptr<const Mechanism>& device, const WorkspaceMap& map) {
  require(device != nullptr, "workspace map: the mechanism is null");
  require(map.base.position.allFinite() && map.base.position.cwiseAbs().maxCoeff() <= kFarthestBase,
          "workspace map: the base must be within " + formatNumber(kFarthestBase) +
              " m of the scene's origin along every axis; are its lengths in metres?");
  require(isRotation(map.base.rotation), "workspace map: the base has no right-handed rotation matrix");
  require(map.scale >= kSmallestScale && map.scale <= kLargestScale,
          "workspace map: the scale is " + formatNumber(map.scale) + ", must be in " + formatNumber(kSmallestScale) +
              " to " + formatNumber(kLargestScale));
  return *device;
}

// Multiply the upper rows by `linear` R and the lower rows by R.
template <typename Matrix>
void turn(const Mat3& R, double linear, Matrix& matrix) noexcept {
  for (int i = 0; i < matrix.cols(); ++i) {
    const Vec3 upper = linear * (R * matrix.template block<3, 1>(0, i));
    const Vec3 lower = R * matrix.template block<3, 1>(3, i);
    matrix.template block<3, 1>(0, i) = upper;
    matrix.template block<3, 1>(3, i) = lower;
  }
}

}  // namespace

MappedMechanism::MappedMechanism(std::shared_ptr<const Mechanism> device, const WorkspaceMap& map)
    : Mechanism(checked(device, map).name(), device->limits(), map.scale), device_(std::move(device)), map_(map) {
  setHome(toScene(device_->home().pose));
}

void MappedMechanism::moveBase(const Vec3& position) noexcept {
  if (position.allFinite()) map_.base.position = position.cwiseMax(-kFarthestBase).cwiseMin(kFarthestBase);
}

Pose MappedMechanism::toScene(const Pose& pose) const noexcept {
  const Mat3& R = map_.base.rotation;
  return {map_.base.position + map_.scale * (R * pose.position), R * pose.rotation};
}

Pose MappedMechanism::toDevice(const Pose& pose) const noexcept {
  const Mat3& R = map_.base.rotation;
  return {R.transpose() * (pose.position - map_.base.position) / map_.scale, R.transpose() * pose.rotation};
}

Vec6 MappedMechanism::motionToScene(const Vec6& twist) const noexcept {
  Vec6 result = twist;
  turn(map_.base.rotation, map_.scale, result);
  return result;
}

Vec6 MappedMechanism::motionToDevice(const Vec6& twist) const noexcept {
  Vec6 result = twist;
  turn(map_.base.rotation.transpose(), 1.0 / map_.scale, result);
  return result;
}

Kinematics MappedMechanism::toDevice(const Kinematics& k) const noexcept {
  const Mat3 back = map_.base.rotation.transpose();
  Kinematics device = k;
  device.pose = toDevice(k.pose);
  turn(back, 1.0 / map_.scale, device.twist);
  turn(back, 1.0 / map_.scale, device.jacobian);
  turn(back, map_.scale, device.inverseTransposed);
  return device;
}

void MappedMechanism::toScene(const Kinematics& device, Kinematics& k) const noexcept {
  k = device;
  k.pose = toScene(device.pose);
  turn(map_.base.rotation, map_.scale, k.twist);
  turn(map_.base.rotation, map_.scale, k.jacobian);
  turn(map_.base.rotation, 1.0 / map_.scale, k.inverseTransposed);
}

Status MappedMechanism::track(const JointVector& q, const JointVector& rates, bool withInertia,
                              Kinematics& kinematics) const noexcept {
  Kinematics device = toDevice(kinematics);
  const Status status = device_->track(q, rates, withInertia, device);
  if (status == Status::ok) toScene(device, kinematics);
  return status;
}

Status MappedMechanism::reach(const Pose& pose, const Vec6& twist, bool withInertia,
                              Kinematics& kinematics) const noexcept {
  Kinematics device;
  const Status status = device_->reach(toDevice(pose), motionToDevice(twist), withInertia, device);
  if (status == Status::ok) toScene(device, kinematics);
  return status;
}

Status MappedMechanism::accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                   Vec6& acceleration) const noexcept {
  Vec6 load = wrench;
  turn(map_.base.rotation.transpose(), map_.scale, load);
  Vec6 device;
  const Status status = device_->accelerate(toDevice(pose), motionToDevice(twist), torque, load, device);
  if (status == Status::ok) acceleration = motionToScene(device);
  return status;
}

std::vector<Bar> MappedMechanism::bars(const Pose& pose) const {
  std::vector<Bar> bars = device_->bars(toDevice(pose));
  for (Bar& bar : bars) {
    bar.from = toScene({bar.from, Mat3::Identity()}).position;
    bar.to = toScene({bar.to, Mat3::Identity()}).position;
  }
  return bars;
}

}  // namespace enamel
