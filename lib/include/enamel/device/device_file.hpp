// Devices of any kind: parameters, TOML files and mechanisms.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <variant>

#include "enamel/device/cartesian/parameters.hpp"
#include "enamel/device/delta/parameters.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/device/tau/parameters.hpp"

namespace enamel {

/// Parameters of a device, one type for each kind.
using DeviceParameters = std::variant<TauParameters, DeltaParameters, CartesianParameters>;

/// Read a device file of the kind "tau" (also if the key `kind` is absent), "delta" or "cartesian". Realtime: no.
/// Throws ConfigurationError, with file, line, key, value and limit, for:
/// - a file that cannot be read, or malformed TOML;
/// - unknown or missing keys, wrong types, values outside their range;
/// - an inertia tensor that no body can have;
/// - a chain or leg that cannot close at the home pose.
DeviceParameters loadDevice(const std::string& path);

/// Read a device from text in memory, as loadDevice(); messages name `file`.
DeviceParameters parseDevice(std::string_view text, const std::string& file);

/// Check the parameters as loadDevice() does, and make the mechanism. Throws ConfigurationError, also if home is a
/// singularity or its mass matrix is not positive definite. Realtime: no.
std::shared_ptr<const Mechanism> makeMechanism(const DeviceParameters& parameters);

const std::string& nameOf(const DeviceParameters& parameters);

/// Add to the parameters of a device. Realtime: no.
/// - addDamping(): viscous damping of the TCP's twist, axes of W, N s/m and N m s/rad. Rotations have no damping if the
///   platform cannot rotate.
/// - addFriction(): viscous friction of every driven joint, N m s/rad. The joints of a Cartesian device are its axes,
///   so friction is damping of every axis.
/// - addMass(): mass at the platform's centre of mass, kg.
void addDamping(DeviceParameters& parameters, const Vec6& damping);
void addFriction(DeviceParameters& parameters, double friction);
void addMass(DeviceParameters& parameters, double mass);

/// A body that is fixed to the platform, such as a handpiece.
struct Handpiece {
  double mass = 0.0;              ///< kg
  Vec3 com = Vec3::Zero();        ///< centre of mass in P, m
  Mat3 inertia = Mat3::Zero();    ///< tensor about the centre of mass, axes of P, kg m^2
  Vec3 gravity{0.0, -9.81, 0.0};  ///< of a Cartesian device, which may balance its own weight, in W, m/s^2
};

/// Fix a handpiece to the platform: the model then has its mass, and every renderer balances its weight. A delta does
/// not turn, so com and inertia have no effect. A Cartesian device takes its mass at the TCP. Throws Error for:
/// - a mass or moments that are negative or not finite;
/// - a com or inertia on a Cartesian device that turns;
/// - another gravity than that of a Cartesian device with a mass table.
/// Realtime: no.
void addHandpiece(DeviceParameters& parameters, const Handpiece& handpiece);

/// Multiply masses and inertias of all bodies by a factor, except those of rotors behind cables. Realtime: no.
void scaleMasses(DeviceParameters& parameters, double factor);

/// Return the imperfections of the device file.
const Imperfections& imperfectionsOf(const DeviceParameters& parameters) noexcept;
Imperfections& imperfectionsOf(DeviceParameters& parameters) noexcept;

/// Return the inertia of each rotor, kg m^2, or its part of the apparent mass of a Cartesian device, kg.
double& rotorInertiaOf(DeviceParameters& parameters) noexcept;

/// Take the rotors out of the moving mass: they are behind cables. Realtime: no.
void removeRotors(DeviceParameters& parameters) noexcept;

/// Return the device with ideal motors, transmissions, encoders and tolerances. Realtime: no.
DeviceParameters idealOf(DeviceParameters parameters);

/// Make the cables rigid and remove the backlash. Realtime: no.
void stiffenCables(DeviceParameters& parameters) noexcept;

}  // namespace enamel
