// Metrics of a tap: how hard a surface feels when the tool hits it. lib/docs/taps.md has their sources.
#pragma once

#include <vector>

#include "enamel/collision/material.hpp"

namespace enamel {

/// One sample of a tap, along the outward normal of the surface.
struct TapSample {
  double time;          ///< s, increasing
  double gap;           ///< of the tool, m; negative inside
  double rate;          ///< of the gap, m/s
  double acceleration;  ///< of the handle, mean until the next sample, m/s^2
  double force;         ///< of the surface on the tool until the next sample, N
};

/// Metrics of one tap. NaN: the trace does not have it.
struct TapMetrics {
  double speed;  ///< last approach speed without a force, v, m/s
  double
      rateHardness;  ///< mean rate of the force in its first two sample intervals, over v, N/m (Lawrence et al. 2000)
  double extendedRateHardness;  ///< largest rate until 30 ms after the touch, over v, N/m (Han and Choi 2010)
  double dynamicStiffness;      ///< |F(f)| / |X(f)| at 250 to 350 Hz, X: depth, N/m (Higashi et al. 2019)
  double match;                 ///< matchOf() the handle's acceleration and that of the material, 0 to 1
};

/// Compute the metrics. The window is 5 ms before to 60 ms after the touch, the instant when the gap becomes negative.
/// `material`: for the match. Realtime: no.
TapMetrics tapMetrics(const std::vector<TapSample>& trace, const Tap& material);

/// Return the mean acceleration of the handle on a material from one time to another, 1/s. The tap at 1 m/s is at time
/// 0: a(t) = (B^2 + w^2) / w exp(-B t) sin(w t). Realtime: yes.
double accelerationOf(const Tap& material, double from, double until) noexcept;

/// Return how well two signals match: 2 sum |A||M| / (sum |A|^2 + sum |M|^2) over their amplitude spectra. The band is
/// 20 Hz to the lower of 1000 Hz and half of the sampling rate. Equal spectra give 1. A factor g between them gives 2 g
/// / (1 + g^2). Samples are `period` s apart. Realtime: no.
double matchOf(const std::vector<double>& signal, const std::vector<double>& other, double period);

}  // namespace enamel
