// The immutable model of a TAU device, and the configuration that all algorithms use.
//
// Chain i has the yaw a, the lift b and the elbow c. w = b + c is the absolute elevation of link 2. The unit vectors
// are u = (sin a, 0, cos a), y = (0, 1, 0) and t = (cos a, 0, -sin a). The links, knee and tip are:
//
//   l1 = cos b u + sin b y, knee K = B + L1 l1, l2 = cos w u + sin w y, tip P = K + L2 l2 = p + R r.
//
// The joint angles are q = (a1, b1, a2, b2, a3, b3).
#pragma once

#include <array>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"
#include "enamel/device/tau/parameters.hpp"

namespace enamel {

/// One chain in a configuration; all vectors in W.
struct ChainConfiguration {
  double sinYaw, cosYaw;      ///< of a
  double sinLift, cosLift;    ///< of b
  double sinLink2, cosLink2;  ///< of w = b + c
  double sinElbow;            ///< of c; 0 if the chain is singular
  double radius;              ///< distance of the tip from the yaw axis, m
  Vec3 arm;                   ///< R r, from the TCP to the tip, m
  Vec3 tip;                   ///< tip P, m
};

/// A configuration of the device: the pose, and all chain quantities that follow from it. inverseKinematics() makes it
/// from a pose, forwardKinematics() from joint angles. Plain data.
struct TauConfiguration {
  Pose pose;
  std::array<ChainConfiguration, 3> chain;
};

/// Lengths and inertias of one chain, in the form that the algorithms need.
struct ChainModel {
  Vec3 base, platform;  ///< B in W, r in P, m
  double length1, length2;
  double elbow;           ///< sign of the elbow angle, +1 or -1
  double mass2;           ///< link 2, kg
  Vec3 moment1, moment2;  ///< mass times centre of mass, in the link's frame L, kg m
  Mat3 inertia1;          ///< of link 1 about its proximal joint, axes of L, kg m^2
  Mat3 inertia2;
};

/// Immutable model of a device, made by makeModel(). Threads may share it.
struct TauModel {
  std::array<ChainModel, 3> chain;

  double platformMass;   ///< kg
  Vec3 platformMoment;   ///< mass times centre of mass, in P, kg m
  Mat3 platformInertia;  ///< about the TCP, axes of P, kg m^2
  Vec6 damping;          ///< viscous, of the TCP's twist, N s/m and N m s/rad
  Vec3 gravity;          ///< in W, m/s^2

  double maxTorque;        ///< N m
  double rotorInertia;     ///< kg m^2
  double viscousFriction;  ///< N m s/rad
  double encoderCounts;    ///< counts per revolution of the joint

  std::array<double, 3> side;  ///< distances |r_0 - r_1|, |r_1 - r_2|, |r_2 - r_0|, m
  Mat3 triadInverse;           ///< inverse of [r_1 - r_0, r_2 - r_0, their cross product]
  Vec3 platformCentre;         ///< mean of the r_i, m

  TauConfiguration home;  ///< configuration at P = W
  Vec6 homeAngles;        ///< rad
  double homeSign;        ///< sign of the determinant of the loop equations at home; identifies the branch
};

/// Build the model. Throws ConfigurationError (see checkTau), also if home is a parallel singularity or its mass matrix
/// is not positive definite. Realtime: no.
TauModel makeModel(const TauParameters& parameters);

}  // namespace enamel
