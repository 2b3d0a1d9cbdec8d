#include "device/read.hpp"

#include <cmath>

#include "core/message.hpp"
#include "device/inertia.hpp"

namespace enamel {

std::string formatVector(const Vec3& v) {
  return "[" + formatNumber(v.x()) + ", " + formatNumber(v.y()) + ", " + formatNumber(v.z()) + "]";
}

void requirePositive(double value, const std::string& key, const std::string& unit, const Fail& fail) {
  if (!(value > 0.0 && std::isfinite(value)))
    fail(key, "is " + formatNumber(value) + ", must be greater than 0 " + unit + " and finite");
}

void requireNotNegative(double value, const std::string& key, const std::string& unit, const Fail& fail) {
  if (!(value >= 0.0 && std::isfinite(value)))
    fail(key, "is " + formatNumber(value) + ", must be at least 0 " + unit + " and finite");
}

void checkInertia(const Mat3& inertia, const std::string& key, const Fail& fail) {
  if (!inertia.allFinite()) return fail(key, "must be finite");
  const double scale = inertia.cwiseAbs().maxCoeff();
  const double tolerance = 1e-9 * scale;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (std::abs(inertia(i, j) - inertia(j, i)) > tolerance)
      fail(key, "is not symmetric: element (" + std::to_string(i) + "," + std::to_string(j) + ") is " +
                    formatNumber(inertia(i, j)) + " and (" + std::to_string(j) + "," + std::to_string(i) + ") is " +
                    formatNumber(inertia(j, i)) + " kg m^2");
  }
  const Vec3 moments = eigenvaluesOf(inertia);
  if (moments[0] < -tolerance)
    fail(key, "has the principal moment " + formatNumber(moments[0]) + ", must be at least 0 kg m^2");
  if (moments[2] > moments[0] + moments[1] + tolerance)
    fail(key, "is physically impossible: the largest principal moment is " + formatNumber(moments[2]) +
                  ", must be at most the sum of the others, " + formatNumber(moments[0] + moments[1]) + " kg m^2");
}

void checkPlatform(const PlatformParameters& platform, const Fail& fail) {
  requirePositive(platform.mass, "platform.mass", "kg", fail);
  if (!platform.com.allFinite()) fail("platform.com", "must be finite");
  checkInertia(platform.inertia, "platform.inertia", fail);
  for (int i = 0; i < 6; ++i)
    requireNotNegative(platform.damping[i], "platform.damping[" + std::to_string(i) + "]",
                       i < 3 ? "N s/m" : "N m s/rad", fail);
}

void checkMotor(const MotorParameters& motor, const Fail& fail) {
  requirePositive(motor.maxTorque, "motor.max_torque", "N m", fail);
  requireNotNegative(motor.rotorInertia, "motor.rotor_inertia", "kg m^2", fail);
  requirePositive(motor.encoderCounts, "motor.encoder_counts", "per revolution", fail);
  requireNotNegative(motor.viscousFriction, "motor.viscous_friction", "N m s/rad", fail);
}

namespace {

constexpr double kMostError = 0.2;  // relative

// Keys of the table, with their largest meaningful value. In a unit, "E" is that of efforts and "Q" that of
// coordinates.
struct Imperfection {
  const char* key;
  const char* unit;
  double Imperfections::*value;
  double most;
};
constexpr Imperfection kImperfections[] = {
    {"current_bandwidth", "Hz", &Imperfections::currentBandwidth, kLargestBandwidth},
    {"torque_step", "E", &Imperfections::torqueStep, 1.0},
    {"torque_ripple", "of the torque", &Imperfections::torqueRipple, 1.0},
    {"cogging", "E", &Imperfections::cogging, 10.0},
    {"periods", "a turn or 2 pi m", &Imperfections::periods, 1e5},
    {"coulomb_friction", "E", &Imperfections::coulombFriction, 10.0},
    {"cable_stiffness", "E/Q", &Imperfections::cableStiffness, 1e6},
    {"cable_damping", "E s/Q", &Imperfections::cableDamping, 1e3},
    {"backlash", "Q", &Imperfections::backlash, 0.1},
    {"encoder_offset", "Q", &Imperfections::encoderOffset, 0.1},
    {"length_error", "of the length", &Imperfections::lengthError, kMostError},
    {"mass_error", "of the mass", &Imperfections::massError, kMostError},
    {"jitter", "of the period", &Imperfections::jitter, 1.0},
    {"lost_samples", "of the ticks", &Imperfections::lostSamples, 0.5},
};

std::string unitOf(const Imperfection& i, const DriveWords& words) {
  std::string unit;
  for (const char* c = i.unit; *c != 0; ++c)
    *c == 'E' ? unit += words.effort : *c == 'Q' ? unit += words.coordinate : unit += *c;
  return unit;
}

}  // namespace

void checkImperfections(const Imperfections& imperfections, const DriveWords& words, const Fail& fail) {
  const auto refuse = [&fail](const std::string& key, const std::string& problem) {
    fail("imperfections." + key, problem);
  };
  for (const Imperfection& i : kImperfections)
    if (const double value = imperfections.*i.value; !(value >= 0.0 && value <= i.most))
      refuse(i.key, "is " + formatNumber(value) + ", must be in 0 to " + formatNumber(i.most) + " " + unitOf(i, words));
  const bool isRigid = imperfections.cableStiffness == 0.0;
  if (isRigid && imperfections.backlash > 0.0) refuse("backlash", "needs a cable_stiffness greater than 0");
  if (isRigid && imperfections.cableDamping > 0.0) refuse("cable_damping", "needs a cable_stiffness greater than 0");
  if (!isRigid && !(words.rotorInertia > 0.0))
    refuse("cable_stiffness",
           std::string("needs a ") + words.rotorKey + " greater than 0: the cable is between rotor and link");
}

std::string kindOf(TomlTable& root) { return root.has("kind") ? root.text("kind") : "tau"; }

void requireKind(TomlTable& root, const std::string& kind) {
  if (const std::string found = kindOf(root); found != kind)
    root.fail("kind", "is \"" + found + "\", must be \"" + kind + "\" here");
}

PlatformParameters readPlatform(TomlTable& root) {
  TomlTable table = root.table("platform");
  PlatformParameters platform;
  platform.mass = table.number("mass");
  platform.com = table.vector3("com");
  platform.inertia = table.matrix3("inertia");
  if (table.has("damping")) platform.damping = table.vector6("damping");
  table.finish();
  return platform;
}

MotorParameters readMotor(TomlTable& root) {
  TomlTable table = root.table("motor");
  MotorParameters motor;
  motor.maxTorque = table.number("max_torque");
  motor.rotorInertia = table.number("rotor_inertia");
  motor.encoderCounts = table.number("encoder_counts");
  if (table.has("viscous_friction")) motor.viscousFriction = table.number("viscous_friction");
  table.finish();
  return motor;
}

Imperfections readImperfections(TomlTable& root) {
  Imperfections imperfections;
  if (!root.has("imperfections")) return imperfections;
  TomlTable table = root.table("imperfections");
  for (const Imperfection& i : kImperfections)
    if (table.has(i.key)) imperfections.*i.value = table.number(i.key);
  table.finish();
  return imperfections;
}

Handpiece readHandpiece(TomlTable& root) {
  Handpiece handpiece;
  if (!root.has("handpiece")) return handpiece;
  TomlTable table = root.table("handpiece");
  handpiece.mass = table.number("mass");
  if (table.has("com")) handpiece.com = table.vector3("com");
  if (table.has("inertia")) handpiece.inertia = table.matrix3("inertia");
  if (table.has("gravity")) handpiece.gravity = table.vector3("gravity");
  table.finish();
  return handpiece;
}

}  // namespace enamel
