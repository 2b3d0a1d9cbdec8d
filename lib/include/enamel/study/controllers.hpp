// The controllers that position control is compared with, with their numbers open.
#pragma once

#include "enamel/study/wall_design.hpp"

namespace enamel {

/// The rivals:
/// - impedance: a spring and a damper on the depth (ImpedanceRenderer); stiffness, damping.
/// - passivity: the same under a time-domain passivity controller (PassivityRenderer).
/// - passivity-memory: the same where a depth gives back only what it has taken (PassivityBound::memory).
/// - virtual-coupling: VirtualCouplingRenderer; stiffness, damping, mass.
/// - hold: the paper's controller, its weights retuned, with release and anti-windup; weights of rate, position
///   and integral, the torque's is 1.
/// - hold-delay: the same with the commands under way among its states (servoForDelay()). A random delay counts as its
///   mean, rounded up.
const std::vector<ControllerSpec>& rivalSpecs();

/// A rival by its name. Throws Error, with the names that there are. Realtime: no.
const ControllerSpec& rivalSpec(const std::string& name);

/// Values of a controller that were found for a device and a delay.
struct ControllerValues {
  std::string controller;           ///< its name
  int delayLow = 0, delayHigh = 0;  ///< ticks
  std::vector<double> values;       ///< one a parameter
};

/// What `enamel design --rivals` writes and `--tuned` of `enamel study` and `enamel compare` reads.
struct ControllerFile {
  std::string model;  ///< the file of the device that they were found for
  std::vector<ControllerValues> controllers;
};

/// Read a file (JSON: "model"; "controllers", a list of {"controller", "delay", the smallest and largest in ticks, and
/// every parameter by its name}). Files of version 0.2 have "laws" and "law" instead. Throws ConfigurationError: the
/// file cannot be read or is not JSON; an unknown controller; a key that is missing or of the wrong type; a value
/// outside its range. Realtime: no.
ControllerFile loadControllers(const std::string& path);

/// Return the file's text. Throws Error: as rivalSpec(). Realtime: no.
std::string controllersText(const ControllerFile& file);

}  // namespace enamel
