// Devices of any kind: their parameters, their TOML files, and the mechanisms made from them.
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

/// Parameters of a device, by its kind.
using DeviceParameters = std::variant<TauParameters, DeltaParameters, CartesianParameters>;

/// Reads a device file. Its `kind` says which: "tau" (also where it is absent), "delta" or "cartesian".
/// Throws ConfigurationError, with file, line, key, value and limit: a file that cannot be read, malformed TOML,
/// unknown or missing keys, wrong types, values out of their range, an inertia tensor that no body can have, and a
/// chain or leg that cannot close at the home pose. Realtime: no.
DeviceParameters loadDevice(const std::string& path);

/// The same for text in memory; `file` stands in messages.
DeviceParameters parseDevice(std::string_view text, const std::string& file);

/// Checks the parameters as loadDevice() does and makes the mechanism. Throws ConfigurationError; also where home is a
/// singularity or its mass matrix not positive definite. Realtime: no.
std::shared_ptr<const Mechanism> makeMechanism(const DeviceParameters& parameters);

const std::string& nameOf(const DeviceParameters& parameters);

/// More viscous damping of the TCP's twist (axes of W, N s/m, N m s/rad), more viscous friction of every driven joint
/// (N m s/rad), more mass at the platform's centre of mass (kg). Turns have no damping where the platform cannot turn.
/// A Cartesian device has no joints but its axes: friction is damping of each of them. Realtime: no.
void addDamping(DeviceParameters& parameters, const Vec6& damping);
void addFriction(DeviceParameters& parameters, double friction);
void addMass(DeviceParameters& parameters, double mass);

/// What the device's file says about real ones; all zero for a Cartesian device, whose drives are its vendor's.
const Imperfections& imperfectionsOf(const DeviceParameters& parameters) noexcept;

/// Return the device with ideal motors, transmissions, encoders and tolerances. Realtime: no.
DeviceParameters idealOf(DeviceParameters parameters);

/// Makes its cables rigid, without backlash. Realtime: no.
void stiffenCables(DeviceParameters& parameters) noexcept;

}  // namespace enamel
