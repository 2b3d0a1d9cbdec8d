// Mechanical properties of a surface at a contact.
#pragma once

#include <limits>
#include <string>

namespace enamel {

/// Material of a surface. Default: rigid and without friction.
struct Material {
  double stiffness = std::numeric_limits<double>::infinity();  ///< along the normal, in series with the wall, N/m
  double friction = 0.0;         ///< mu_s, largest ratio of tangential to normal force at rest
  double slidingFriction = 0.0;  ///< mu_k while sliding, at most mu_s
  double viscosity = 0.0;        ///< on the sliding speed, N s/m
};

/// Largest viscosity, N s/m: larger values make every tick unstable.
inline constexpr double kLargestViscosity = 1000.0;

/// Throw Error, beginning with `name`, if a number of the material is outside its range. Realtime: no.
void checkMaterial(const Material& material, const std::string& name);

}  // namespace enamel
