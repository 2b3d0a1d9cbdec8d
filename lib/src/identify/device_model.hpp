// The device with all numbers that an identification estimates. Private to identify.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "enamel/sim/imperfect_plant.hpp"

namespace enamel::identify {

inline constexpr double kComSpread = 0.01;     // m, of the platform
inline constexpr double kGravitySpread = 1.0;  // m/s^2: an unbalanced remainder
inline constexpr const char* kWeight = "attached weight";

/// A device as the identification simulates it.
struct DeviceModel {
  DeviceParameters device;   ///< with its rotors; its [imperfections] are not used
  Imperfections drive;       ///< cables, ripple and torque step
  double lag = 0.0;          ///< time constant of the motors, s
  double delay = 0.0;        ///< of the commands, ticks; any number of at least 0
  int spread = 0;            ///< the delay is uniform in delay to delay + spread
  JointVector ratio;         ///< torque of each motor relative to the others, before normalisation
  JointVector coulomb;       ///< N m or N
  JointVector offset;        ///< of the encoders, rad or m
  JointVector sine, cosine;  ///< amplitudes of cogging at the phase of the reading, N m or N
  std::array<double, 6> links = {1.0, 1.0, 1.0,
                                 1.0, 1.0, 1.0};  ///< of a TAU: factors of mass and inertia, chain by chain
  JointVector home;                               ///< readings at home without offset, rad or m
  double weight = 0.0;  ///< attached at the TCP in some motions, kg: in the scale of the commands, as all masses

  bool hasCables() const noexcept { return drive.cableStiffness > 0.0; }
};

/// Return the model that a device file describes, with a delay of 0.
DeviceModel modelOf(const DeviceParameters& device);

/// Multiply mass and inertia of the links of a TAU, chain by chain.
void scaleLinks(const std::array<double, 6>& factors, TauParameters& device);

/// Return ratio, scaled so that its mean is 1. Forces and moments of a Cartesian device have separate means.
JointVector torqueRatios(const DeviceModel& model);

/// Return the viscous friction of each joint, N m s/rad or N s/m. Damping of a Cartesian device counts as friction of
/// its axes.
JointVector viscousFriction(const DeviceModel& model);

/// Return the device's mechanism with the weight attached. Throws ConfigurationError if the numbers are impossible.
std::shared_ptr<const Mechanism> weightedMechanism(const DeviceModel& model);

/// Make the simulated device, without lag, delay, rounding of the torque and viscous friction. Throws
/// ConfigurationError if the numbers are impossible.
ImperfectDevice deviceOf(const DeviceModel& model);

/// Return the name of joint `i` in a text: "joint 2", or "axis y" of a Cartesian device.
std::string jointName(const DeviceParameters& device, int i);

/// A number of the model that is estimated, in the coordinate x: value = reference + scale x, or reference exp(x).
struct Unknown {
  std::string key;  ///< key of the device file, or a name in words
  std::string unit;
  std::function<double&(DeviceModel&)> value;
  double spread = 1.0;  ///< standard deviation of x before the recording: how wrong a file may be
  double scale = 0.0;   ///< 0: exponential
  double reference = 1.0;
  bool isNonNegative = false;
  bool isInFile = true;    ///< `key` is a key of the device file
  bool isOfDrives = true;  ///< it changes neither inertia nor gravity of the mechanism

  double at(double x) const noexcept;
  double slope(double x) const noexcept;  ///< of at()
  double least() const noexcept;          ///< smallest x
};

/// List the unknowns of a model.
std::vector<Unknown> unknownsOf(const DeviceModel& model);

/// Return the model with these coordinates of the unknowns.
DeviceModel modelAt(const DeviceModel& reference, const std::vector<Unknown>& unknowns, const Eigen::VectorXd& x);

}  // namespace enamel::identify
