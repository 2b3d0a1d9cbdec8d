#include "design_expectation.hpp"

#include <fmt/core.h>

#include <cmath>

namespace enamel::app {
namespace {

constexpr double kHelps = 0.05;  // smaller gains are not worth mentioning

// Two standard errors of a mean, as a share of it.
double errorOf(const Spread& s) { return 2.0 * s.deviation / (s.mean * std::sqrt(static_cast<double>(s.count))); }

void printSprings(const std::vector<WallExpectation>& expectations) {
  fmt::print("The best spring that a search with other pushes found, under the same pushes:\n");
  fmt::print("{:>5} {:>10} {:>14} {:>13} {:>5}  {}\n", "delay", "K_d", "spring", "damping", "lost",
             "position control is stiffer by a factor of");
  fmt::print("{:>5} {:>10} {:>14} {:>13}\n", "ticks", "kN/m", "kN/m", "N s/m");
  for (const WallExpectation& e : expectations) {
    if (e.springStiffness.count == 0) {
      fmt::print("{:>5} every spring of the search loses a run\n", e.delay);
      continue;
    }
    const double ratio = e.stiffness.mean / e.springStiffness.mean;
    fmt::print("{:>5} {:>10.3g} {:>14.4g} {:>13.4g} {:>5}  {:.2f} +- {:.2f}\n", e.delay, 1e-3 * e.springStiffness.mean,
               1e-3 * e.spring.stiffness, e.spring.damping, e.springLost, ratio,
               ratio * std::hypot(errorOf(e.stiffness), errorOf(e.springStiffness)));
  }
  fmt::print("+-: two standard errors.\n\n");
}

}  // namespace

std::string helpOf(const WallExpectation& e) {
  std::string text;
  for (const DeviceChange& change : e.changes)
    if (change.gain > kHelps)
      text += fmt::format("{}{}: {:+.0f} %", text.empty() ? "" : "; ", change.name, 100.0 * change.gain);
  return text.empty() ? "no change above 5 %" : text;
}

void printExpectation(const std::vector<WallExpectation>& expectations, double period, double damping,
                      bool withSpring) {
  fmt::print("Position control, estimated from {} simulated pushes at home along z, with encoders:\n",
             expectations.front().runs);
  fmt::print("{:>5} {:>10} {:>9} {:>7} {:>10} {:>14} {:>5}  {}\n", "delay", "K_d", "chatter", "bounce", "safe push",
             "passive spring", "lost", "what would help");
  fmt::print("{:>5} {:>10} {:>9} {:>7} {:>10} {:>14}\n", "ticks", "kN/m", "N m or N", "um", "N", "kN/m");
  for (const WallExpectation& e : expectations)
    fmt::print("{:>5} {:>10.3g} {:>9.3f} {:>7.0f} {:>10.3g} {:>14.3g} {:>5}  {}\n", e.delay, 1e-3 * e.stiffness.mean,
               e.chatter, 1e6 * e.bounce, e.safePush, 1e-3 * 2.0 * damping / (period * (1.0 + 2.0 * e.delay)), e.lost,
               helpOf(e));
  fmt::print(
      "K_d: force of a push divided by its deepest point in 0.1 s, mean. Safe push: stays less than {:g} mm deep. "
      "Passive\nspring: the stiffest, 2 b / (T (1 + 2 d)), with the device's own damping b = {:.3g} N s/m.\n\n",
      1e3 * kSafeDepth, damping);
  if (withSpring) printSprings(expectations);
}

}  // namespace enamel::app
