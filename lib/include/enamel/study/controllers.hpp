// Controllers that position control is compared with, with open parameters.
#pragma once

#include "enamel/study/wall_design.hpp"

namespace enamel {

/// The rivals:
/// - impedance: a spring and a damper on the depth (ImpedanceRenderer); stiffness, damping.
/// - passivity: the same under a time-domain passivity controller (PassivityRenderer).
/// - passivity-memory: the same, but a depth returns only the energy it has taken (PassivityBound::memory).
/// - virtual-coupling: VirtualCouplingRenderer; stiffness, damping, mass.
/// - hold: the paper's controller with retuned weights, release and anti-windup; weights of rate, position and
///   integral. The torque has weight 1.
/// - hold-delay: the same, with the pending commands as states (servoForDelay()). A random delay counts as its mean,
///   rounded up.
const std::vector<ControllerSpec>& rivalSpecs();

/// Return a rival by its name. Throws Error if the name is unknown; the message lists the names. Realtime: no.
const ControllerSpec& rivalSpec(const std::string& name);

/// Values of a controller for one device and delay.
struct ControllerValues {
  std::string controller;           ///< its name
  int delayLow = 0, delayHigh = 0;  ///< ticks
  std::vector<double> values;       ///< one per parameter
};

/// File written by `enamel design --rivals` and read by `--tuned` of `enamel study` and `enamel compare`.
struct ControllerFile {
  std::string model;  ///< device file for which they were found
  std::vector<ControllerValues> controllers;
};

/// Read a file (JSON). It contains "model" and "controllers", a list of {"controller", "delay", every parameter by its
/// name}. "delay" is the smallest and largest delay in ticks. Files of version 0.2 have "laws" and "law" instead.
/// Throws ConfigurationError in these cases:
///
/// - the file cannot be read or is not JSON;
/// - a controller is unknown;
/// - a key is missing or of the wrong type;
/// - a value is outside its range.
///
/// Realtime: no.
ControllerFile loadControllers(const std::string& path);

/// Return the text of a file. Throws Error as rivalSpec(). Realtime: no.
std::string controllersText(const ControllerFile& file);

}  // namespace enamel
