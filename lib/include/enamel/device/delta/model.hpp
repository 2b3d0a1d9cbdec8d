// The immutable model of a delta, and the configuration that all algorithms use.
//
// Frames. The base frame B has the axes of W. Its origin is on the axis of symmetry, in the plane of the base joints:
// p_B = p + (0, 0, h), where h is the home distance. Leg i rotates B by phi_i about z: u outwards, v across, w = z.
//
// Geometry of a leg (Stamper 1997, with the letters of parameters.hpp):
//
// - base joint, axis v            B  = (r, s, 0)
// - elbow, axis v                 K  = B + a l1,           l1 = (cos t1, 0, sin t1)
// - centre of the near crossbar   E  = K + e l2,           l2 = (cos t2, 0, sin t2)
// - centre of the far crossbar    G  = E + b n,            n  = (sin t3 cos t2, cos t3, sin t3 sin t2)
// - platform joint, axis v        A  = G + d l2  =  p + (c, f, 0)
//
// t1 is the driven angle, positive towards the user. t2 is the inclination of the parallelogram. t3 is the angle of its
// bars from v. f and s are offsets across the leg, along v, so only f - s matters. Of the radii only r - c matters.
// Both bars have the direction n, and the crossbars stay parallel to v. The platform therefore cannot rotate.
//
// With x = u.p + c - r, y = v.p + f - s, z = w.p + h, L = d + e + b sin t3 and the elbow angle g = t2 - t1:
//
//   x = a cos t1 + L cos t2,  y = b cos t3,  z = a sin t1 + L sin t2.                                             (1)
//
// The derivative of (1), projected on l2, l1 and v, gives the rates:
//
//   t1' = (x' cos t2 + y' cot t3 + z' sin t2) / (a sin g),                                                        (2)
//
//   t2' = -(x' cos t1 + y' cot t3 cos g + z' sin t1) / (L sin g),   t3' = -y' / (b sin t3).                       (3)
//
// The joint coordinates are q = (t1 of leg 0, 1, 2).
//
// Branch of home:
// - the elbows point outwards (sin g > 0), and 0 < t3 < pi;
// - the lower links lean towards the user (sin t2 > 0);
// - the bars' directions have the order of home (sign of their determinant).
//
// Seen from the platform, a platform joint is on a convex surface about its elbow, on the side of the user. The surface
// is a disc of radius d + e in the leg's plane, rounded by b. Three such surfaces meet in one point on this branch. For
// d + e = 0 (spheres) this is certain. Otherwise it is the result of a search, without proof (tests/hard/delta.cpp).
#pragma once

#include <array>

#include "enamel/core/types.hpp"
#include "enamel/device/delta/parameters.hpp"

namespace enamel {

/// One leg in a configuration.
struct DeltaLeg {
  double cos1, sin1;          ///< of t1
  double cos2, sin2;          ///< of t2
  double cos3, sin3;          ///< of t3
  double cosElbow, sinElbow;  ///< of t2 - t1
  double reach;               ///< L, m
  Vec3 row;                   ///< t1' = row . v, axes of W, rad/m
};

/// A configuration of the device: the position, and all leg quantities that follow from it. Plain data.
struct DeltaConfiguration {
  Vec3 position;  ///< TCP, m
  std::array<DeltaLeg, 3> leg;
  double parallel;  ///< determinant of the bars' directions; positive as at home, 0 at a parallel singularity
};

/// Immutable model of a device, made by makeModel(). Threads may share it.
struct DeltaModel {
  std::array<double, 3> cosPhi, sinPhi;
  double a, b, e;
  double link;          ///< d + e, m
  double radial;        ///< r - c, m
  double lateral;       ///< f - s, m
  double homeDistance;  ///< h, m
  double order;         ///< +1 or -1; makes the determinant of the bars' directions positive at home

  double upperInertia;  ///< of the upper link and rotor about the base joint, kg m^2
  double upperMoment;   ///< mass times distance of the centre of mass along l1, kg m
  double barsMass;      ///< both bars of a leg, kg
  double platformMass;  ///< kg
  double friction;      ///< viscous, of each driven joint, N m s/rad
  Vec3 damping;         ///< viscous, of the TCP's velocity, N s/m
  Vec3 gravity;         ///< in W, m/s^2
};

/// Build the model. Throws ConfigurationError (see checkDelta). Realtime: no.
DeltaModel makeModel(const DeltaParameters& parameters);

}  // namespace enamel
