// Friction of a surface from measured slides.
#pragma once

#include <string>
#include <vector>

#include "enamel/identify/identify.hpp"

namespace enamel {

/// A sample of a slide over a real surface, by a force sensor.
struct SlideSample {
  double speed = 0.0;       ///< along the surface, m/s, above 0
  double normal = 0.0;      ///< force of the tool on the surface, N, above 0
  double tangential = 0.0;  ///< friction against the motion, N
};

/// Friction of a surface: keys of a scene file, with 95 % intervals.
struct SurfaceFriction {
  Estimate rest{"friction", ""}, sliding{"sliding_friction", ""}, stribeck{"stribeck_speed", "m/s"},
      viscosity{"viscosity", "N s/m"};
  double error = 0.0;  ///< root mean square of the residual, N
  std::string hidden;  ///< what the slides do not show, and what would show it; empty: nothing
};

/// Estimate the friction of a surface: the model of a sliding contact,
///
///   tangential = normal (mu_k + (mu_s - mu_k) exp(-(speed / v_s)^2)) + viscosity speed
///
/// by least squares, with numbers that are not negative. Samples are in the order of measurement: the intervals are
/// those of the jackknife over 20 blocks of them (M. Quenouille 1956, J. Tukey 1958), and hold also if neighbours have
/// similar errors. If mu_s does not differ from mu_k by more than its interval, v_s is not seen, and mu_s = mu_k.
/// Throws Error for fewer than 100 samples, or a number that is not finite or not above 0. Realtime: no.
SurfaceFriction fitFriction(const std::vector<SlideSample>& slides);

/// Read slides from a text file of three numbers a line, separated by commas or spaces: speed (m/s), normal and
/// tangential force (N). A heading in words and lines that begin with # are skipped. Throws Error with the number of a
/// wrong line. Realtime: no.
std::vector<SlideSample> loadSlides(const std::string& file);

}  // namespace enamel
