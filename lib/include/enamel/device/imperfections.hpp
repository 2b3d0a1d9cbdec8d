// What a real device has and an ideal one has not: its motors, transmissions, encoders and tolerances. Nothing of it is
// in a Mechanism; the imperfect plant takes it (sim/imperfect_plant.hpp).
#pragma once

namespace enamel {

/// The table [imperfections] of a device file. Zero, the default, is ideal. Everything at the joint's side and the same
/// at every driven joint; where the magnitudes of the shipped file come from: data/README.md.
struct Imperfections {
  double currentBandwidth = 0.0;  ///< f of the current loop: torque' = 2 pi f (command - torque), Hz; 0: no lag
  double torqueStep = 0.0;        ///< of the amplifier, which rounds, N m
  double torqueRipple = 0.0;      ///< amplitude, share of the torque
  double cogging = 0.0;           ///< amplitude, N m
  double periods = 0.0;           ///< of ripple and cogging in a turn of the joint
  double coulombFriction = 0.0;   ///< N m
  double cableStiffness = 0.0;    ///< between rotor and link, N m/rad; 0: rigid
  double cableDamping = 0.0;      ///< N m s/rad
  double backlash = 0.0;          ///< the whole play between rotor and link, rad; only with a cable that is not rigid
  double encoderOffset = 0.0;     ///< each joint's is uniform within +- this, rad
  double lengthError = 0.0;       ///< relative, each length's uniform within +- this
  double massError = 0.0;         ///< the same of each body's mass and inertia
  double jitter = 0.0;            ///< each tick comes late by up to this share of the period, uniform
  double lostSamples = 0.0;       ///< share of the ticks at which nothing comes from the device
};

}  // namespace enamel
