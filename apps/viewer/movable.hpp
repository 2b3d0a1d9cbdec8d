// Poses of the obstacles that move in a suspension, for drawing.
#pragma once

#include <array>
#include <optional>

#include "enamel/collision/scene.hpp"

namespace enamel::viewer {

/// The first obstacles with a suspension, in their order.
using MovablePoses = std::array<std::optional<Pose>, 8>;

/// Return the poses in the scene of a tick. Realtime: yes.
inline MovablePoses movablePoses(const Scene& scene) noexcept {
  MovablePoses poses;
  std::size_t count = 0;
  for (const Obstacle& obstacle : scene.obstacles())
    if (obstacle.suspension && count < poses.size()) poses[count++] = obstacle.pose;
  return poses;
}

}  // namespace enamel::viewer
