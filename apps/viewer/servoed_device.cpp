#include "servoed_device.hpp"

#include <cmath>
#include <sstream>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"

namespace enamel::viewer {
namespace {

template <typename... Parts>
[[noreturn]] void refuse(const std::string& file, const char* key, const Parts&... parts) {
  std::ostringstream problem;
  (problem << ... << parts);
  throw ConfigurationError(file, 0, key, problem.str());
}

void checkPeriod(const std::string& file, double period) {
  if (std::abs(period - kPeriod) > 1e-9 * kPeriod)
    refuse(file, "period", "is ", period, " s, must be ", kPeriod, " s, the period of the viewer");
}

void checkJoints(const std::string& file, const char* key, Eigen::Index joints, const Mechanism& mechanism) {
  if (joints != mechanism.joints())
    refuse(file, key, "is for ", joints, " joints, but ", mechanism.name(), " has ", mechanism.joints());
}

ServoGain loadHold(const std::string& file, const Mechanism& mechanism) {
  const ServoFile servo = loadServo(file);
  checkPeriod(file, servo.period);
  checkJoints(file, "K", servo.gain.rows(), mechanism);
  return servo.gain;
}

}  // namespace

ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain) {
  ServoedDevice device;
  device.parameters = loadDevice(path);
  const auto mechanism = makeMechanism(device.parameters);
  device.gain = gain.empty() ? ServoGain(designServo(mechanism, Pose{}, kPeriod).K) : loadHold(gain, *mechanism);
  return device;
}

}  // namespace enamel::viewer
