#include "study/numbers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "enamel/study/paired.hpp"

namespace enamel::app {
namespace {

constexpr double kNothing = 1e-9;  // in the units of tables: rounding errors of a simulation

// Return the decimal place of the last of `digits` significant digits.
int placeOf(double value, int digits) {
  const std::string text = fmt::format("{:.{}e}", value, digits - 1);
  return std::stoi(text.substr(text.find('e') + 1)) - digits + 1;
}

// "10⁻⁵"
std::string powerText(int power) {
  std::string text = power < 0 ? "10⁻" : "10";
  for (const char c : std::to_string(std::abs(power)))
    text += std::array{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"}[static_cast<std::size_t>(c - '0')];
  return text;
}

// All other numbers are written with a power of ten.
bool isPlain(int power) { return power >= -4 && power < 6; }

}  // namespace

std::string placedText(double value, int place) {
  const double unit = std::pow(10.0, place), rounded = std::round(std::abs(value) / unit) * unit;
  std::string text = fmt::format("{:.{}f}", rounded, std::max(0, -place));
  const std::size_t whole = std::min(text.find('.'), text.size());
  for (std::size_t i = whole; whole > 4 && i > 3; i -= 3) text.insert(i - 3, " ");
  return (value < 0.0 && rounded > 0.0 ? "−" : "") + text;
}

std::string numberText(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  if (value == 0.0) return "0";
  const int place = placeOf(value, digits), power = place + digits - 1;
  if (isPlain(power)) return placedText(value, place);
  const std::string mantissa = placedText(value / std::pow(10.0, power), 1 - digits);
  return (mantissa == "1" ? "" : mantissa + " × ") + powerText(power);
}

std::string cellText(double value) { return std::isfinite(value) ? fmt::format("{}", value) : ""; }

std::string givenText(double value) { return fmt::format("{:.6g}", value); }

double halfInterval(const Spread& spread) { return meanDifference(spread).half; }

std::string meanText(double mean, double half) {
  if (!std::isfinite(mean)) return "–";
  if (std::abs(mean) + (half > 0.0 ? half : 0.0) < kNothing) return "0";
  if (!(half > 0.0)) return numberText(mean);
  const int power = placeOf(std::max(std::abs(mean), half), 1), place = placeOf(half, 2);
  if (isPlain(power)) return placedText(mean, place) + " ± " + placedText(half, place);
  const double scale = std::pow(10.0, -power);
  return "(" + meanText(scale * mean, scale * half) + ") × " + powerText(power);
}

std::string meanText(const Spread& spread, double scale) {
  return meanText(scale * spread.mean, scale * halfInterval(spread));
}

std::string steadyText(const Spread& compliance, double scale) {
  const double c = std::abs(compliance.mean), half = halfInterval(compliance), k = scale / c;
  if (!(half > 0.0)) return numberText(k);
  if (const int power = placeOf(k, 1); !isPlain(power))
    return steadyText(compliance, scale * std::pow(10.0, -power)) + " × " + powerText(power);
  const double low = scale / (c + half), high = scale / (c - half);
  const int place = placeOf(k - low, 2);
  const std::string to = high > 0.0 && std::isfinite(high) ? " to " + placedText(high, place) : " or more";
  return placedText(k, place) + " (" + placedText(low, place) + to + ")";
}

}  // namespace enamel::app
