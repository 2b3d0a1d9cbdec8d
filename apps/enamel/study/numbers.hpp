// Numbers as people read them: rounded to what is known of them.
#pragma once

#include <string>

#include "enamel/study/monte_carlo.hpp"

namespace enamel::app {

/// Rounded to a power of ten, with a true minus and groups of three.
std::string placedText(double value, int place);

/// To so many digits, 1.2 × 10⁻⁵ where it is far from 1; "–" for what is not finite.
std::string numberText(double value, int digits = 3);

/// A number that is given, not measured.
std::string givenText(double value);

/// Half of the 95 % interval of a mean, by Student's t. NaN: fewer than two values.
double halfInterval(const Spread& spread);

/// "18 240 ± 130": the half interval to two digits, the mean to the same place; without an interval to three digits;
/// "0" below 1e-9.
std::string meanText(double mean, double half);
/// A mean and its 95 % interval, times `scale`.
std::string meanText(const Spread& spread, double scale = 1.0);

/// K_zs = 1 / |mean C_zs| and the 95 % interval that the compliance's becomes, "92 400 (89 100 to 95 900)", times
/// `scale`.
std::string steadyText(const Spread& compliance, double scale = 1.0);

}  // namespace enamel::app
