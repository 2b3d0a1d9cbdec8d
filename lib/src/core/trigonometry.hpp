// Sines and cosines of several angles at once. Forward kinematics spends half of its time here.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace enamel {

/// Compute sine and cosine of each angle, rad, within 1 ulp. The multiple of pi/2 is subtracted in three parts of 33
/// bits (Cody and Waite 1980). Taylor's series to the 17th power follows; its remainder is below 1e-18 on +-pi/4. It
/// works element by element without a table, so all machines give the same bits. Finite angles only. Realtime: yes.
template <int n>
void sinCos(const Eigen::Array<double, n, 1>& angle, Eigen::Array<double, n, 1>& sine,
            Eigen::Array<double, n, 1>& cosine) noexcept {
  using Array = Eigen::Array<double, n, 1>;
  constexpr double kLargest = 1e5;  // larger multiples have too many digits
  if (!(angle.abs() <= kLargest).all()) {
    for (int i = 0; i < n; ++i) sine[i] = std::sin(angle[i]), cosine[i] = std::cos(angle[i]);
    return;
  }
  constexpr double kHigh = 0x1.921fb544p+0, kMiddle = 0x1.0b4611a6p-34, kLow = 0x1.3198a2e037073p-69;  // pi / 2
  constexpr double kRound = 0x1.8p+52;
  const Array k = (angle * M_2_PI + kRound) - kRound;
  const Array r = ((angle - kHigh * k) - kMiddle * k) - kLow * k, s = r * r;
  constexpr double f3 = -1.0 / 6, f5 = 1.0 / 120, f7 = -1.0 / 5040, f9 = 1.0 / 362880, f11 = -1.0 / 39916800,
                   f13 = 1.0 / 6227020800, f15 = -1.0 / 1307674368000, f17 = 1.0 / 355687428096000;
  constexpr double f4 = 1.0 / 24, f6 = -1.0 / 720, f8 = 1.0 / 40320, f10 = -1.0 / 3628800, f12 = 1.0 / 479001600,
                   f14 = -1.0 / 87178291200, f16 = 1.0 / 20922789888000;
  const Array odd = r + r * s * (f3 + s * (f5 + s * (f7 + s * (f9 + s * (f11 + s * (f13 + s * (f15 + s * f17)))))));
  const Array even = 1.0 - (0.5 * s - s * s * (f4 + s * (f6 + s * (f8 + s * (f10 + s * (f12 + s * (f14 + s * f16)))))));
  for (int i = 0; i < n; ++i) {
    const auto quadrant = static_cast<int>(k[i]);
    const double a = quadrant & 1 ? even[i] : odd[i], b = quadrant & 1 ? odd[i] : even[i];
    sine[i] = quadrant & 2 ? -a : a;
    cosine[i] = (quadrant + 1) & 2 ? -b : b;
  }
}

}  // namespace enamel
