// Checks of mechanisms that only translate.
#pragma once

#include <cmath>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// Reject a rotated pose or a twist with rotation: the platform keeps the axes of W. The tolerance (1e-9, rad and
/// rad/s) covers rounding errors. Statuses: notFinite, unreachable. Realtime: yes.
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
