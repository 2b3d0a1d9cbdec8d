// The laws that stand in one table with the contact-space servo, each with its numbers open.
#pragma once

#include "enamel/study/wall_design.hpp"

namespace enamel {

/// The contact-space servo: its numbers are surfaceServoParameters(), those of `start` where the search begins.
Law surfaceServoLaw(const SurfaceServoOptions& start);

/// `start` with other numbers, one for each of surfaceServoParameters(). Throws Error: a wrong number of them.
SurfaceServoOptions surfaceServoWith(const SurfaceServoOptions& start, const std::vector<double>& values);

/// The rivals:
/// - impedance: a spring and a damper on the depth (ImpedanceRenderer); stiffness, damping.
/// - passivity: the same under a time-domain passivity controller (PassivityRenderer).
/// - passivity-memory: the same where a depth gives back only what it has taken (PassivityBound::memory).
/// - virtual-coupling: VirtualCouplingRenderer; stiffness, damping, mass.
/// - hold: the paper's position control, its weights retuned, with release and anti-windup; weights of rate, position
///   and integral, the torque's is 1.
/// - hold-delay: the same with the commands under way among its states (servoForDelay()). A random delay counts as its
///   mean, rounded up.
const std::vector<Law>& rivalLaws();

/// A rival by its name. Throws Error, with the names that there are. Realtime: no.
const Law& rivalLaw(const std::string& name);

/// Values of a law that were found for a device and a delay.
struct LawValues {
  std::string law;
  int delayLow = 0, delayHigh = 0;  ///< ticks
  std::vector<double> values;       ///< one a parameter of the law
};

/// What `enamel design --rivals` writes and `enamel study --laws` reads.
struct LawFile {
  std::string model;  ///< the file of the device that they were found for
  std::vector<LawValues> laws;
};

/// Reads a file (JSON: "model"; "laws", a list of {"law", "delay", the smallest and largest in ticks, and every
/// parameter by its name}). Throws ConfigurationError: the file cannot be read or is not JSON; a law that there is not;
/// a key that is missing or of the wrong type; a value outside its range. Realtime: no.
LawFile loadLaws(const std::string& path);

/// The file's text. Throws Error: as rivalLaw(). Realtime: no.
std::string lawsText(const LawFile& file);

}  // namespace enamel
