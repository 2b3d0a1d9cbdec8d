// What a rounded reading says of a number that was expected with a Gaussian uncertainty.
#pragma once

namespace enamel {

/// Rounding of a sum of encoder readings: variance of all, and the largest step among them. The largest is uniform, and
/// says nothing within itself; the sum of the others is taken as Gaussian.
struct Rounding {
  double variance = 0.0, largest = 0.0;
};

/// As a reading with Gaussian noise that leaves the same mean and variance; its likelihood is exp(-square / 2) / volume,
/// over that of a reading as sharp as its rounding.
struct Evidence {
  double innovation, variance, square, volume;
};

/// Of a reading that differs from its expected value by `innovation`, which had the variance `expected`. Realtime: yes.
Evidence evidenceOf(double innovation, double expected, const Rounding& rounding) noexcept;

}  // namespace enamel
