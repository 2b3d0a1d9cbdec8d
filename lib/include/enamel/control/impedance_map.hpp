// Where a spring-damper wall rendered by a sampled, delayed force is stable.
#pragma once

#include <vector>

namespace enamel {

/// The device as the wall feels it, along the normal.
struct WallDevice {
  double mass = 0.0;     ///< effective, kg
  double damping = 0.0;  ///< mechanical, N s/m
  double period = 0.0;   ///< s
};

/// A rendered spring-damper: F = -stiffness z - damping z' where z < 0, else 0; z' differenced over one period.
struct SpringWall {
  double stiffness = 0.0;  ///< N/m
  double damping = 0.0;    ///< N s/m
  int delay = 0;           ///< samples from the measurement to the force
};

/// Simulates a push of 12 N on the wall from rest on its surface and answers whether the motion dies out: over the last
/// third of `seconds` it is less than half of what it was over the second third, or less than 1e-12 m. A tool that
/// bounces on without growing is not stable. Exact zero-order hold.
/// Throws DesignError: a parameter negative, not finite, or mass or period zero; more than 1e8
/// periods; a delay outside 0 to 1000. Realtime: no.
bool isWallStable(const WallDevice& device, const SpringWall& wall, double seconds = 3.0);

struct WallStability {
  SpringWall wall;
  bool stable = false;
};

/// Every combination of the given values. Throws DesignError as isWallStable. Realtime: no.
std::vector<WallStability> mapWallStability(const WallDevice& device, const std::vector<double>& stiffnesses,
                                            const std::vector<double>& dampings, const std::vector<int>& delays);

}  // namespace enamel
