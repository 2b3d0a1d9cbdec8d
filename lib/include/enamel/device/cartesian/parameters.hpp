// Parameters of a Cartesian device and their TOML file: what the SDKs of most vendors offer, whatever the mechanism
// behind them. Pose in; force (3 axes) or wrench (6 axes) out; an apparent mass.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "enamel/device/parameters.hpp"

namespace enamel {

/// Values on a regular grid over the workspace, with linear interpolation between them; constant beyond its edges.
struct MassTable {
  std::array<int, 3> counts = {0, 0, 0};  ///< points along x, y, z, at least 2 each; 0: no table
  std::vector<double> mass;               ///< kg, x fastest; the corners of the grid are those of the workspace

  bool isEmpty() const noexcept { return mass.empty(); }

  /// Mass and its gradient (kg/m) at a position inside `halfWidths` about home, both m. Realtime: yes.
  double at(const Vec3& position, const Vec3& halfWidths, Vec3& gradient) const noexcept;
};

struct CartesianParameters {
  std::string name;
  int axes = 3;                 ///< 3: position and force; 6: pose and wrench
  Vec3 gravity = Vec3::Zero();  ///< that acts on the apparent mass, in W, m/s^2; 0 where the vendor balances it
  double mass = 0.0;            ///< apparent, kg
  MassTable massTable;          ///< apparent mass over the workspace; takes the place of `mass` where it is not empty
  Mat3 inertia = Mat3::Zero();  ///< apparent, about the TCP, axes of P, kg m^2; 6 axes only
  Vec6 damping = Vec6::Zero();  ///< viscous, of the TCP's twist, axes of W: 3 x N s/m, 3 x N m s/rad (6 axes only)
  Vec3 halfWidths = Vec3::Zero();                                     ///< of the workspace, a cuboid about home, m
  std::array<bool, 6> driven = {true, true, true, true, true, true};  ///< axes with a motor; all are sensed
  double maxForce = 0.0;                                              ///< of each axis, N
  double maxMoment = 0.0;     ///< of each axis, N m; only where an axis of turning has a motor
  double positionStep = 0.0;  ///< smallest difference that is measured, m
  double angleStep = 0.0;     ///< the same for turns, rad; 6 axes only
};

/// Reads a file of `kind = "cartesian"`. Throws ConfigurationError, with file, line, key, value and limit, on a file
/// that cannot be read, malformed TOML, unknown or missing keys, wrong types, values out of their range, keys of turns
/// beside 3 axes, and a device of another kind. Realtime: no.
CartesianParameters loadCartesian(const std::string& path);

/// The same for text in memory; `file` stands in messages.
CartesianParameters parseCartesian(std::string_view text, const std::string& file);

/// Checks parameters that did not come from a file. Throws ConfigurationError. Realtime: no.
void checkCartesian(const CartesianParameters& parameters);

}  // namespace enamel
