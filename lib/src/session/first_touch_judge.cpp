#include "session/first_touch_judge.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "enamel/device/haptic_device.hpp"

namespace enamel::trial {
namespace {

constexpr int kMostDelay = 12;      // ticks
constexpr double kRateError = 0.3;  // of the way: low passes and lost samples change the sum of rates by less

// Return the advice after a fault of the guard. `isPushed`: forces acted.
const char* adviceOn(GuardReason fault, bool isPushed) noexcept {
  switch (fault) {
    case GuardReason::jump:
    case GuardReason::speed:
      return isPushed ? "unit of the forces, or did you let go?"
                      : "is the unit of the positions m, and that of the rates m/s?";
    case GuardReason::workspace:
    case GuardReason::unreachable: return "is the unit of the positions m, and their origin in the middle?";
    case GuardReason::renderer: return "is the unit of the rates m/s?";
    case GuardReason::measurement: return "the driver gives numbers that are not finite";
    case GuardReason::clock: return "the time stamps do not increase";
    case GuardReason::frozen: return "axis or unit of the rates, or a sensor that is broken?";
    case GuardReason::late:
    case GuardReason::deadlines: return "is this computer busy (lib/docs/device.md, \"Settings of the system\")?";
    case GuardReason::early: return "samples come more often than ticks: is --rate that of the device?";
    case GuardReason::energy:
    case GuardReason::oscillation: return "do the stated delay and the masses of the device file fit?";
    case GuardReason::device: return "check cable, power and the vendor's service";
    default: return "see lib/docs/guard.md";
  }
}

}  // namespace

const char* wordsOf(int direction) noexcept {
  constexpr const char* kWords[] = {"to the right",
                                    "up",
                                    "towards you",
                                    "so that its front end goes up",
                                    "so that its front end goes to the left",
                                    "so that its right side goes up"};
  return kWords[direction];
}

std::string text(const char* format, double a, double b, double c) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), format, a, b, c);
  return line.data();
}

std::string lengthText(double size, bool isTurn) {
  return isTurn ? text("%.1f deg", size * 180.0 / M_PI) : text("%.2f mm", 1e3 * size);
}

std::string forceText(double size, bool isTurn) { return text(isTurn ? "%.3g N m" : "%.1f N", size); }

void requireNoFault(GuardReason fault, const std::vector<Sample>& samples, bool needsForces) {
  for (const DeviceCondition each : {kForcesCut, kUncalibrated})
    for (const Sample& s : samples)
      if ((s.conditions & each) != 0) throw Surprise{std::string("the device reports: ") + toString(each)};
  if (fault != GuardReason::none)
    throw Surprise{std::string("the guard stopped the loop: ") + toString(fault) + "; " + adviceOn(fault, needsForces)};
  // In the last ticks the loop itself ramps out.
  const auto disabled = std::count_if(samples.begin(), samples.end(), [](const Sample& s) { return !s.isEnabled; });
  if (needsForces && 2 * static_cast<std::size_t>(disabled) > samples.size())
    throw Surprise{"the device is not enabled: press its force button, or hold its switch"};
}

void requireAlong(const Vec3& way, int direction, const std::string& what) {
  int main = 0;
  const double size = way.cwiseAbs().maxCoeff(&main);
  constexpr char kNames[] = {'x', 'y', 'z'};
  const bool turns = isTurn(direction);
  const std::string verb = turns ? " turned about " : " moved along ", words = wordsOf(direction);
  const int wanted = direction % 3;
  if (main != wanted)
    throw Surprise{what + verb + kNames[main] + " by " + lengthText(way[main], turns) + ", expected " + kNames[wanted] +
                   " (" + words + "): wrong axis"};
  if (way[wanted] < 0.0)
    throw Surprise{what + verb + kNames[wanted] + " by " + lengthText(-size, turns) + ", expected forwards (" + words +
                   "): wrong sign"};
}

void requireRates(const std::vector<Sample>& samples, bool isTurn, double period) {
  Vec3 sum = Vec3::Zero();
  for (const Sample& s : samples) sum += period * (isTurn ? s.rates.tail<3>() : s.rates.head<3>());
  const Vec6& end = samples.back().place;
  const Vec3 way = isTurn ? end.tail<3>() : end.head<3>();
  for (int i = 0; i < 3; ++i)
    if (std::abs(sum[i] - way[i]) > kRateError * way.norm())
      throw Surprise{"the rates along " + std::string(1, "xyz"[i]) + " add up to " + lengthText(sum[i], isTurn) +
                     ", the positions to " + lengthText(way[i], isTurn) + ": sign, axis or unit of the rates?"};
}

Fit fit(const std::vector<Sample>& samples, std::size_t first, std::size_t count, int direction, double step,
        const Vec6& drift, double period) {
  const auto motion = [&](std::size_t i) {
    return samples[first + i].place[direction] - samples[first].place[direction] -
           static_cast<double>(i) * drift[direction];
  };
  Fit best;
  double smallest = std::numeric_limits<double>::infinity();
  for (int d = 0; d <= kMostDelay; ++d) {
    Eigen::Vector4d once = Eigen::Vector4d::Zero(), twice = once;  // integrals of F, -x', -x and -1
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    double own = 0.0;
    for (std::size_t i = 1; i <= count; ++i) {
      const std::size_t now = first + i - 1, source = now - std::min(now, static_cast<std::size_t>(d));
      const double x = motion(i), before = motion(i - 1);
      const Eigen::Vector4d rate(samples[source].wrench[direction], 0.0, -0.5 * (x + before),
                                 std::abs(x) > step ? -1.0 : 0.0);
      twice += period * (once + 0.5 * period * rate);
      once += period * rate;
      twice[1] -= period * 0.5 * (x + before);
      normal += twice * twice.transpose();
      right += x * twice;
      own += x * x;
    }
    const Eigen::Vector4d solution = normal.ldlt().solve(right);
    const double residual = own - right.dot(solution);
    if (!(residual < smallest)) continue;
    smallest = residual;
    best = {1.0 / solution[0], d};
  }
  return best;
}

}  // namespace enamel::trial
