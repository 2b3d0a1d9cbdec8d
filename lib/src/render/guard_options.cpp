#include "render/guard_options.hpp"

#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "device/inertia.hpp"

namespace enamel {
namespace {

void requireLimit(double value, const char* name, const char* unit) {
  require(value >= 0.0, std::string("guard: ") + name + " is " + formatNumber(value) + ", must be at least 0 " + unit);
}

// Gravity and centrifugal forces are even in the twist, so the odd part of the force is the damping.
Mat6 dampingOf(const Mechanism& device) {
  const Kinematics& home = device.home();
  const Jacobian back = home.inverseTransposed;
  const Mat6 inertia = back * home.inertia * back.transpose();
  Mat6 damping = Mat6::Zero();
  constexpr double kSpeed = 0.1;  // m/s or rad/s
  for (int i = 0; i < std::min(device.joints(), 6); ++i) {
    const Vec6 twist = kSpeed * Vec6::Unit(i);
    Vec6 forth, other;
    if (device.accelerate(home.pose, twist, home.gravity, Vec6::Zero(), forth) != Status::ok ||
        device.accelerate(home.pose, -twist, home.gravity, Vec6::Zero(), other) != Status::ok)
      continue;
    damping.col(i) = inertia * (other - forth) / (2.0 * kSpeed);
  }
  return 0.5 * (damping + damping.transpose());
}

}  // namespace

const char* toString(GuardReason reason) noexcept {
  switch (reason) {
    case GuardReason::none: return "none";
    case GuardReason::waiting: return "waiting for a small force";
    case GuardReason::engaging: return "ramps in";
    case GuardReason::disabled: return "disabled by the user";
    case GuardReason::force: return "force limit";
    case GuardReason::torque: return "torque limit";
    case GuardReason::slew: return "slew limit";
    case GuardReason::brake: return "brake";
    case GuardReason::measurement: return "invalid measurement";
    case GuardReason::jump: return "a joint jumped";
    case GuardReason::frozen: return "an encoder is frozen";
    case GuardReason::clock: return "time did not advance";
    case GuardReason::late: return "a tick came late";
    case GuardReason::unreachable: return "no configuration";
    case GuardReason::renderer: return "the renderer failed";
    case GuardReason::workspace: return "left the workspace";
    case GuardReason::speed: return "too fast";
    case GuardReason::energy: return "gave energy";
    case GuardReason::oscillation: return "oscillates";
    case GuardReason::deadlines: return "missed too many deadlines";
    case GuardReason::device: return "the driver failed";
    case GuardReason::early: return "samples come too fast";
  }
  return "unknown reason";
}

GuardOptions guardFor(const Mechanism& device, double period) {
  requirePeriod(period, "guard: ");
  require(device.scale() == 1.0, "guard: the mechanism is mapped; use toScene(guardFor(device, period), map)");
  const Kinematics& home = device.home();
  GuardOptions o;
  o.period = period;
  o.torque = device.limits().effort;
  o.slew = o.torque * (2.0 / 0.5e-3);
  o.encoderStep = device.limits().encoderStep;
  const Mat6 inverseInertia = inverseInertiaOf(home);
  // The largest eigenvalues: 1 / least mass, and 1 / least moment of inertia.
  o.brake = 0.05 / (period * eigenvaluesOf(inverseInertia.topLeftCorner<3, 3>())[2]);
  const double turning = eigenvaluesOf(inverseInertia.bottomRightCorner<3, 3>())[2];
  o.brakeTurn = turning > 0.0 ? 0.05 / (period * turning) : 0.0;
  o.rate.resize(device.joints());
  for (int i = 0; i < device.joints(); ++i)
    o.rate[i] = 2.0 * (o.stopSpeed * home.inverseTransposed.col(i).head<3>().norm() +
                       o.stopTurn * home.inverseTransposed.col(i).tail<3>().norm());
  o.drive = device.limits().drive;
  o.damping = dampingOf(device);
  double force = kUnlimited;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0})
      force = std::min(force, largestForce(home, o.torque, home.pose.position, sign * Vec3::Unit(axis)));
  o.energy = 7e-4 * force;
  o.power = 1e-3 * force;
  return o;
}

GuardOptions toScene(const GuardOptions& ofDevice, const WorkspaceMap& map) {
  require(ofDevice.workspace.minCoeff() == kUnlimited,
          "guard: a box and a workspace map, which can move, exclude each other");
  GuardOptions o = ofDevice;
  o.force /= map.scale;
  for (double* const length : {&o.margin, &o.speed, &o.stopSpeed}) *length *= map.scale;
  for (double* const perArea : {&o.brake, &o.softest}) *perArea /= map.scale * map.scale;
  Mat6 toDevice = Mat6::Zero();  // of a twist
  toDevice.topLeftCorner<3, 3>() = map.base.rotation.transpose() / map.scale;
  toDevice.bottomRightCorner<3, 3>() = map.base.rotation.transpose();
  o.damping = toDevice.transpose() * o.damping * toDevice;
  return o;
}

const GuardOptions& checked(const Mechanism& device, const GuardOptions& o) {
  const int n = device.joints();
  requirePeriod(o.period, "guard: ");
  for (const JointVector* v : {&o.torque, &o.slew, &o.rate, &o.encoderStep})
    require(v->size() == n, "guard: torque, slew, rate and encoder step need " + std::to_string(n) +
                                " numbers each, one has " + std::to_string(v->size()));
  for (int i = 0; i < n; ++i) {
    const double limit = device.limits().effort[i];
    require(o.torque[i] >= 0.0 && o.torque[i] <= limit,
            "guard: the torque limit of joint " + std::to_string(i + 1) + " is " + formatNumber(o.torque[i]) +
                ", must be in 0 to the device's " + formatNumber(limit) + " N m or N");
    require((o.slew[i] > 0.0 || o.torque[i] == 0.0) && o.rate[i] > 0.0 && o.encoderStep[i] > 0.0,
            "guard: slew, rate and encoder step of joint " + std::to_string(i + 1) + " must be greater than 0");
  }
  requireLimit(o.force, "the largest force", "N");
  requireLimit(o.moment, "the largest moment", "N m");
  requireLimit(o.workspace.minCoeff(), "a half width of the workspace", "m");
  requireLimit(o.margin, "the workspace's margin", "m");
  require(o.speed >= 0.0 && o.stopSpeed >= o.speed && o.turn >= 0.0 && o.stopTurn >= o.turn,
          "guard: speed and turn must be at least 0, stopSpeed at least speed, stopTurn at least turn");
  requireLimit(o.brake, "the brake", "N s/m");
  requireLimit(o.brakeTurn, "the brake of rotation", "N m s/rad");
  require(o.damping.allFinite(), "guard: the damping is not finite");
  requireLimit(o.drive.stiffness, "the stiffness of the cables", "N m/rad or N/m");
  requireLimit(o.drive.damping, "the damping of the cables", "N m s/rad or N s/m");
  require(o.drive.stiffness == 0.0 || o.drive.rotorInertia > 0.0,
          "guard: with cables the inertia of the rotors must be greater than 0");
  requireLimit(o.energy, "the energy budget", "J");
  requireLimit(o.power, "the power", "W");
  require(o.softest > 0.0, "guard: the softest wall is " + formatNumber(o.softest) + ", must be greater than 0 N/m");
  requireLimit(o.oscillation, "the oscillation", "of a motor's limit");
  requireLimit(o.engage, "the largest torque at which it engages", "of a motor's limit");
  requireLimit(o.rampIn, "the ramp in", "s");
  requireLimit(o.rampOut, "the ramp out", "s");
  require(o.delay >= 0 && o.delay <= kMostGuardDelay, "guard: the delay is " + std::to_string(o.delay) +
                                                          ", must be in 0 to " + std::to_string(kMostGuardDelay) +
                                                          " ticks");
  require(o.longestGap >= 1 && o.mostMissed >= 0,
          "guard: the longest gap must be at least 1 period, the number of missed deadlines at least 0");
  return o;
}

}  // namespace enamel
