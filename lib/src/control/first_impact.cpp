#include "enamel/control/first_impact.hpp"

#include <cmath>

namespace enamel {

bool FirstImpact::add(double gap, double rate, double nextGap, double nextRate, double period) noexcept {
  if (returned_ || !(rate < 0.0 && nextRate >= 0.0)) return false;
  // The cubic's slope on s in [0, 1] is a s^2 + b s + c: negative at 0, not negative at 1, one root between.
  const double before = rate * period, after = nextRate * period, way = nextGap - gap;
  const double a = 3.0 * (before + after) - 6.0 * way, b = 6.0 * way - 4.0 * before - 2.0 * after, c = before;
  const double root = std::sqrt(std::fmax(0.0, b * b - 4.0 * a * c));
  const double s = b >= 0.0 ? -2.0 * c / (b + root) : (root - b) / (2.0 * a);
  const double lowest = gap + s * (c + s * (0.5 * b + s * a / 3.0));
  if (!(lowest < rest_)) return false;
  depth_ = rest_ - lowest;
  returned_ = true;
  return true;
}

}  // namespace enamel
