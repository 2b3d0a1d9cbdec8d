#include "renderers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/render/surface_file.hpp"
#include "plugin_folder.hpp"

namespace enamel::app {
namespace {

std::string ticksText(int low, int high) {
  return low == high ? fmt::format("{} ticks", low) : fmt::format("{} to {} ticks", low, high);
}

void requireFits(const std::string& path, Eigen::Index joints, double period, int deviceJoints, double devicePeriod) {
  if (joints != deviceJoints)
    throw Error(fmt::format("{}: the servo is for {} joints, the device has {}", path, joints, deviceJoints));
  if (period != devicePeriod)
    throw Error(fmt::format("{}: the servo is for ticks of {} s, these take {} s", path, period, devicePeriod));
}

}  // namespace

Delay parseDelay(const std::string& text) {
  const char *at = text.data(), *const end = at + text.size();
  const auto literal = [&](std::string_view expected) {
    if (std::string_view(at, static_cast<std::size_t>(end - at)).substr(0, expected.size()) != expected) return false;
    at += expected.size();
    return true;
  };
  const auto number = [&](int& value) {
    const auto [rest, error] = std::from_chars(at, end, value);
    at = rest;
    return error == std::errc{};
  };
  Delay delay;
  bool read = literal("none");
  if (!read && literal("constant:")) {
    read = number(delay.low);
    delay.high = delay.low;
  } else if (!read && literal("random:")) {
    read = number(delay.low) && literal("..") && number(delay.high);
  }
  if (!read || at != end)
    throw Error("--delay is \"" + text + "\", must be none, constant:D or random:A..B with whole ticks");
  return delay;
}

RendererSource findRenderer(const std::string& nameOrPath) {
  for (const char* name : {kPositionControl, kHold, kImpedance, kPassivity})
    if (nameOrPath == name) return {nameOrPath, nullptr};
  auto library = findPlugin(nameOrPath, pluginFolder());
  return {library->description().name, library};
}

std::string rendererOf(const std::string& gain) {
  if (isSurfaceServo(gain)) return kPositionControl;
  (void)loadServo(gain);
  return kHold;
}

void checkGain(const std::string& gain, const std::vector<std::string>& linked, const std::string& option) {
  if (gain.empty()) return;
  const std::string owner = rendererOf(gain);
  if (std::find(linked.begin(), linked.end(), owner) == linked.end())
    throw Error(fmt::format("{}: is {}, for {}, which {} does not name", gain,
                            owner == kHold ? "an LQR design" : "a surface servo", owner, option));
}

ServoGain loadGain(const std::string& path, int joints, double period) {
  const ServoFile servo = loadServo(path);
  requireFits(path, servo.gain.rows(), servo.period, joints, period);
  return servo.gain;
}

SurfaceServoOptions surfaceServo(const std::string& gain, const Mechanism& mechanism, double period,
                                 const Delay& delay) {
  SurfaceServoOptions options;
  if (gain.empty()) {
    options = surfaceServoFor(mechanism.limits().count, period, delay.low, delay.high);
  } else {
    options = loadSurfaceServo(gain).options;
    requireFits(gain, options.count.size(), options.period, mechanism.joints(), period);
    if (options.delayLow != delay.low || options.delayHigh != delay.high)
      throw Error(fmt::format("{}: the servo is for a delay of {}, --delay is {}", gain,
                              ticksText(options.delayLow, options.delayHigh), ticksText(delay.low, delay.high)));
  }
  SurfaceServoRenderer{options};  // refuses here what a run would refuse
  return options;
}

std::unique_ptr<Renderer> makeLinked(const std::string& name, const std::map<std::string, std::string>& parameters,
                                     const std::shared_ptr<const Mechanism>& device, double period) {
  const auto text = [&](const char* key, const std::string& otherwise) {
    const auto found = parameters.find(key);
    return found == parameters.end() ? otherwise : found->second;
  };
  const auto read = [&](const char* key, auto& value) {
    const std::string of = text(key, fmt::format("{}", value));
    const auto [rest, error] = std::from_chars(of.data(), of.data() + of.size(), value);
    if (error != std::errc{} || rest != of.data() + of.size())
      throw Error(fmt::format("parameter {} of {} is \"{}\", must be a number", key, name, of));
  };
  const auto readFlag = [&](const char* key, bool& value) {
    const std::string of = text(key, value ? "on" : "off");
    if (of != "on" && of != "off")
      throw Error(fmt::format("parameter {} of {} is \"{}\", must be on or off", key, name, of));
    value = of == "on";
  };
  if (name == kImpedance || name == kPassivity) {
    ImpedanceOptions options;
    read("stiffness", options.stiffness);
    read("damping", options.damping);
    auto wall = std::make_unique<ImpedanceRenderer>(options);
    if (name == kImpedance) return wall;
    return std::make_unique<PassivityRenderer>(std::move(wall));
  }
  const std::string given = text("gain", "designed"), gain = given == "designed" ? "" : given;
  if (name == kPositionControl) {
    Delay delay;
    read("delay", delay.low);
    delay.high = delay.low;
    if (text("delay-high", "same") != "same") read("delay-high", delay.high);
    return std::make_unique<SurfaceServoRenderer>(surfaceServo(gain, *device, period, delay));
  }
  PositionControlOptions options;
  readFlag("release", options.release);
  readFlag("anti-windup", options.antiWindup);
  return std::make_unique<PositionControlRenderer>(
      gain.empty() ? ServoGain(designServo(device, Pose{}, period).K) : loadGain(gain, device->joints(), period),
      period, options);
}

double dampingAlong(const Mechanism& plant, const Pose& pose, const Vec3& normal) {
  const auto require = [&pose](Status status) {
    if (status != Status::ok)
      throw Error(fmt::format("the pose at ({:.4g}, {:.4g}, {:.4g}) m is {}", pose.position.x(), pose.position.y(),
                              pose.position.z(), toString(status)));
  };
  Kinematics k;
  require(plant.reach(pose, Vec6::Zero(), true, k));
  // What a motion and its opposite do not have in common: gravity and centrifugal forces are even in the twist.
  constexpr double kSpeed = 0.1;  // m/s
  Vec6 twist, forth, back;
  twist << kSpeed * normal, Vec3::Zero();
  require(plant.accelerate(pose, twist, k.gravity, Vec6::Zero(), forth));
  require(plant.accelerate(pose, -twist, k.gravity, Vec6::Zero(), back));
  const JointVector rates = torqueOf(k.inverseTransposed, twist),
                    slowing = torqueOf(k.inverseTransposed, 0.5 * (back - forth));
  return rates.dot(k.inertia * slowing) / (kSpeed * kSpeed);
}

std::string dampingWarning(const ImpedanceOptions& wall, double period, double available) {
  const double required = requiredDamping(wall, period);
  if (available > required * (1.0 + 1e-9)) return "";  // equal is not enough, and `available` has been computed
  return fmt::format(
      "a stiffness of {:.6g} N/m and a damping of {:.6g} N s/m need more than {:.6g} N s/m of device damping at {:.6g} "
      "s (eq. 16), there are {:.6g}: see --device-damping",
      wall.stiffness, wall.damping, required, period, available);
}

}  // namespace enamel::app
