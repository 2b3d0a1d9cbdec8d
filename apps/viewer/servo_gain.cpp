#include "servo_gain.hpp"

#include "enamel/control/device_plant.hpp"

namespace enamel::viewer {

ServoedDevice loadServoedDevice(const std::string& path) {
  ServoedDevice device;
  device.parameters = loadTau(path);
  device.gain = designServo(makeModel(device.parameters), Pose{}, kPeriod).K;
  return device;
}

}  // namespace enamel::viewer
