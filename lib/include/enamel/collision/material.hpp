// Mechanical properties of a surface at a contact.
#pragma once

#include <cmath>
#include <limits>
#include <string>

namespace enamel {

/// Material of a surface. Default: rigid and without friction. A compliant one is in series with the wall. Its force at
/// a compression of x m, which grows by x' m/s, is (forceOf(), render/compliance.hpp):
///
///   F = stiffness x (x / 1 mm)^(exponent - 1) / (1 - x / thickness) max(0, 1 + hysteresis x')
struct Material {
  double stiffness = std::numeric_limits<double>::infinity();  ///< along the normal, N/m: force over x at 1 mm
  double friction = 0.0;         ///< mu_s, largest ratio of tangential to normal force at rest
  double slidingFriction = 0.0;  ///< mu_k while sliding, at most mu_s
  double viscosity = 0.0;        ///< on the sliding speed, N s/m
  double exponent = 1.0;         ///< 1: linear, 1.5: a ball on a half space (Hertz); 1 to kLargestExponent
  double thickness = std::numeric_limits<double>::infinity();  ///< at which the layer bottoms out, m
  double hysteresis = 0.0;  ///< damping in proportion to the force (Hunt and Crossley 1975), s/m
  double puncture = std::numeric_limits<double>::infinity();  ///< force that pierces the layer, N; needs a thickness

  /// Return whether the force is more than stiffness times compression. Realtime: yes.
  bool isLayer() const noexcept { return exponent != 1.0 || !std::isinf(thickness) || hysteresis != 0.0; }
};

/// Largest viscosity, N s/m: larger values make every tick unstable.
inline constexpr double kLargestViscosity = 1000.0;
inline constexpr double kLargestExponent = 10.0;     ///< of a material
inline constexpr double kLargestHysteresis = 100.0;  ///< of a material, s/m

/// Multiply the forces of a material by a factor, for a scene in another scale. Realtime: yes.
inline void scaleForces(Material& material, double factor) noexcept {
  material.stiffness *= factor;
  material.viscosity *= factor;
  material.puncture *= factor;
}

/// Throw Error, beginning with `name`, if a number of the material is outside its range. Realtime: no.
void checkMaterial(const Material& material, const std::string& name);

}  // namespace enamel
