// Parameters of a TAU device (6-DOF parallel haptic device with three R-R-R-S chains) and their TOML file.
//
// Structure: "A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section II. The parts of each
// chain, in order:
// - a yaw joint about the vertical axis and a lift joint, both driven, with axes that meet at `base`;
// - link 1, a passive elbow and link 2;
// - a spherical joint at `platform`.
//
// Every length, mass and pose is a parameter.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "enamel/device/parameters.hpp"

namespace enamel {

/// A rigid link. Its frame L has its origin at the proximal joint. x is lateral (the yaw tangent), y is the normal in
/// the plane of the chain, and z points along the link.
struct LinkParameters {
  double length = 0.0;          ///< m
  double mass = 0.0;            ///< kg
  Vec3 com = Vec3::Zero();      ///< centre of mass in L, m
  Mat3 inertia = Mat3::Zero();  ///< tensor about the centre of mass, axes of L, kg m^2
};

/// Return a uniform solid cylinder about the link's axis. Units: m, kg, m.
LinkParameters uniformRod(double length, double mass, double radius) noexcept;

struct ChainParameters {
  Vec3 base = Vec3::Zero();      ///< point where the yaw and lift axes meet, in W, m
  Vec3 platform = Vec3::Zero();  ///< centre of the spherical joint, in P, m
  LinkParameters link1;
  LinkParameters link2;
  int elbow = 1;  ///< sign of the passive elbow angle: +1 or -1
};

struct TauParameters {
  std::string name;
  Vec3 gravity = Vec3::Zero();  ///< in W, m/s^2
  std::array<ChainParameters, 3> chain;
  PlatformParameters platform;
  MotorParameters motor;
  Imperfections imperfections;
};

/// Read the file of a TAU; the key `kind` may be absent. Realtime: no.
/// Throws ConfigurationError, with file, line, key, value and limit, for:
/// - a file that cannot be read, or malformed TOML;
/// - unknown or missing keys, wrong types, values outside their range;
/// - an inertia tensor that no body can have;
/// - a chain that cannot close at the home pose;
/// - a device of another kind.
TauParameters loadTau(const std::string& path);

/// Read the parameters from text in memory, as loadTau(); messages name `file`.
TauParameters parseTau(std::string_view text, const std::string& file);

/// Check parameters that did not come from a file: the ranges and the closure at home, as loadTau(). Throws
/// ConfigurationError. Realtime: no.
void checkTau(const TauParameters& parameters);

}  // namespace enamel
