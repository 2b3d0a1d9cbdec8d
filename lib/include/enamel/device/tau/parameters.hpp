// Parameters of a TAU device (6-DOF parallel haptic device with three R-R-R-S chains) and their TOML file.
//
// Structure: "A Position-Control Based Approach to Haptic Rendering of Stiff Objects", section II. Each chain has a yaw
// joint about the vertical axis and a lift joint, both driven and meeting at `base`, link 1, a passive elbow, link 2,
// and a spherical joint at `platform`. Every length, mass and pose is a parameter.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "enamel/device/parameters.hpp"

namespace enamel {

/// A rigid link. Its frame L has its origin at the proximal joint, x lateral (the yaw tangent), y the in-plane
/// normal and z along the link.
struct LinkParameters {
  double length = 0.0;          ///< m
  double mass = 0.0;            ///< kg
  Vec3 com = Vec3::Zero();      ///< centre of mass in L, m
  Mat3 inertia = Mat3::Zero();  ///< tensor about the centre of mass, axes of L, kg m^2
};

/// A uniform solid cylinder about the link's axis. Units: m, kg, m.
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

/// Reads the file of a TAU (also without `kind`). Throws ConfigurationError, with file, line, key, value and limit, on a file that cannot
/// be read, malformed TOML, unknown or missing keys, wrong types, values out of their range, an inertia tensor
/// that no body can have, and a chain that cannot close at the home pose; a device of another kind. Realtime: no.
TauParameters loadTau(const std::string& path);

/// The same for text in memory; `file` stands in messages.
TauParameters parseTau(std::string_view text, const std::string& file);

/// Checks parameters that did not come from a file: the ranges and the closure at home that loadTau checks.
/// Throws ConfigurationError. Realtime: no.
void checkTau(const TauParameters& parameters);

}  // namespace enamel
