// Stability of a spring-damper wall that is rendered by a sampled and delayed force.
#pragma once

#include <vector>

namespace enamel {

/// The device along the normal of the wall.
struct WallDevice {
  double mass = 0.0;     ///< effective mass, kg
  double damping = 0.0;  ///< mechanical damping, N s/m
  double period = 0.0;   ///< sampling period, s
};

/// A rendered spring-damper: F = -stiffness z - damping z' for z < 0, otherwise 0. z' is a difference over one period.
struct SpringWall {
  double stiffness = 0.0;  ///< N/m
  double damping = 0.0;    ///< N s/m
  int delay = 0;           ///< from the measurement to the force, samples
};

/// Simulate a push of 12 N on the wall from rest on its surface, and return true if the motion decays. Realtime: no.
///
/// The motion decays if its range over the last third of `seconds` is below half of the range over the second third, or
/// below 1e-12 m. A tool that keeps bouncing without growth is not stable, and neither is one that leaves by 1 m. The
/// hold is an exact zero-order hold.
///
/// Throws DesignError:
/// - a parameter is negative or not finite;
/// - mass or period is zero;
/// - the time is more than 1e8 periods;
/// - the delay is outside 0 to 1000.
bool isWallStable(const WallDevice& device, const SpringWall& wall, double seconds = 3.0);

struct WallStability {
  SpringWall wall;
  bool stable = false;
};

/// Return the stability for every combination of the given values. Throws DesignError as isWallStable. Realtime: no.
std::vector<WallStability> mapWallStability(const WallDevice& device, const std::vector<double>& stiffnesses,
                                            const std::vector<double>& dampings, const std::vector<int>& delays);

}  // namespace enamel
