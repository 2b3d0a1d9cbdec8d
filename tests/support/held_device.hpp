// A simulated device that a hand holds: the part that stand-ins of vendors' libraries share.
#pragma once

#include <string>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel::test {

/// The hand holds the device at the middle (100 N/m, 5 N s/m), turned by `turn`. Everything is in W.
class HeldDevice {
 public:
  HeldDevice(const std::string& file, double period)
      : mechanism_(makeMechanism(loadDevice(std::string(ENAMEL_SOURCE_DIR "/data/devices/") + file))),
        device_(*mechanism_, setupOf(period)) {}

  /// Simulate one period with a wrench of the motors, and keep the sample of its begin.
  void advance(const Vec3& force, const Vec3& moment) {
    (void)device_.measure(sample_);
    Command command{JointVector::Zero(mechanism_->joints())};
    command.effort.head<3>() = force;
    if (mechanism_->joints() == 6) {
      Vec6 wrench;
      wrench << force, moment;
      command.effort = torqueOf(device_.kinematics().jacobian, wrench);  // tau = J^T F at the present turn
    }
    (void)device_.actuate(command);
    const Mat3 target = Eigen::AngleAxisd(turn.norm(), turn.norm() > 0 ? Vec3(turn.normalized()) : Vec3(Vec3::UnitX()))
                            .toRotationMatrix();
    (void)device_.advance([&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench;
      const Eigen::AngleAxisd left(Mat3(target * pose.rotation.transpose()));
      wrench << 100.0 * (place - pose.position) - 5.0 * twist.head<3>(),
          0.2 * left.angle() * left.axis() - 0.02 * twist.tail<3>();
      if (mechanism_->joints() == 3) wrench.tail<3>().setZero();
      return wrench;
    });
  }

  double time() const noexcept { return device_.time(); }

  /// Return the pose of the newest sample.
  Pose pose() const {
    Kinematics k = mechanism_->home();
    (void)mechanism_->track(sample_.q, sample_.rates, false, k);
    return k.pose;
  }

  Vec3 place = Vec3::Zero(), turn = Vec3::Zero();  ///< of the hand, m and rad

 private:
  static VirtualDeviceSetup setupOf(double period) {
    VirtualDeviceSetup setup;
    setup.period = period;
    setup.encoders.quantised = true;
    return setup;
  }

  std::shared_ptr<const Mechanism> mechanism_;
  VirtualDevice device_;
  Measurement sample_;
};

}  // namespace enamel::test
