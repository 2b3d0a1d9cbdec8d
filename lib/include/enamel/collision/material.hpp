// Mechanical properties of a surface at a contact.
#pragma once

#include <limits>

namespace enamel {

/// Material of a surface. Default: rigid and without friction.
struct Material {
  double stiffness = std::numeric_limits<double>::infinity();  ///< along the normal, in series with the wall, N/m
  double friction = 0.0;         ///< mu_s, largest ratio of tangential to normal force at rest
  double slidingFriction = 0.0;  ///< mu_k while sliding, at most mu_s
  double viscosity = 0.0;        ///< on the sliding speed, N s/m
};

}  // namespace enamel
