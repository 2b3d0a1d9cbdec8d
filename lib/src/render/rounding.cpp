#include "render/rounding.hpp"

#include <algorithm>
#include <cmath>

namespace enamel {

// With z = (x - expected) / d, d^2 the variance of all that is Gaussian, the reading says that z is within [l, u]. The
// moments of a truncated Gaussian, from the side on which its mean is.
Evidence evidenceOf(double innovation, double expected, const Rounding& rounding) noexcept {
  constexpr double kNarrow = 0.1, kFar = 12.0, kRootTwoPi = 2.5066282746310002;
  const double uniform = rounding.largest * rounding.largest / 12.0, variance = expected + rounding.variance;
  const double gaussian = variance - uniform, d = std::sqrt(gaussian), width = rounding.largest / d;
  const double centre = std::abs(innovation) / d, l = centre - 0.5 * width, u = centre + 0.5 * width;
  if (width < kNarrow || l > kFar)
    return {innovation, variance, innovation * innovation / variance, std::sqrt(variance / rounding.variance)};
  const double atL = std::exp(-0.5 * l * l) / kRootTwoPi, atU = std::exp(-0.5 * u * u) / kRootTwoPi;
  const double share = 0.5 * (std::erfc(l / M_SQRT2) - std::erfc(u / M_SQRT2));
  const double mean = (atL - atU) / share, shrinks = mean * mean - (l * atL - u * atU) / share;
  const double as = gaussian / std::clamp(shrinks, 1e-9, 1.0);
  return {std::copysign(mean, innovation) * as / d, as, 0.0,
          rounding.largest / (kRootTwoPi * std::sqrt(rounding.variance) * share)};
}

}  // namespace enamel
