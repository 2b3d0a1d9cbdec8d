// Parameters of a delta (3-DOF translational parallel haptic device) and their TOML file.
//
// Structure and letters: R. E. Stamper, "A Three Degree of Freedom Parallel Manipulator with Only Translational Degrees
// of Freedom", PhD thesis, University of Maryland, 1997. Dimensions of a desktop device in these letters: S. Martin and
// N. Hillier, "Characterisation of the Novint Falcon haptic device for application as a robot manipulator", ACRA 2009.
// model.hpp contains the geometry and the equations.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "enamel/device/parameters.hpp"

namespace enamel {

/// Stamper's dimensions in m, the same for the three legs. In the frame of a leg, u points outwards. v has the
/// direction of the axes of the base, elbow and platform joints. w is the axis of symmetry, towards the user.
struct DeltaGeometry {
  double a = 0.0;               ///< upper link, from the base joint to the elbow
  double b = 0.0;               ///< bars of the parallelogram
  double c = 0.0;               ///< from the TCP to the platform joint, along u
  double d = 0.0;               ///< from the parallelogram to the platform joint
  double e = 0.0;               ///< from the elbow to the parallelogram
  double f = 0.0;               ///< from the TCP to the platform joint, along v
  double r = 0.0;               ///< from the axis of symmetry to the base joint, along u
  double s = 0.0;               ///< from the axis of symmetry to the base joint, along v
  std::array<double, 3> phi{};  ///< angle of each leg's u from W's x about W's z, rad
};

/// The driven link and the parts that rotate with it, such as the drum and the elbow shaft, but without the rotor.
struct UpperLinkParameters {
  double mass = 0.0;     ///< kg
  double com = 0.0;      ///< distance of the centre of mass from the base joint along the link, m
  double inertia = 0.0;  ///< about the axis v through the centre of mass, kg m^2
};

/// The two bars of a leg's parallelogram, uniform and thin.
struct BarParameters {
  double mass = 0.0;     ///< one bar, kg
  double spacing = 0.0;  ///< distance of the bars along v, m; only for drawing, without effect on the motion
};

/// The body that carries the tool. It does not rotate, so it needs no inertia.
struct DeltaPlatformParameters {
  double mass = 0.0;            ///< kg
  Vec3 damping = Vec3::Zero();  ///< viscous damping of the TCP's velocity, axes of W, N s/m
};

struct DeltaParameters {
  std::string name;
  Vec3 gravity = Vec3::Zero();  ///< in W, m/s^2
  double homeDistance = 0.0;    ///< from the plane of the base joints to W's origin (home), towards the user, m
  DeltaGeometry geometry;
  UpperLinkParameters upperLink;
  BarParameters bar;
  DeltaPlatformParameters platform;
  MotorParameters motor;
  Imperfections imperfections;
};

/// Read a device file with `kind = "delta"`. Realtime: no.
/// Throws ConfigurationError, with file, line, key, value and limit, for:
/// - a file that cannot be read, or malformed TOML;
/// - unknown or missing keys, wrong types, values outside their range;
/// - a leg that does not close at the home pose;
/// - a device of another kind.
DeltaParameters loadDelta(const std::string& path);

/// Read the parameters from text in memory, as loadDelta(); messages name `file`.
DeltaParameters parseDelta(std::string_view text, const std::string& file);

/// Check parameters that did not come from a file. Throws ConfigurationError. Realtime: no.
void checkDelta(const DeltaParameters& parameters);

}  // namespace enamel
