#include "servo_gain.hpp"

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_design.hpp"

namespace enamel::viewer {

ServoedDevice loadServoedDevice(const std::string& path) {
  ServoedDevice device;
  device.parameters = loadDevice(path);
  const DevicePlant plant = devicePlant(makeModel(device.parameters), Pose{});
  const StateSpace linear = outputsAsStates(linearise(plant.f, plant.h, plant.x0, plant.u0));
  device.gain = designServo(linear, kPeriod, ServoWeights{}).K;
  return device;
}

}  // namespace enamel::viewer
