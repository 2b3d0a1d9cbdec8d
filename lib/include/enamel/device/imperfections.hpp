// Imperfections of a real device: motors, transmissions, encoders and tolerances. The imperfect plant simulates them
// (sim/imperfect_plant.hpp). A Mechanism holds only those in its Drive.
#pragma once

namespace enamel {

inline constexpr double kLargestBandwidth = 1e6;  ///< Hz, of a current loop in a device file

/// The table [imperfections] of a device file. Zero, the default, means ideal. All values are at the joint's side and
/// the same for all driven joints. On Cartesian devices N m means N, and rad means m. data/README.md gives the sources
/// of the values in the shipped file.
struct Imperfections {
  double currentBandwidth = 0.0;  ///< f of the current loop, Hz: torque' = 2 pi f (command - torque); 0: no lag
  double torqueStep = 0.0;        ///< rounding step of the amplifier, N m
  double torqueRipple = 0.0;      ///< amplitude, as a fraction of the torque
  double cogging = 0.0;           ///< amplitude, N m
  double periods = 0.0;           ///< of ripple and cogging, in one turn of a joint or 2 pi m of an axis
  double coulombFriction = 0.0;   ///< N m
  double cableStiffness = 0.0;    ///< stiffness between rotor and link, N m/rad; 0: rigid
  double cableDamping = 0.0;      ///< N m s/rad
  double backlash = 0.0;          ///< whole play between rotor and link, rad; only if the cable is not rigid
  double encoderOffset = 0.0;     ///< uniform within +- this for each joint, rad
  double lengthError = 0.0;       ///< relative error, uniform within +- this for each length
  double massError = 0.0;         ///< relative error, uniform within +- this for the mass and inertia of each body
  double jitter = 0.0;            ///< largest delay of a tick, as a fraction of the period; uniform
  double lostSamples = 0.0;       ///< fraction of the ticks without a sample from the device
};

}  // namespace enamel
