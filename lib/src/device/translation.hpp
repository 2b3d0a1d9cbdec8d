// What the mechanisms that only translate share.
#pragma once

#include <cmath>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// Refuses what a platform that keeps the axes of W cannot do: a turned pose, a turning twist. The tolerance (1e-9, rad
/// and rad/s) lets through the roundings of whoever made them. Statuses: notFinite, unreachable. Realtime: yes.
[[nodiscard]] inline Status requireTranslation(const Pose& pose, const Vec6& twist) noexcept {
  constexpr double tolerance = 1e-9;
  if (!pose.position.allFinite() || !pose.rotation.allFinite() || !twist.allFinite()) return Status::notFinite;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(twist[3 + i]) > tolerance) return Status::unreachable;
    for (int j = 0; j < 3; ++j)
      if (std::abs(pose.rotation(i, j) - (i == j ? 1.0 : 0.0)) > tolerance) return Status::unreachable;
  }
  return Status::ok;
}

}  // namespace enamel
