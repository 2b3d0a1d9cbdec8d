// What a surface feels like where it is touched.
#pragma once

#include <limits>

namespace enamel {

/// Rigid and without friction by default.
struct Material {
  double stiffness = std::numeric_limits<double>::infinity();  ///< in series with the wall along the normal, N/m
  double friction = 0.0;                                       ///< mu_s: largest tangential over normal force at rest
  double slidingFriction = 0.0;                                ///< mu_k while it slides, at most mu_s
  double viscosity = 0.0;                                      ///< on the sliding speed, N s/m
};

}  // namespace enamel
