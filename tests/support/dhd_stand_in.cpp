// A stand-in of Force Dimension's library: the documented functions that the driver uses, and simulated devices. The
// function dhdStandIn() is not the vendor's: it selects the device and its faults.
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>

#include "support/held_device.hpp"

using namespace enamel;

namespace {

using Clock = std::chrono::steady_clock;

struct StandIn {
  int model = 3;             // axes: 3, 6 (the wrist has no motors), 7 (with a gripper)
  int count = 1, busy = -1;  // busy: the index of a device of another program
  bool isOpen = false, hasPower = true, forces = false, button = false, isUnplugged = false, isEarly = false;
  bool needsCalibration = false;
  int offCause = 0;  // of the forces
  double wrench[7] = {};
  std::unique_ptr<test::HeldDevice> device;
  Clock::time_point begin;
  Vec3 turn = Vec3::Zero();                 // of the hand's target, axes of the SDK, rad
  Vec3 place = Vec3::Zero();                // of the hand, W, m
  double stiffness = 100.0, damping = 5.0;  // of the hand, N/m, N s/m
  double gripper = 0.25, angle = 0.25;      // of the hand's fingers and of the gripper that follows them, rad
};
StandIn s;

Mat3 axes() { return (Mat3() << 0, 1, 0, 0, 0, 1, 1, 0, 0).finished(); }  // world = axes * sdk

// Simulate to the present, at most 0.1 s.
void advance() {
  if (s.device->isShown()) return;
  const double now = std::chrono::duration<double>(Clock::now() - s.begin).count();
  if (now - s.device->time() > 0.1)
    s.begin = Clock::now() - std::chrono::microseconds(static_cast<long>(1e6 * (s.device->time() + 0.1)));
  s.device->turn = axes() * s.turn;
  s.device->place = s.place;
  s.device->stiffness = s.stiffness;
  s.device->damping = s.damping;
  const Vec3 force = axes() * Eigen::Map<const Vec3>(s.wrench), moment = axes() * Eigen::Map<const Vec3>(s.wrench + 3);
  while (s.device->time() < std::chrono::duration<double>(Clock::now() - s.begin).count())
    s.device->advance(s.forces ? force : Vec3(Vec3::Zero()), s.forces && s.model == 7 ? moment : Vec3(Vec3::Zero()));
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

// what: "model" (3, 6, 7), "count", "busy", "power", "button", "unplugged", "early", "forces", "off-cause", "reset". Of
// the hand: "stiffness", "damping", "gripper", "place-x" to "place-z" (W), "turn-x" to "turn-z" (axes of the SDK).
void dhdStandIn(const char* what, double value) {
  const auto is = [what](const char* name) { return std::strcmp(what, name) == 0; };
  if (is("model")) s.model = static_cast<int>(value);
  if (is("count")) s.count = static_cast<int>(value);
  if (is("busy")) s.busy = static_cast<int>(value);
  if (is("power")) s.hasPower = value != 0.0;
  if (is("button")) s.button = value != 0.0;
  if (is("stiffness")) s.stiffness = value;
  if (is("damping")) s.damping = value;
  if (is("gripper")) s.gripper = value;
  if (is("unplugged")) s.isUnplugged = value != 0.0;
  if (s.isUnplugged) {  // nothing drives the motors any more
    s.forces = s.isOpen = false;
    std::memset(s.wrench, 0, sizeof s.wrench);
  }
  if (is("reset")) s.needsCalibration = value != 0.0;
  if (is("off-cause")) s.offCause = static_cast<int>(value);
  if (is("early")) s.isEarly = value != 0.0;
  if (is("forces")) s.forces = value != 0.0;
  for (int i = 0; i < 3; ++i) {
    if (std::strncmp(what, "turn-", 5) == 0 && what[5] == "xyz"[i]) s.turn[i] = value;
    if (std::strncmp(what, "place-", 6) == 0 && what[6] == "xyz"[i]) s.place[i] = value;
  }
}
double dhdStandInForce(int axis) { return s.wrench[axis]; }
void dhdStandInShow(const Measurement* sample) { s.device->show(*sample); }

int dhdGetDeviceCount() { return s.count; }
int dhdOpenID(char index) {
  if (index >= s.count || s.isUnplugged || index == s.busy) return -1;
  const char* const files[] = {"omega-3.toml", "omega-6.toml", "sigma-7.toml"};
  s.device = std::make_unique<test::HeldDevice>(files[s.model == 3 ? 0 : s.model == 6 ? 1 : 2], 2.5e-4);
  s.begin = Clock::now();
  s.isOpen = true;
  s.angle = s.gripper;
  advance();
  return 5;  // a number of the SDK, not the index
}
int dhdClose(char) {
  s.isOpen = false;
  return 0;
}
const char* dhdGetSystemName(char) { return s.model == 3 ? "omega.3" : s.model == 6 ? "omega.6" : "sigma.7"; }
bool dhdHasWrist(char) { return s.model > 3; }
bool dhdHasActiveWrist(char) { return s.model == 7; }
bool dhdHasGripper(char) { return s.model == 7; }
int dhdEnableForce(unsigned char on, char) {
  if (!s.isOpen) return -1;
  s.forces = on != 0;
  return 0;
}
int dhdGetStatus(int* status, char) {
  std::memset(status, 0, 16 * sizeof(int));
  status[0] = s.hasPower;
  status[1] = 1;
  status[3] = s.needsCalibration;
  status[5] = s.forces;
  status[14] = s.offCause;
  return s.isUnplugged ? -1 : 0;
}
int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z, double rotation[3][3], char id) {
  if (s.isUnplugged || id != 5 || !s.isOpen) return -1;
  advance();
  const Pose pose = s.device->pose();
  const Vec3 p = axes().transpose() * pose.position;
  *x = p.x();
  *y = p.y();
  *z = p.z();
  const Mat3 frame = axes().transpose() * pose.rotation * axes();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) rotation[i][j] = frame(i, j);
  return s.isEarly ? 1 : 0;
}
int dhdGetGripperAngleRad(double* angle, char) {
  constexpr double kFingers = 0.1, kFollow = 0.02;  // rad/N; share of the way in a call
  s.angle += kFollow * (s.gripper - s.angle);
  *angle = s.angle + (s.forces ? kFingers * s.wrench[6] : 0.0);
  return 0;
}
unsigned dhdGetButtonMask(char) { return s.button ? 1U : 0U; }
int dhdSetForceAndTorqueAndGripperForce(double fx, double fy, double fz, double tx, double ty, double tz, double fg,
                                        char) {
  if (s.isUnplugged || !s.isOpen) return -1;
  advance();
  const double wrench[] = {fx, fy, fz, tx, ty, tz, fg};
  std::memcpy(s.wrench, wrench, sizeof wrench);
  return 0;
}
void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = 3;
  *minor = 17;
  *release = 6;
  *revision = 0;
}
const char* dhdErrorGetLastStr() { return "stand-in"; }

}  // extern "C"

namespace {
[[maybe_unused]] const bool isSet = test::setFromEnvironment(dhdStandIn);
}  // namespace
#pragma GCC visibility pop
