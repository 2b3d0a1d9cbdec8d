// Parameters of a Cartesian device and their TOML file. Most vendors' SDKs present a device in this form, whatever its
// mechanism is: pose in, force (3 axes) or wrench (6 axes) out. Its dynamics are those of an apparent mass.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "enamel/device/parameters.hpp"

namespace enamel {

/// Masses on a regular grid over the workspace, interpolated linearly. Outside the grid the edge values continue.
struct MassTable {
  std::array<int, 3> counts = {0, 0, 0};  ///< points along x, y, z, at least 2 each; 0: no table
  std::vector<double> mass;               ///< kg, x fastest; the grid has the same corners as the workspace

  bool isEmpty() const noexcept { return mass.empty(); }

  /// Return the mass and its gradient (kg/m) at a position, m, inside `halfWidths` (m) about home. Realtime: yes.
  double at(const Vec3& position, const Vec3& halfWidths, Vec3& gradient) const noexcept;
};

struct CartesianParameters {
  std::string name;
  int axes = 3;                 ///< 3: position and force; 6: pose and wrench
  Vec3 gravity = Vec3::Zero();  ///< on the apparent mass, in W, m/s^2; 0 if the vendor balances it
  double mass = 0.0;            ///< apparent, kg
  MassTable massTable;          ///< apparent mass over the workspace; replaces `mass` if not empty
  Mat3 inertia = Mat3::Zero();  ///< apparent, about the TCP, axes of P, kg m^2; only with 6 axes
  Vec6 damping = Vec6::Zero();  ///< viscous, of the TCP's twist, axes of W: 3 x N s/m, 3 x N m s/rad (only with 6 axes)
  Vec3 halfWidths = Vec3::Zero();  ///< half widths of the workspace, a cuboid about home, m
  std::array<bool, 6> driven = {true, true, true, true, true, true};  ///< axes with a motor; all axes have an encoder
  double maxForce = 0.0;                                              ///< largest force of each axis, N
  double maxMoment = 0.0;       ///< largest moment of each axis, N m; only if a rotation axis has a motor
  double positionStep = 0.0;    ///< resolution of the measured position, m
  double angleStep = 0.0;       ///< resolution of the measured rotation, rad; only with 6 axes
  double rotorMass = 0.0;       ///< kg, the part of the apparent mass that is on the motors' side of the cables
  Imperfections imperfections;  ///< of the axes with motors: N and m in the place of N m and rad
};

/// Read a device file with `kind = "cartesian"`. Realtime: no.
/// Throws ConfigurationError, with file, line, key, value and limit, for:
/// - a file that cannot be read, or malformed TOML;
/// - unknown or missing keys, wrong types, values outside their range;
/// - keys of rotations in a file with 3 axes;
/// - forces in [imperfections] if a rotation has a motor, or cables without a motor on every axis;
/// - a rotor mass that is not below the apparent mass;
/// - a device of another kind.
CartesianParameters loadCartesian(const std::string& path);

/// Read the parameters from text in memory, as loadCartesian(); messages name `file`.
CartesianParameters parseCartesian(std::string_view text, const std::string& file);

/// Check parameters that did not come from a file. Throws ConfigurationError. Realtime: no.
void checkCartesian(const CartesianParameters& parameters);

}  // namespace enamel
