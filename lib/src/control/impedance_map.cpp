#include "enamel/control/impedance_map.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "enamel/control/discretise.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kPushOnWall = 12.0;  // N
constexpr double kStill = 1e-12;      // m
constexpr double kRunaway = 1.0;      // m: it will not come back

// Largest minus smallest of the values seen.
struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void see(double value) { low = std::min(low, value), high = std::max(high, value); }
  double size() const { return high - low; }
};

}  // namespace

bool isWallStable(const WallDevice& device, const SpringWall& wall, double seconds) {
  for (const double value : {device.damping, wall.stiffness, wall.damping, seconds})
    if (!(value >= 0.0 && std::isfinite(value)))
      throw DesignError("wall: damping, stiffness and time must be finite and at least 0");
  if (!(device.mass > 0.0 && std::isfinite(device.mass) && device.period > 0.0 && std::isfinite(device.period)) ||
      wall.delay < 0)
    throw DesignError("wall: mass and period must be greater than 0, and the delay at least 0");
  if (seconds / device.period > 1e8 || wall.delay > 1000)
    throw DesignError("wall: the time must be at most 1e8 periods, and the delay at most 1000");
  StateSpace motion{Eigen::Matrix2d::Zero(), Eigen::Vector2d(1.0 / device.mass, 0.0)};  // states [z'; z], input force
  motion.A(0, 0) = -device.damping / device.mass;
  motion.A(1, 0) = 1.0;
  const StateSpace held = zeroOrderHold(motion, device.period);
  const Eigen::Matrix2d A = held.A;
  const Eigen::Vector2d B = held.B;

  Eigen::Vector2d state = Eigen::Vector2d::Zero();
  double previous = 0.0;
  std::deque<double> underWay(static_cast<std::size_t>(wall.delay), 0.0);
  const int ticks = static_cast<int>(seconds / device.period);
  Range middle, last;
  for (int j = 0; j < ticks; ++j) {
    const double z = state[1], rate = (z - previous) / device.period;
    previous = z;
    underWay.push_back(z < 0.0 ? -wall.stiffness * z - wall.damping * rate : 0.0);
    state = A * state + B * (underWay.front() - kPushOnWall);
    underWay.pop_front();
    if (!(std::abs(state[1]) < kRunaway)) return false;
    if (3 * j >= 2 * ticks)
      last.see(state[1]);
    else if (3 * j >= ticks)
      middle.see(state[1]);
  }
  return last.size() < kStill || last.size() < 0.5 * middle.size();
}

std::vector<WallStability> mapWallStability(const WallDevice& device, const std::vector<double>& stiffnesses,
                                            const std::vector<double>& dampings, const std::vector<int>& delays) {
  std::vector<WallStability> map;
  for (const int delay : delays)
    for (const double damping : dampings)
      for (const double stiffness : stiffnesses) {
        const SpringWall wall{stiffness, damping, delay};
        map.push_back({wall, isWallStable(device, wall)});
      }
  return map;
}

}  // namespace enamel
