#include "servo_gain.hpp"

#include <cmath>
#include <sstream>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"

namespace enamel::viewer {

ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain) {
  ServoedDevice device;
  device.parameters = loadDevice(path);
  const auto mechanism = makeMechanism(device.parameters);
  if (gain.empty()) {
    device.gain = designServo(mechanism, Pose{}, kPeriod).K;
    return device;
  }
  const ServoFile servo = loadServo(gain);
  std::ostringstream problem;
  if (std::abs(servo.period - kPeriod) > 1e-9 * kPeriod) {
    problem << "is " << servo.period << " s, must be " << kPeriod << " s, the viewer's";
    throw ConfigurationError(gain, 0, "period", problem.str());
  }
  if (servo.gain.rows() != mechanism->joints()) {
    problem << "is for " << servo.gain.rows() << " joints, but " << mechanism->name() << " has " << mechanism->joints();
    throw ConfigurationError(gain, 0, "K", problem.str());
  }
  device.gain = servo.gain;
  return device;
}

}  // namespace enamel::viewer
