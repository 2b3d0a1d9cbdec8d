#include "enamel/plugin/renderer_source.hpp"

#include <charconv>
#include <cstdio>

#include "core/message.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"

namespace enamel {
namespace {

std::string secondsText(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

void requireFits(const std::string& path, Eigen::Index joints, double period, int deviceJoints, double devicePeriod) {
  require(joints == deviceJoints, path + ": the servo is for " + std::to_string(joints) + " joints, the device has " +
                                      std::to_string(deviceJoints));
  require(period == devicePeriod, path + ": the servo is for ticks of " + secondsText(period) +
                                      ", the period here is " + secondsText(devicePeriod));
}

// The parameters of a linked renderer, as texts.
class LinkedParameters {
 public:
  LinkedParameters(const std::string& name, const std::map<std::string, std::string>& values)
      : name_(name), values_(values) {}

  std::string text(const char* key, const std::string& otherwise) const {
    const auto found = values_.find(key);
    return found == values_.end() ? otherwise : found->second;
  }

  // Leave `value` unchanged if the parameter is missing.
  template <typename Number>
  void read(const char* key, Number& value) const {
    const auto found = values_.find(key);
    if (found == values_.end()) return;
    const std::string& of = found->second;
    const auto [rest, error] = std::from_chars(of.data(), of.data() + of.size(), value);
    require(error == std::errc{} && rest == of.data() + of.size(), refusal(key, of, "a number"));
  }
  void readFlag(const char* key, bool& value) const {
    const std::string of = text(key, value ? "on" : "off");
    require(of == "on" || of == "off", refusal(key, of, "on or off"));
    value = of == "on";
  }
  std::string refusal(const char* key, const std::string& value, const char* expected) const {
    return std::string("parameter ") + key + " of " + name_ + " is \"" + value + "\", must be " + expected;
  }

 private:
  const std::string& name_;
  const std::map<std::string, std::string>& values_;
};

}  // namespace

RendererSource findRenderer(const std::string& nameOrPath, const std::string& pluginFolder) {
  for (const char* name : {kPositionControl, kHold, kImpedance, kPassivity})
    if (nameOrPath == name) return {nameOrPath, nullptr};
  auto library = findPlugin(nameOrPath, pluginFolder);
  return {library->description().name, library};
}

void requireKnown(const std::string& name, const std::map<std::string, std::string>& parameters) {
  const std::string known = name == kPositionControl ? "delay, delay-high, drive"
                            : name == kHold          ? "gain, release, anti-windup"
                                                     : "stiffness, damping";
  for (const auto& [key, value] : parameters)
    require((", " + known + ",").find(", " + key + ",") != std::string::npos,
            name + " has no parameter \"" + key + "\", only " + known);
}

ServoGain loadGain(const std::string& path, int joints, double period) {
  const ServoFile servo = loadServo(path);
  requireFits(path, servo.gain.rows(), servo.period, joints, period);
  return servo.gain;
}

std::unique_ptr<Renderer> makeLinked(const std::string& name, const std::map<std::string, std::string>& parameters,
                                     const std::shared_ptr<const Mechanism>& device, double period) {
  const LinkedParameters of(name, parameters);
  if (name == kImpedance || name == kPassivity) {
    ImpedanceOptions options;
    of.read("stiffness", options.stiffness);
    of.read("damping", options.damping);
    options.stiffness /= device->scale();  // forces are those at the hand
    options.damping /= device->scale();
    auto wall = std::make_unique<ImpedanceRenderer>(options);
    if (name == kImpedance) return wall;
    return std::make_unique<PassivityRenderer>(std::move(wall));
  }
  if (name == kPositionControl) {
    int low = 0;
    of.read("delay", low);
    int high = low;
    if (of.text("delay-high", "same") != "same") of.read("delay-high", high);
    PositionControlOptions options = positionControlFor(*device, period, low, high);
    const std::string drive = of.text("drive", "device");
    require(drive == "device" || drive == "rigid" || drive == "ideal",
            of.refusal("drive", drive, "device, rigid or ideal"));
    if (drive == "rigid") options.drive = options.drive.rigid();
    if (drive == "ideal") options.drive = {};
    return std::make_unique<PositionControlRenderer>(options);
  }
  require(name == kHold, "unknown linked renderer \"" + name + "\"");
  const std::string gain = of.text("gain", "designed");
  HoldOptions options;
  of.readFlag("release", options.release);
  of.readFlag("anti-windup", options.antiWindup);
  return std::make_unique<HoldRenderer>(gain == "designed"
                                            ? ServoGain(designServo(device, device->home().pose, period).K)
                                            : loadGain(gain, device->joints(), period),
                                        period, options);
}

}  // namespace enamel
