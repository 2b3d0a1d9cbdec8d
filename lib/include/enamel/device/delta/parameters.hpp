// Parameters of a delta (3-DOF translational parallel haptic device) and their TOML file.
//
// Structure and letters: R. E. Stamper, "A Three Degree of Freedom Parallel Manipulator with Only Translational Degrees
// of Freedom", PhD thesis, University of Maryland, 1997; dimensions of a desktop device in these letters: S. Martin and
// N. Hillier, "Characterisation of the Novint Falcon haptic device for application as a robot manipulator", ACRA 2009.
// model.hpp states the geometry and derives the equations.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "enamel/device/parameters.hpp"

namespace enamel {

/// Stamper's dimensions, the same for the three legs; m. In the frame of a leg u points outwards, v along the axes of
/// the leg's base, elbow and platform joints, w along the axis of symmetry towards the user.
struct DeltaGeometry {
  double a = 0.0;               ///< upper link, from the base joint to the elbow
  double b = 0.0;               ///< bars of the parallelogram
  double c = 0.0;               ///< platform joint from the TCP, along u
  double d = 0.0;               ///< from the parallelogram to the platform joint
  double e = 0.0;               ///< from the elbow to the parallelogram
  double f = 0.0;               ///< platform joint from the TCP, along v
  double r = 0.0;               ///< base joint from the axis of symmetry, along u
  double s = 0.0;               ///< base joint from the axis of symmetry, along v
  std::array<double, 3> phi{};  ///< turn of each leg's u from W's x about W's z, rad
};

/// The driven link with all that turns with it except the rotor: drum, elbow shaft.
struct UpperLinkParameters {
  double mass = 0.0;     ///< kg
  double com = 0.0;      ///< centre of mass, along the link from the base joint, m
  double inertia = 0.0;  ///< about the centre of mass and the axis v, kg m^2
};

/// The two bars of a leg's parallelogram: uniform and thin.
struct BarParameters {
  double mass = 0.0;     ///< of one bar, kg
  double spacing = 0.0;  ///< between the two, along v, m; for pictures: the motion does not depend on it
};

/// The body that carries the tool. It does not turn: mass is all that counts.
struct DeltaPlatformParameters {
  double mass = 0.0;            ///< kg
  Vec3 damping = Vec3::Zero();  ///< viscous damping of the TCP's velocity, axes of W, N s/m
};

struct DeltaParameters {
  std::string name;
  Vec3 gravity = Vec3::Zero();  ///< in W, m/s^2
  double homeDistance = 0.0;    ///< of W's origin (the home pose) in front of the plane of the base joints, m
  DeltaGeometry geometry;
  UpperLinkParameters upperLink;
  BarParameters bar;
  DeltaPlatformParameters platform;
  MotorParameters motor;
  Imperfections imperfections;
};

/// Reads a file of `kind = "delta"`. Throws ConfigurationError, with file, line, key, value and limit, on a file that
/// cannot be read, malformed TOML, unknown or missing keys, wrong types, values out of their range, a device of another
/// kind, and a leg that does not close at the home pose. Realtime: no.
DeltaParameters loadDelta(const std::string& path);

/// The same for text in memory; `file` stands in messages.
DeltaParameters parseDelta(std::string_view text, const std::string& file);

/// Checks parameters that did not come from a file. Throws ConfigurationError. Realtime: no.
void checkDelta(const DeltaParameters& parameters);

}  // namespace enamel
