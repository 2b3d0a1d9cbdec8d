// A simulated device that a hand holds: the part that stand-ins of vendors' libraries share.
#pragma once

#include <cstdlib>
#include <sstream>
#include <string>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/imperfect_plant.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel::test {

/// Set what a stand-in understands from the environment ENAMEL_STAND_IN, such as "button 1 heat 0.7", for programs that
/// are tested from outside.
inline bool setFromEnvironment(void (*set)(const char*, double)) {
  const char* const text = std::getenv("ENAMEL_STAND_IN");
  std::istringstream words(text == nullptr ? "" : text);
  double value = 0.0;
  for (std::string what; words >> what >> value;) set(what.c_str(), value);
  return true;
}

/// The imperfect plant of a device file. The hand holds it at `place`, turned by `turn`. Everything is in W.
class HeldDevice {
 public:
  explicit HeldDevice(const DeviceParameters& parameters, double period, const Vec3& at = Vec3::Zero())
      : place(at),
        mechanism_(makeMechanism(parameters)),
        device_(std::make_unique<ImperfectPlant>(makeImperfectDevice(parameters, 1)), setupOf(period, at)) {}
  HeldDevice(const std::string& file, double period)
      : HeldDevice(loadDevice(std::string(ENAMEL_SOURCE_DIR "/data/devices/") + file), period) {}

  /// Report this sample instead of the simulated ones, until the end of the object.
  void show(const Measurement& sample) {
    sample_ = sample;
    isShown_ = true;
  }
  bool isShown() const noexcept { return isShown_; }

  /// Simulate one period with a wrench of the motors, and keep the sample of its begin.
  void advance(const Vec3& force, const Vec3& moment) {
    if (isShown_) return;
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
      wrench << stiffness * (place - pose.position) - damping * twist.head<3>(),
          0.2 * left.angle() * left.axis() - 0.02 * twist.tail<3>();
      if (mechanism_->joints() == 3) wrench.tail<3>().setZero();
      return wrench;
    });
  }

  double time() const noexcept { return device_.time(); }

  const Measurement& sample() const noexcept { return sample_; }  ///< the newest one

  /// Return the pose of the newest sample.
  Pose pose() const {
    Kinematics k = mechanism_->home();
    (void)mechanism_->track(sample_.q, sample_.rates, false, k);
    return k.pose;
  }

  Vec3 place, turn = Vec3::Zero();          ///< of the hand, m and rad
  double stiffness = 100.0, damping = 5.0;  ///< of the hand, N/m, N s/m

 private:
  static VirtualDeviceSetup setupOf(double period, const Vec3& at) {
    VirtualDeviceSetup setup;
    setup.start.position = at;
    setup.period = period;
    setup.encoders = {true, RateSource::lowPass, 100.0};
    return setup;
  }

  std::shared_ptr<const Mechanism> mechanism_;
  VirtualDevice device_;
  Measurement sample_;
  bool isShown_ = false;
};

}  // namespace enamel::test
