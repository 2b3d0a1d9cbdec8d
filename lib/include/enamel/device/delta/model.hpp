// The immutable model of a delta and the configuration that every algorithm works on.
//
// Frames. The base frame B has the axes of W and its origin on the axis of symmetry in the plane of the base joints:
// p_B = p + (0, 0, h), h the home distance. Leg i turns B by phi_i about z: u outwards, v across, w = z.
//
// Geometry of a leg (Stamper 1997, with the letters of parameters.hpp; f and s are both offsets across the leg, along
// v, so only f - s matters, as only r - c does of the radii):
//   base joint, axis v            B  = (r, s, 0)
//   elbow, axis v                 K  = B + a l1,           l1 = (cos t1, 0, sin t1)
//   centre of the near crossbar   E  = K + e l2,           l2 = (cos t2, 0, sin t2)
//   centre of the far crossbar    G  = E + b n,            n  = (sin t3 cos t2, cos t3, sin t3 sin t2)
//   platform joint, axis v        A  = G + d l2  =  p + (c, f, 0)
// where t1 is the driven angle, positive towards the user, t2 the inclination of the parallelogram and t3 the angle of
// its bars from v. Both bars have the direction n and the crossbars stay parallel to v: the platform cannot turn.
// With x = u.p + c - r, y = v.p + f - s, z = w.p + h, L = d + e + b sin t3 and the elbow g = t2 - t1 this is
//   x = a cos t1 + L cos t2,  y = b cos t3,  z = a sin t1 + L sin t2.                                             (1)
// Rates: (1) differentiated, projected on l2, l1 and v:
//   t1' = (x' cos t2 + y' cot t3 + z' sin t2) / (a sin g),                                                         (2)
//   t2' = -(x' cos t1 + y' cot t3 cos g + z' sin t1) / (L sin g),   t3' = -y' / (b sin t3).                         (3)
// Joint coordinates q = (t1 of leg 0, 1, 2).
//
// Branch: elbows outwards (sin g > 0), 0 < t3 < pi, lower links leaning towards the user (sin t2 > 0) and the bars'
// directions in the order of home (sign of their determinant). Seen from the platform, its joint is on the surface of a
// convex body about each elbow (a disc of radius d + e in the leg's plane, rounded by b), on the side of the user.
// Three such surfaces meet once on this branch: certainly for d + e = 0 (spheres); otherwise found by search, not
// proven (tests/hard/delta.cpp).
#pragma once

#include <array>

#include "enamel/core/types.hpp"
#include "enamel/device/delta/parameters.hpp"

namespace enamel {

/// One leg in a given configuration.
struct DeltaLeg {
  double cos1, sin1;          ///< of t1
  double cos2, sin2;          ///< of t2
  double cos3, sin3;          ///< of t3
  double cosElbow, sinElbow;  ///< of t2 - t1
  double reach;               ///< L, m
  Vec3 row;                   ///< t1' = row . v, axes of W, rad/m
};

/// A configuration of the device: the position and everything about the legs that follows from it. Plain data.
struct DeltaConfiguration {
  Vec3 position;  ///< of the TCP, m
  std::array<DeltaLeg, 3> leg;
  double parallel;  ///< determinant of the bars' directions, positive as at home; 0 where the platform gains a freedom
};

/// Immutable model of a device. Made by makeModel(); safe to share between threads.
struct DeltaModel {
  std::array<double, 3> cosPhi, sinPhi;
  double a, b, e;
  double link;          ///< d + e, m
  double radial;        ///< r - c, m
  double lateral;       ///< f - s, m
  double homeDistance;  ///< h, m
  double order;         ///< +1 or -1: makes the determinant of the bars' directions positive at home

  double upperInertia;  ///< of upper link and rotor about the base joint, kg m^2
  double upperMoment;   ///< mass times centre of mass along l1, kg m
  double barsMass;      ///< of both bars of a leg, kg
  double platformMass;  ///< kg
  double friction;      ///< N m s/rad
  Vec3 damping;         ///< N s/m
  Vec3 gravity;         ///< in W, m/s^2
};

/// Builds the model. Throws ConfigurationError (see checkDelta). Realtime: no.
DeltaModel makeModel(const DeltaParameters& parameters);

}  // namespace enamel
