// Mechanical properties of a surface at a contact.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace enamel {

/// How a handle vibrates after a tap at v m/s: a(t) = v (B^2 + w^2) / w exp(-B t) sin(w t), w = 2 pi f. This force
/// stops the tool. Source of the waveform: Okamura, Cutkosky and Dennerlein 2001.
struct Tap {
  double frequency = 0.0;  ///< f, 10 to 1000 Hz; 0: no transient
  double decay = 0.0;      ///< B, 0 to 2000 1/s
};

/// The taps that have a name. lib/docs/taps.md shows where the numbers are from.
struct NamedTap {
  const char* name;
  Tap tap;
};
inline constexpr std::array<NamedTap, 4> kNamedTaps = {
    {{"enamel", {310.0, 90.0}}, {"dentine", {200.0, 86.0}}, {"metal", {300.0, 90.0}}, {"plastic", {90.0, 80.0}}}};

/// Return the tap of a name. Throws Error for another name. Realtime: no.
Tap tapOf(const std::string& name);

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
  double stribeck = 0.0;    ///< sliding speed at which friction has fallen by 63 % of mu_s - mu_k, m/s; 0: at once
  double roughness = 0.0;   ///< root mean square height of the surface (render/roughness.hpp), m; 0: smooth
  double wavelength = 0.0;  ///< longest one of a rough surface, m

  /// Return whether the force is more than stiffness times compression. Realtime: yes.
  bool isLayer() const noexcept { return exponent != 1.0 || !std::isinf(thickness) || hysteresis != 0.0; }

  /// Return whether the surface is too rough for its longest wavelength. Realtime: yes.
  bool isTooSteep() const noexcept;

  /// Return the ratio of tangential to normal force while sliding at a speed, m/s, without viscosity. Realtime: yes.
  double slidingRatio(double speed) const noexcept {
    if (!(stribeck > 0.0)) return slidingFriction;
    return slidingFriction + (friction - slidingFriction) * std::exp(-(speed / stribeck) * (speed / stribeck));
  }
};

/// Largest viscosity, N s/m: larger values make every tick unstable.
inline constexpr double kLargestViscosity = 1000.0;
inline constexpr double kLargestExponent = 10.0;     ///< of a material
inline constexpr double kLargestHysteresis = 100.0;  ///< of a material, s/m
inline constexpr double kLargestStribeck = 10.0;     ///< of a material, m/s
inline constexpr double kLongestWave = 0.01;         ///< of a material, m
inline constexpr double kSteepestRoughness = 0.02;   ///< roughness over wavelength: slopes are then about 0.4

inline bool Material::isTooSteep() const noexcept {
  constexpr double kRounding = 1e-9;  // of numbers with a few digits
  return roughness > kSteepestRoughness * (1.0 + kRounding) * wavelength;
}

/// Multiply the forces of a material by a factor, for a scene in another scale. Realtime: yes.
inline void scaleForces(Material& material, double factor) noexcept {
  material.stiffness *= factor;
  material.viscosity *= factor;
  material.puncture *= factor;
}

/// Throw Error, beginning with `name`, if a number of the tap is outside its range. Realtime: no.
void checkTap(const Tap& tap, const std::string& name);

/// Throw Error, beginning with `name`, if a number of the material is outside its range. Realtime: no.
void checkMaterial(const Material& material, const std::string& name);

}  // namespace enamel
