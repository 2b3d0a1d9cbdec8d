#include "servoed_device.hpp"

#include <cmath>
#include <sstream>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/render/position_control_file.hpp"

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
    refuse(file, "period", "is ", period, " s, must be ", kPeriod, " s, the viewer's");
}

void checkJoints(const std::string& file, const char* key, Eigen::Index joints, const Mechanism& mechanism) {
  if (joints != mechanism.joints())
    refuse(file, key, "is for ", joints, " joints, but ", mechanism.name(), " has ", mechanism.joints());
}

PositionControlOptions loadSurface(const std::string& file, const Mechanism& mechanism) {
  const PositionControlOptions options = loadPositionControl(file).options;
  checkPeriod(file, options.period);
  checkJoints(file, "count", options.encoderStep.size(), mechanism);
  const JointVector& count = mechanism.limits().encoderStep;
  for (Eigen::Index i = 0; i < count.size(); ++i)
    if (std::abs(options.encoderStep[i] - count[i]) > 1e-6 * count[i])
      refuse(file, "count", "is ", options.encoderStep[i], " at joint ", i + 1, ", but ", mechanism.name(), " has ",
             count[i], " rad or m");
  return options;
}

ServoGain loadHold(const std::string& file, const Mechanism& mechanism) {
  const ServoFile servo = [&file] {
    try {
      return loadServo(file);
    } catch (const ConfigurationError& error) {
      throw Error(std::string(error.what()) + " (--gain takes a servo of enamel design, with or without --surface)");
    }
  }();
  checkPeriod(file, servo.period);
  checkJoints(file, "K", servo.gain.rows(), mechanism);
  return servo.gain;
}

}  // namespace

PositionControlOptions positionControlOptions(const ServoedDevice& device, const Mechanism& model, const Delay& delay) {
  const PositionControlOptions usual = positionControlFor(model.limits().encoderStep, kPeriod, delay.low, delay.high);
  if (!device.surface) return usual;
  PositionControlOptions options = *device.surface;
  if (options.delayLow == delay.low && options.delayHigh == delay.high) return options;
  options.delayLow = delay.low;
  options.delayHigh = delay.high;
  options.horizon = usual.horizon;
  return options;
}

ServoedDevice loadServoedDevice(const std::string& path, const std::string& gain) {
  ServoedDevice device;
  device.parameters = loadDevice(path);
  const auto mechanism = makeMechanism(device.parameters);
  const bool surface = isPositionControlFile(gain);
  if (surface) device.surface = loadSurface(gain, *mechanism);
  device.gain =
      gain.empty() || surface ? ServoGain(designServo(mechanism, Pose{}, kPeriod).K) : loadHold(gain, *mechanism);
  return device;
}

}  // namespace enamel::viewer
