// Formats numbers for people, rounded to their significant digits.
#pragma once

#include <string>

#include "enamel/study/monte_carlo.hpp"

namespace enamel::app {

/// Round to a power of ten; with a typographic minus and groups of three digits.
std::string placedText(double value, int place);

/// Format with `digits` significant digits; 1.2 × 10⁻⁵ if far from 1; "–" if not finite.
std::string numberText(double value, int digits = 3);

/// Format a given (not measured) number.
std::string givenText(double value);

/// Format all digits for a table of CSV; empty if not finite.
std::string cellText(double value);

/// Return half of the 95 % confidence interval of a mean (Student's t). NaN: fewer than two values.
double halfInterval(const Spread& spread);

/// "18 240 ± 130": half interval with two digits, mean rounded to the same place. Without an interval: three digits.
/// "0" if below 1e-9.
std::string meanText(double mean, double half);
/// Format a mean and its 95 % interval, times `scale`.
std::string meanText(const Spread& spread, double scale = 1.0);

/// Format K_zs = 1 / |mean C_zs| with the 95 % interval that follows from the compliance's, times `scale`: "92 400 (89
/// 100 to 95 900)".
std::string steadyText(const Spread& compliance, double scale = 1.0);

}  // namespace enamel::app
