#include "renderer_option.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <optional>
#include <string_view>

#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"

namespace enamel::app {

Delay parseDelay(const std::string& text) {
  const auto after = [&](std::string_view kind) {
    const std::string_view all = text;
    return all.substr(0, kind.size()) == kind ? readDelay(all.substr(kind.size())) : std::nullopt;
  };
  const bool isRange = text.find("..") != std::string::npos;
  const std::optional<Delay> delay = text == "none" ? Delay{} : after(isRange ? "random:" : "constant:");
  if (!delay) throw Error("--delay is \"" + text + "\", must be none, constant:D or random:A..B with whole ticks");
  return *delay;
}

void checkGain(const std::string& gain, const std::vector<std::string>& linked, const std::string& option) {
  if (gain.empty()) return;
  (void)loadServo(gain);
  if (std::find(linked.begin(), linked.end(), kHold) == linked.end())
    throw Error(fmt::format("{}: is an LQR design for hold, but {} does not name hold", gain, option));
}

double dampingAlong(const Mechanism& plant, const Pose& pose, const Vec3& normal) {
  const auto require = [&pose](Status status) {
    if (status != Status::ok)
      throw Error(fmt::format("the pose at ({:.4g}, {:.4g}, {:.4g}) m is {}", pose.position.x(), pose.position.y(),
                              pose.position.z(), toString(status)));
  };
  Kinematics k;
  require(plant.reach(pose, Vec6::Zero(), true, k));
  // Gravity and centrifugal forces are even in the twist. Damping is odd: half the difference of the two directions.
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
  if (available > required * (1.0 + 1e-9)) return "";  // equality is not enough, and `available` is rounded
  return fmt::format(
      "a stiffness of {:.6g} N/m and a damping of {:.6g} N s/m need more than {:.6g} N s/m of device damping at {:.6g} "
      "s (eq. 16), the device has {:.6g}: see --device-damping",
      wall.stiffness, wall.damping, required, period, available);
}

}  // namespace enamel::app
